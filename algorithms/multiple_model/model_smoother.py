"""Fixed-interval smoother: a multiple-model filter says when the object manoeuvres, one smoothed filter does the rest.

1. The multiple-model filter runs forward. Where the models with the largest noise are more probable than `alarm`, the
   object manoeuvres; the interval is widened by `before_s`, because a filter notices late, and `after_s`.
2. One constant-acceleration filter runs forward with noise of the rate form: `manoeuvre_sigma_mps2` inside those
   intervals, `quiet_sigma_mps2` outside.
3. Its states are smoothed backward (`backward`).

The choice: smoothers that go back through every model, or every pair of models, meet the singular covariance of the
constant-velocity model, in which an acceleration of exactly zero is certain; the one for pairs leaves the arc by 14 km.
One model whose noise is known in time has nothing singular, and its answer is the exact conditional mean given the
intervals. Estimates use later rows: they are no picture of what a filter knew at the time.

Differences from the paper: it is not in it (specification, section 13, "after the fact").
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.multiple_model import mma2_122, states
from algorithms.multiple_model.answers import result_of, scores_of
from algorithms.multiple_model.backward import smooth_backward
from algorithms.multiple_model.bound import horizontal_bound
from algorithms.multiple_model.charts import MODELS_CHARTS
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import measure
from algorithms.multiple_model.multiple_model import MultipleModelParameters, check, models_of
from algorithms.multiple_model.outputs import OUTPUTS
from algorithms.multiple_model.parameters import NOISE_FORMS, RULES, ModelChoice
from algorithms.multiple_model.tables import tabulate
from algorithms.multiple_model.tracker import Filtered, ModelSet, run_bank
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, PartOfRun, Reference, RunContext, parameter

_USED = (states.UPDATED, states.STARTED, states.UNUSUAL, states.RESTARTED)


class ModelSmootherParameters(MultipleModelParameters):
    """Parameters of the smoother; those of the filter say when the object manoeuvres."""

    noise_form: Literal["step", "rate", "substeps"] = parameter(
        "step",
        title="Process noise",
        group="motion",
        choices=NOISE_FORMS,
    )
    """Of the filter that finds the manoeuvres; what is smoothed has noise of the rate form."""
    merging: Literal["moment", "max", "combined", "modified", "combined_sum", "modified_pair"] = parameter(
        "combined",
        title="Merging",
        group="motion",
        choices=RULES,
    )
    """The paper's rule and models: they tell a manoeuvre from an arc more sharply than the filter's own set."""
    models: tuple[ModelChoice, ...] = parameter(
        tuple(ModelChoice(kind=kind, sigma_mps2=sigma) for kind, sigma in mma2_122.MODELS),
        title="Models",
        group="motion",
        min_length=1,
        max_length=10,
    )
    """One filter for each; their order is that of the matrix."""
    transition: tuple[tuple[float, ...], ...] = parameter(
        mma2_122.TRANSITION,
        title="Transition probabilities",
        group="motion",
        min_length=1,
        max_length=10,
        labels_from="models",
        row_sum=1,
    )
    """From the row's model to the column's within the base interval; each row sums to 1."""
    quiet_sigma_mps2: float = parameter(0.05, title="Quiet noise", unit="m/s²", group="smoothing", gt=0, le=1000)
    """Of the step form at the base interval."""
    manoeuvre_sigma_mps2: float = parameter(
        30.0, title="Manoeuvring noise", unit="m/s²", group="smoothing", gt=0, le=1000
    )
    """Of the step form at the base interval, where the object manoeuvres."""
    alarm: float = parameter(0.5, title="Alarm", unit="1", group="smoothing", gt=0, lt=1)
    """The object manoeuvres where the models with the largest noise are more probable than this."""
    before_s: float = parameter(3.0, title="Widened before", unit="s", group="smoothing", ge=0, le=1000)
    """A filter notices a manoeuvre late."""
    after_s: float = parameter(0.5, title="Widened after", unit="s", group="smoothing", ge=0, le=1000)
    """So long after the last alarm the noise stays."""


def manoeuvring(time_s: Floats, noisy: Floats, alarm: float, before_s: float, after_s: float) -> NDArray[np.bool_]:
    """(M, L): whether a row lies in a widened alarm; `noisy` (M, L) is the probability of the noisy models."""
    out = np.zeros(noisy.shape, bool)
    first = np.searchsorted(time_s, time_s - after_s, side="left")
    stop = np.searchsorted(time_s, time_s + before_s, side="right")
    # A row is inside where an alarm lies between `after_s` earlier and `before_s` later.
    count = np.concatenate([np.zeros((1, noisy.shape[1])), np.cumsum(np.nan_to_num(noisy) > alarm, axis=0)])
    out[:] = count[stop] > count[first]
    return out


def _smoothed(recording: Plots, parameters: ModelSmootherParameters, context: RunContext, *, lean: bool) -> Filtered:
    """Filter twice and go back; the report is the multiple-model filter's with other states, covariances and NIS."""
    chosen = models_of(parameters)
    first, second = PartOfRun(context, 0.0, 0.5), PartOfRun(context, 0.5, 1.0)
    found = run_bank(recording, parameters, chosen, first, lean=lean)
    sigma = np.array([s for _, s in chosen.models])
    noisy = found.report.probability[:, sigma >= sigma.max()].sum(axis=1)
    single = ModelSet((("ca", parameters.quiet_sigma_mps2),), step_s=chosen.step_s)
    ratio = parameters.manoeuvre_sigma_mps2 / parameters.quiet_sigma_mps2
    boost = np.ones(noisy.shape)
    for target in range(len(recording.targets)):
        rows = recording.rows_of(target)
        inside = manoeuvring(
            recording.time_s[rows], noisy[rows], parameters.alarm, parameters.before_s, parameters.after_s
        )
        boost[rows] = np.where(inside, ratio, 1.0)
    forward = run_bank(
        recording, parameters.model_copy(update={"noise_form": "rate"}), single, second, lean=False, boost=boost
    )
    report = forward.report
    density = (parameters.quiet_sigma_mps2 * boost) ** 2 / chosen.step_s
    state, covariance = report.state.copy(), report.covariance.copy()
    for target in range(len(recording.targets)):
        context.check_cancelled()
        rows = recording.rows_of(target)
        used = np.isin(report.status[rows], _USED)
        state[rows], covariance[rows] = smooth_backward(
            recording.time_s[rows], report.state[rows], report.covariance[rows], report.track[rows], used, density[rows]
        )
    if lean:
        places = [3 * a * (3 * a + 1) // 2 + 3 * b for a in range(3) for b in range(a + 1)]
        covariance = np.ascontiguousarray(covariance[:, places])
    kept = report._replace(
        state=state, covariance=covariance, probability=found.report.probability,
        model_state=found.report.model_state, likelihood=found.report.likelihood,
    )  # fmt: skip
    return replace(found, report=kept)


def run(recording: Plots, parameters: ModelSmootherParameters, context: RunContext) -> Result:
    """Smooth every target of a recording."""
    return result_of(recording, models_of(parameters), _smoothed(recording, parameters, context, lean=False))


def score(recording: Plots, parameters: ModelSmootherParameters, context: RunContext) -> Scores:
    """Smooth simulated trials and score them against the truth."""
    found = _smoothed(recording, parameters, context, lean=True)
    return scores_of(recording, parameters, models_of(parameters), found)


def bound(recording: Plots, parameters: ModelSmootherParameters) -> Floats | None:
    """Bound of a filter: a smoother, which knows later rows, may lie below it."""
    return horizontal_bound(recording, parameters)


ALGORITHM = Algorithm(
    name="model_smoother",
    title="Smoother with several models",
    summary="Looks back from the end: several models find the manoeuvres, one filter is smoothed through them.",
    family="multiple_model",
    takes=("antenna_plots", "polar_plots"),
    parameters=ModelSmootherParameters,
    outputs=OUTPUTS,
    charts=MODELS_CHARTS,
    references=(Reference("barshalom2001", "sec. 8.6"), Reference("blom1988")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
    check=check,
)
