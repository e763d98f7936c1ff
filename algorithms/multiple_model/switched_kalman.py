"""One Kalman filter whose noise a manoeuvre detector switches: the traditional rival of several models.

The detector is a fading memory of the normalised innovation squared per degree of freedom, u = f u + (1 - f) nis / dof.
Above `alarm` the model takes its manoeuvring noise, below `calm` the quiet one again.

Differences from the paper: it is not in it (barshalom2001, section 11.2).
"""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator

from algorithms.multiple_model.answers import run_models, score_models
from algorithms.multiple_model.bound import horizontal_bound
from algorithms.multiple_model.charts import PLAIN_CHARTS
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import measure
from algorithms.multiple_model.outputs import OUTPUTS
from algorithms.multiple_model.parameters import MotionParameters
from algorithms.multiple_model.tables import tabulate
from algorithms.multiple_model.tracker import Detector, ModelSet
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter


class SwitchedKalmanParameters(MotionParameters):
    """Parameters of the switched filter."""

    kind: Literal["cv", "ca"] = parameter(
        "ca",
        title="Model",
        group="motion",
        choices={"cv": "constant velocity", "ca": "constant acceleration"},
    )
    """What the target is thought to do."""
    quiet_sigma_mps2: float = parameter(0.05, title="Quiet noise", unit="m/s²", group="motion", gt=0, le=1000)
    """Of the step form at the base interval."""
    manoeuvre_sigma_mps2: float = parameter(30.0, title="Manoeuvring noise", unit="m/s²", group="motion", gt=0, le=1000)
    """Of the step form at the base interval, after an alarm."""
    base_interval_s: float = parameter(0.05, title="Base interval", unit="s", group="motion", gt=0, le=1e4)
    """At which noise of the rate form equals that of a step."""
    fading: float = parameter(0.9, title="Fading", unit="1", group="motion", ge=0.01, le=0.999)
    """Share of the detector's memory that lives through a measurement."""
    alarm: float = parameter(2.0, title="Alarm", unit="1", group="motion", gt=0, le=1000)
    """Above it the target manoeuvres; 1 is what an undisturbed filter has on average."""
    calm: float = parameter(1.0, title="Calm", unit="1", group="motion", gt=0, le=1000)
    """Below it the manoeuvre is over."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.calm > self.alarm:
            raise ValueError("calm must not lie above alarm")
        return self


def _parts(parameters: SwitchedKalmanParameters) -> tuple[ModelSet, Detector]:
    quiet = parameters.quiet_sigma_mps2
    chosen = ModelSet(((parameters.kind, quiet),), step_s=parameters.base_interval_s)
    boost = parameters.manoeuvre_sigma_mps2 / quiet
    return chosen, Detector(parameters.fading, parameters.alarm, parameters.calm, boost)


def run(recording: Plots, parameters: SwitchedKalmanParameters, context: RunContext) -> Result:
    """Filter every target of a recording."""
    chosen, detector = _parts(parameters)
    return run_models(recording, parameters, chosen, context, detector)


def score(recording: Plots, parameters: SwitchedKalmanParameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    chosen, detector = _parts(parameters)
    return score_models(recording, parameters, chosen, context, detector)


def bound(recording: Plots, parameters: SwitchedKalmanParameters) -> Floats | None:
    """Posterior Cramer-Rao bound of the rms horizontal error, the manoeuvre known."""
    return horizontal_bound(recording, parameters)


ALGORITHM = Algorithm(
    name="switched_kalman",
    title="Kalman filter with a manoeuvre detector",
    summary="One filter whose noise is raised while its innovations are too large: the traditional rival.",
    family="multiple_model",
    takes=("antenna_plots", "polar_plots"),
    parameters=SwitchedKalmanParameters,
    outputs=OUTPUTS,
    charts=PLAIN_CHARTS,
    references=(Reference("barshalom2001", "sec. 11.2"),),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
