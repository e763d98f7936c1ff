"""MMA2-11: quiet and noisy constant velocity.

Differences from the paper: those of `mma2_122`.
"""

from __future__ import annotations

from algorithms.multiple_model.answers import run_models, score_models
from algorithms.multiple_model.bound import horizontal_bound
from algorithms.multiple_model.charts import MODELS_CHARTS
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import measure
from algorithms.multiple_model.outputs import OUTPUTS
from algorithms.multiple_model.parameters import PaperParameters
from algorithms.multiple_model.tables import tabulate
from algorithms.multiple_model.tracker import ModelSet
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext

MODELS = (("cv", 5.0), ("cv", 30.0))
TRANSITION = ((0.995, 0.005), (0.01, 0.99))
STEP_S = 0.05


class Mma211Parameters(PaperParameters):
    """Parameters of MMA2-11."""


def models_of(parameters: Mma211Parameters) -> ModelSet:
    """Return the models and how they are merged."""
    return ModelSet(MODELS, TRANSITION, STEP_S, parameters.structure, parameters.merging, parameters.output)


def run(recording: Plots, parameters: Mma211Parameters, context: RunContext) -> Result:
    """Filter every target of a recording."""
    return run_models(recording, parameters, models_of(parameters), context)


def score(recording: Plots, parameters: Mma211Parameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_models(recording, parameters, models_of(parameters), context)


def bound(recording: Plots, parameters: Mma211Parameters) -> Floats | None:
    """Posterior Cramer-Rao bound of the rms horizontal error, the manoeuvre known."""
    return horizontal_bound(recording, parameters)


ALGORITHM = Algorithm(
    name="mma2_11",
    title="Two models (MMA2-11)",
    summary="Two constant-velocity models, quiet and noisy, merged by the paper's combined rule.",
    family="multiple_model",
    takes=("antenna_plots", "polar_plots"),
    parameters=Mma211Parameters,
    outputs=OUTPUTS,
    charts=MODELS_CHARTS,
    references=(Reference("trudymai2023", "section 3"), Reference("blom1988")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
