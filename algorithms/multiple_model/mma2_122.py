"""MMA2-122: quiet constant velocity, quiet and noisy constant acceleration.

Differences from the paper: it leaves out initiation, long gaps and ties (see
`parameters`, `merging`); its matrix is printed with columns that sum to 1, here rows do. With `merging` = moment this
is the textbook IMM.
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

MODELS = (("cv", 0.05), ("ca", 0.05), ("ca", 30.0))
TRANSITION = ((0.996, 0.0, 0.004), (0.0, 0.996, 0.004), (0.002, 0.002, 0.996))
STEP_S = 0.05


class Mma2Parameters(PaperParameters):
    """Parameters of MMA2-122."""


def models_of(parameters: Mma2Parameters) -> ModelSet:
    """Return the models and how they are merged."""
    return ModelSet(MODELS, TRANSITION, STEP_S, parameters.structure, parameters.merging, parameters.output)


def run(recording: Plots, parameters: Mma2Parameters, context: RunContext) -> Result:
    """Filter every target of a recording."""
    return run_models(recording, parameters, models_of(parameters), context)


def score(recording: Plots, parameters: Mma2Parameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_models(recording, parameters, models_of(parameters), context)


def bound(recording: Plots, parameters: Mma2Parameters) -> Floats | None:
    """Posterior Cramer-Rao bound of the rms horizontal error, the manoeuvre known."""
    return horizontal_bound(recording, parameters)


ALGORITHM = Algorithm(
    name="mma2_122",
    title="Three models (MMA2-122)",
    summary="The paper's best: constant velocity, quiet and noisy constant acceleration, merged by its combined rule.",
    family="multiple_model",
    takes=("antenna_plots", "polar_plots"),
    parameters=Mma2Parameters,
    outputs=OUTPUTS,
    charts=MODELS_CHARTS,
    references=(Reference("trudymai2023", "section 3"), Reference("blom1988")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
