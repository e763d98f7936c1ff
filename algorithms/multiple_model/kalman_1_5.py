"""Kalman-1 5: one constant velocity model with noise 5 m/s2 a step.

Differences from the paper: initiation and long gaps are ours (see `parameters`).
"""

from __future__ import annotations

from algorithms.multiple_model.answers import run_models, score_models
from algorithms.multiple_model.bound import horizontal_bound
from algorithms.multiple_model.charts import PLAIN_CHARTS
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import measure
from algorithms.multiple_model.outputs import OUTPUTS
from algorithms.multiple_model.parameters import PaperKalmanParameters
from algorithms.multiple_model.tables import tabulate
from algorithms.multiple_model.tracker import ModelSet
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext


class Kalman15Parameters(PaperKalmanParameters):
    """Parameters of Kalman-1 5."""


def models_of(parameters: Kalman15Parameters) -> ModelSet:
    """Return the models and how they are merged."""
    return ModelSet((("cv", 5.0),))


def run(recording: Plots, parameters: Kalman15Parameters, context: RunContext) -> Result:
    """Filter every target of a recording."""
    return run_models(recording, parameters, models_of(parameters), context)


def score(recording: Plots, parameters: Kalman15Parameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_models(recording, parameters, models_of(parameters), context)


def bound(recording: Plots, parameters: Kalman15Parameters) -> Floats | None:
    """Posterior Cramer-Rao bound of the rms horizontal error, the manoeuvre known."""
    return horizontal_bound(recording, parameters)


ALGORITHM = Algorithm(
    name="kalman_1_5",
    title="Kalman filter, constant velocity, 5 m/s² (Kalman-1 5)",
    summary="One Kalman filter with constant velocity and noise of 5 m/s² a step.",
    family="multiple_model",
    takes=("antenna_plots", "polar_plots"),
    parameters=Kalman15Parameters,
    outputs=OUTPUTS,
    charts=PLAIN_CHARTS,
    references=(Reference("trudymai2023", "section 3"), Reference("barshalom2001")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
