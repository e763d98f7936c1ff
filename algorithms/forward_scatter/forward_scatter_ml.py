"""Maximum likelihood of crossing time, distance and velocity from all Dopplers so far: the recommended method.

Works with the true places of any site, two to four Dopplers, irregular times and missing values. Where it does not
converge or ends at the end of the base line, formula (19) takes its place, where the site allows it.

Differences from the paper: it has no such estimator. The velocity along the base line is unknown by default: fixed at
zero while the course is slanted, the fit is very precise and very wrong (specification 8.4).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from algorithms.errors import RecordingError
from algorithms.forward_scatter import fit, outputs, sequence
from algorithms.forward_scatter.bound import position_bound
from algorithms.forward_scatter.conditions import LEAST_SPACING_M, Conditions, Pair, conditions_of, pairs_of
from algorithms.forward_scatter.estimate import RIDGE, estimate, held_where_thinned, without_one_receiver
from algorithms.forward_scatter.likelihood import LEAST_DISTANCE_M, Problem
from algorithms.forward_scatter.lines import ROBUST
from algorithms.forward_scatter.lines_method import answer_of, follow_pair, joined
from algorithms.forward_scatter.measures import measure
from algorithms.forward_scatter.outputs import OUTPUTS
from algorithms.forward_scatter.parameters import ScatterParameters
from algorithms.forward_scatter.piece import Arrays, Piece
from algorithms.forward_scatter.profile import NORMAL_95
from algorithms.forward_scatter.scoring import score_with
from algorithms.forward_scatter.sensitivity import calibration_tables
from algorithms.forward_scatter.tables import tabulate
from algorithms.recording import DopplerPairs
from algorithms.result import Note, Result, Table
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter

# A fit at every epoch costs the square of their number: a longer pass is fitted at so many instants.
MOST_FITS = 1000
# Trials and epochs between two questions whether the run was cancelled.
SLICE = 400
# An acceleration that was not found, and would widen the error of the distance by so much, makes it a lower bound.
OPEN_RATIO = 1.25

_STATUS = np.array([outputs.INSUFFICIENT, outputs.NO_CROSSING, outputs.NOT_CONVERGED, outputs.AT_BOUND, outputs.FITTED])


class LikelihoodParameters(ScatterParameters):
    """Parameters of the maximum-likelihood fit."""

    unknowns: Literal[3, 4, 5] = parameter(
        4,
        title="Unknowns",
        symbol="P",
        group="motion",
        choices={
            "3": "the course is across the base line",
            "4": "course unknown",
            "5": "course and acceleration unknown",
        },
    )
    """Crossing time, distance, velocity across; velocity along the base line; acceleration across it."""
    acceleration_switch: bool = parameter(True, title="Switch to an acceleration", group="motion")
    """With four unknowns: take the fifth where it lowers chi2 / 2 by more than 4."""
    sigma_velocity_along_mps: float | None = parameter(
        150.0, title="Expected velocity along", unit="m/s", symbol="σ_vx", group="motion", advanced=True, gt=0, le=1e5
    )
    """Weak prior of the velocity along the base line; it matters only early; null in the JSON form = none."""
    sigma_acceleration_mps2: float = parameter(
        1.5, title="Expected acceleration", unit="m/s²", symbol="σ_a", group="motion", advanced=True, gt=0, le=1e3
    )
    """Prior of the acceleration across the base line."""
    robust: Literal["none", "huber", "consensus"] = parameter(
        "none",
        title="False values",
        group="association",
        choices={
            "none": "least squares",
            "huber": "large residuals weigh less",
            "consensus": "a line most values agree on, then Huber, then what lies within 4 sigma",
        },
    )
    """How false Dopplers are kept out."""


def problem_of(piece: Piece, parameters: LikelihoodParameters, conditions: Conditions) -> Problem:
    """Return what is measured and known of a pass."""
    along = parameters.sigma_velocity_along_mps
    return Problem(
        time=piece.time,
        feet=conditions.feet,
        wavelength=conditions.wavelength,
        sigma=conditions.sigma,
        altitude=conditions.altitude,
        a=conditions.a,
        prior_x=0.0 if along is None else 1.0 / along**2,
        prior_a=1.0 / parameters.sigma_acceleration_mps2**2,
    )


def run(recording: DopplerPairs, parameters: LikelihoodParameters, context: RunContext) -> Result:
    """Fit every pass of a recording at each of its rows.

    Raises
    ------
    RecordingError
        No site, one that does not fit, one Doppler only, or both receivers at one place.
    """
    conditions = conditions_of(recording, parameters)
    if len(conditions.feet) < 2 or np.ptp(conditions.feet, axis=0).max() < LEAST_SPACING_M:
        pairs_of(conditions)
    pairs = _pairs_for_fallback(conditions)
    unknowns = parameters.unknowns
    wanted = fit.SWITCH if unknowns == 4 and parameters.acceleration_switch else unknowns
    robust = ROBUST.index(parameters.robust)
    thinned = unseen = 0

    def method(piece: Piece, arrays: Arrays) -> None:
        nonlocal thinned, unseen
        epochs = piece.time.size
        stride = -(-epochs // MOST_FITS)
        f = np.ascontiguousarray(piece.doppler.transpose(1, 0, 2))
        channels, _, lanes = f.shape
        out = fit.fits(epochs, channels, lanes)
        carried = np.zeros((lanes, 6))
        problem = problem_of(piece, parameters, conditions)
        if stride > 1:
            thinned += epochs if 0 in piece.lanes else 0
            instants = sorted({*range(0, epochs, stride), epochs - 1})
            for k in instants:
                context.check_cancelled()
                fit.fit_pass(f, problem, k, k + 1, wanted, robust, carried, out)
        else:
            step = max(1, SLICE // lanes)
            for begin in range(0, epochs, step):
                context.check_cancelled()
                fit.fit_pass(f, problem, begin, min(begin + step, epochs), wanted, robust, carried, out)
        piece.put(arrays, "status", _STATUS[out.status])
        piece.put(arrays, "theta", out.theta)
        piece.put(arrays, "theta_covariance", out.covariance)
        piece.put(arrays, RIDGE, out.spread)
        piece.put(arrays, "distance_interval_m", out.ends)
        piece.put(arrays, "chi2", out.chi2)
        piece.put(arrays, "dof", out.dof)
        piece.put(arrays, "used", out.used.transpose(1, 0, 2))
        # Trials of simulated errors of calibration stand behind an empty first one.
        unseen += int(0 in piece.lanes and _acceleration_open(out, int(np.flatnonzero(piece.lanes == 0)[0])))
        if stride > 1:
            held_where_thinned(piece, arrays, stride)
        without_one_receiver(piece, arrays)
        if pairs:
            _fall_back(piece, pairs, conditions, arrays)

    arrays, notes = estimate(recording, conditions, parameters, context, method)
    if thinned:
        text = (
            f"A pass of more than {MOST_FITS} rows is fitted at that many of them; the rows between hold the last fit."
        )
        notes = (*notes, Note("fits_thinned", text, thinned))
    if unseen:
        text = (
            "An acceleration that these Dopplers cannot show would widen the error of the distance by more than a "
            "quarter: of a target that may accelerate the interval is a lower bound."
        )
        notes = (*notes, Note("acceleration_open", text, unseen))
    fallbacks = int((arrays["status"] == outputs.FALLBACK).sum())
    if fallbacks:
        text = (
            "Where the fit did not converge or ended at an end of the base line, formula (19) gave the place; its "
            "interval is a lower bound."
        )
        notes = (*notes, Note("formula_19", text, fallbacks))
    return Result(arrays, notes, conditions.settings)


def _acceleration_open(out: fit.Fits, lane: int) -> bool:
    """Whether the last fit of a pass would know the distance much worse were an acceleration unknown too."""
    fitted = np.flatnonzero(out.status[:, lane] == fit.FITTED)
    if not fitted.size:
        return False
    last = int(fitted[-1])
    return bool(out.open_variance[last, lane] > OPEN_RATIO**2 * out.covariance[last, 1, 1, lane])


def _pairs_for_fallback(conditions: Conditions) -> list[Pair]:
    """Pairs for formula (19), none where the site does not allow the closed form."""
    try:
        return pairs_of(conditions)[0]
    except RecordingError:
        return []


def _fall_back(piece: Piece, pairs: list[Pair], conditions: Conditions, arrays: Arrays) -> None:
    """Put the answer of formula (19) where the fit has none."""
    status = arrays["status"][np.ix_(piece.rows, piece.lanes)]
    failed = (status == outputs.NOT_CONVERGED) | (status == outputs.AT_BOUND)
    options = sequence.Options(
        window=10, rule=1, delay=0, confirm=1, formula=19, omega=0, robust=0, curvature=False, from_start=False,
        sigma=conditions.sigma, sigma_rate=0.0, a=conditions.a, b=1.0, wavelength=conditions.wavelength,
    )  # fmt: skip
    found = [follow_pair(piece, pair, options) for pair in pairs]
    answer = joined([answer_of(one, pair, conditions.a) for one, pair in zip(found, pairs, strict=True)], conditions.a)
    usable = failed & np.isin(answer.status, outputs.ANSWERED)
    if not usable.any():
        return
    theta = np.asarray(arrays["theta"], float)
    spread = np.asarray(arrays["theta_covariance"], float)
    ends = np.asarray(arrays["distance_interval_m"], float)
    for k, lane in zip(*np.nonzero(usable), strict=True):
        row, trial = piece.rows[k], piece.lanes[lane]
        theta[row, :, trial] = answer.theta[k, :, lane]
        spread[row, :, :, trial] = answer.covariance[k, :, :, lane]
        s, sd = answer.theta[k, 1, lane], np.sqrt(answer.covariance[k, 1, 1, lane])
        # The formula's own error vanishes at the ends of the base line; what the likelihood allows does not.
        low, high = np.fmin(ends[row, 0, trial], s - NORMAL_95 * sd), np.fmax(ends[row, 1, trial], s + NORMAL_95 * sd)
        low, high = min(max(low, LEAST_DISTANCE_M), s), max(min(high, conditions.a - LEAST_DISTANCE_M), s)
        ends[row, :, trial] = low, high
        spread[row, :, :, trial] *= max(1.0, max(s - low, high - s) / (NORMAL_95 * sd)) ** 2
        arrays[RIDGE][row, :, :, trial] = np.nan
        arrays["status"][row, trial] = outputs.FALLBACK


def score(recording: DopplerPairs, parameters: LikelihoodParameters, context: RunContext) -> Scores:
    """Fit simulated passes and score them against the truth."""
    return score_with(run, recording, parameters, context)


def bound(recording: DopplerPairs, parameters: LikelihoodParameters) -> Floats | None:
    """Cramer-Rao bound of the rms horizontal error at each row."""
    conditions = conditions_of(recording, parameters)
    return position_bound(recording, conditions, parameters.unknowns)


def _tables(recording: DopplerPairs, result: Result) -> dict[str, Table]:
    return tabulate(recording, result) | calibration_tables(run, LikelihoodParameters, recording, result)


ALGORITHM = Algorithm(
    name="forward_scatter_ml",
    title="Maximum likelihood of the crossing",
    summary="All Dopplers so far against the exact model: crossing time, distance and velocity with course unknown, "
    "and an acceleration where the data ask for one. The recommended method.",
    family="forward_scatter",
    recommended=True,
    takes=("doppler_pairs",),
    parameters=LikelihoodParameters,
    outputs=OUTPUTS,
    charts=(
        "base_plan",
        "crossing",
        "doppler_residuals",
        "doppler_lines",
        "sensitivity",
        "base_bound",
        "plan",
        "trials_crossing",
        "trials_range",
        "trials_crossing_sweep",
        "trials_paths",
    ),
    references=(Reference("scatter2014", "sec. 2"), Reference("more1978"), Reference("barshalom2001", "sec. 2.3")),
    run=run,
    tabulate=_tables,
    measure=measure,
    score=score,
    bound=bound,
)
