"""Multiple-model filter over any list of models, transition matrix, regions, structure and merging rule.

The default set is ours: constant velocity, free flight under gravity and drag, quiet and noisy constant acceleration,
merged by moments, with noise of the rate form and measurements in their own coordinates. A physically right quiet model
is what makes the textbook's rule the best one (docs/methods/multiple_model.md).

Differences from the paper: models, measurement, noise form, merging and answer of the default are not its own; regions
with matrices of their own and powers of the matrix that are not whole are not in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, Self

from pydantic import model_validator

from algorithms.multiple_model.answers import run_models, score_models
from algorithms.multiple_model.bound import horizontal_bound
from algorithms.multiple_model.charts import MODELS_CHARTS
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import measure
from algorithms.multiple_model.outputs import OUTPUTS
from algorithms.multiple_model.parameters import MergingParameters, ModelChoice, Region, check_polygons
from algorithms.multiple_model.tables import tabulate
from algorithms.multiple_model.tracker import ModelSet, bank_of, check_intervals
from algorithms.recording import Recording
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter

MODELS = (
    ModelChoice(kind="cv", sigma_mps2=0.5),
    ModelChoice(kind="gd", sigma_mps2=1.0),
    ModelChoice(kind="ca", sigma_mps2=0.05),
    ModelChoice(kind="ca", sigma_mps2=30.0),
)
TRANSITION = (
    (0.999, 0.0, 0.0, 0.001),
    (0.0, 0.999, 0.0, 0.001),
    (0.0, 0.0, 0.999, 0.001),
    (0.005, 0.005, 0.005, 0.985),
)
STEP_S = 0.05

# Surface craft turn at a few m/s2 and have no vertical motion; scans come every second or two.
SURFACE_MODELS = (("cv", 0.1), ("ca", 0.3), ("cv", 3.0))
SURFACE_TRANSITION = ((0.94, 0.03, 0.03), (0.05, 0.9, 0.05), (0.05, 0.05, 0.9))
SURFACE_STEP_S = 1.0


class MultipleModelParameters(MergingParameters):
    """Parameters of the multiple-model filter."""

    model_set: Literal["listed", "surface"] = parameter(
        "listed",
        title="Model set",
        group="motion",
        choices={
            "listed": "the models and the matrix below",
            "surface": "surface craft: constant velocity, quiet and agile, and constant acceleration; its own matrix",
        },
    )
    """A set replaces models, matrix and base interval."""
    models: tuple[ModelChoice, ...] = parameter(MODELS, title="Models", group="motion", min_length=1, max_length=10)
    """One filter for each; their order is that of the matrix."""
    transition: tuple[tuple[float, ...], ...] = parameter(
        TRANSITION,
        title="Transition probabilities",
        group="motion",
        min_length=1,
        max_length=10,
        labels_from="models",
        row_sum=1,
    )
    """From the row's model to the column's within the base interval; each row sums to 1."""
    transition_step_s: float = parameter(STEP_S, title="Base interval", unit="s", group="motion", gt=0, le=1e4)
    """For which the transition probabilities are given, and at which the noise is that of a step."""
    regions: tuple[Region, ...] = parameter((), title="Regions", group="motion", advanced=True, max_length=20)
    """Where other transition probabilities hold: the first region that holds the last estimate counts."""

    @model_validator(mode="after")
    def _one_set(self) -> Self:
        listed = {"models", "transition", "transition_step_s", "regions"} & self.model_fields_set
        if self.model_set != "listed" and listed:
            raise ValueError(
                f"the set {self.model_set} brings its own models and matrix; leave out {', '.join(sorted(listed))}"
            )
        return self

    @model_validator(mode="after")
    def _chains(self) -> Self:
        """A polygon or a matrix that is none is refused before a run, with its region or its row."""
        check_polygons(self.regions)
        bank_of(models_of(self), self)
        return self


def models_of(parameters: MultipleModelParameters) -> ModelSet:
    """Return the models and how they are merged."""
    if parameters.model_set == "surface":
        return ModelSet(
            SURFACE_MODELS, SURFACE_TRANSITION, SURFACE_STEP_S, parameters.structure, parameters.merging,
            parameters.output,
        )  # fmt: skip
    return ModelSet(
        tuple((m.kind, m.sigma_mps2) for m in parameters.models), parameters.transition, parameters.transition_step_s,
        parameters.structure, parameters.merging, parameters.output, parameters.regions,
    )  # fmt: skip


def run(recording: Plots, parameters: MultipleModelParameters, context: RunContext) -> Result:
    """Filter every target of a recording."""
    return run_models(recording, parameters, models_of(parameters), context)


def score(recording: Plots, parameters: MultipleModelParameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_models(recording, parameters, models_of(parameters), context)


def check(parameters: MultipleModelParameters, get: Callable[[], Recording]) -> None:
    """Refuse a transition matrix that has no power for the recording's intervals; our own ones have all."""
    if {"transition", "regions"} & parameters.model_fields_set:
        check_intervals(get(), bank_of(models_of(parameters), parameters))


def bound(recording: Plots, parameters: MultipleModelParameters) -> Floats | None:
    """Posterior Cramer-Rao bound of the rms horizontal error, the manoeuvre known."""
    return horizontal_bound(recording, parameters)


ALGORITHM = Algorithm(
    name="multiple_model",
    title="Multiple-model filter",
    summary="Any models, transition matrix and merging rule; by default straight and free flight, quiet and "
    "noisy constant acceleration.",
    family="multiple_model",
    recommended=True,
    takes=("antenna_plots", "polar_plots"),
    parameters=MultipleModelParameters,
    outputs=OUTPUTS,
    charts=MODELS_CHARTS,
    references=(Reference("trudymai2023"), Reference("blom1988"), Reference("barshalom2001", "sec. 11.6")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
    check=check,
)
