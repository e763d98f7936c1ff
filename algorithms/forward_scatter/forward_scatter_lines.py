"""The paper's algorithm: straight lines through the last Dopplers of two receivers, crossing times, closed form.

Differences from the paper: what is frozen, and when, is said (rules a, b, c, none); formula (17) counts its times from
the window's centre unless told otherwise, because as printed it depends on the origin of time; an estimate whose
omega D is not positive has a status and no place; predicted errors; robust lines; curvature correction.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from algorithms.forward_scatter import sequence
from algorithms.forward_scatter.conditions import Conditions, conditions_of, pairs_of
from algorithms.forward_scatter.estimate import estimate
from algorithms.forward_scatter.freeze import RULES
from algorithms.forward_scatter.lines import ROBUST
from algorithms.forward_scatter.lines_method import answer_of, follow_pair, joined, put_answer
from algorithms.forward_scatter.measures import measure
from algorithms.forward_scatter.outputs import LINE_OUTPUTS
from algorithms.forward_scatter.parameters import FreezeParameters, ScatterParameters
from algorithms.forward_scatter.piece import Arrays, Piece
from algorithms.forward_scatter.scoring import score_with
from algorithms.forward_scatter.sensitivity import calibration_tables
from algorithms.forward_scatter.tables import tabulate
from algorithms.recording import DopplerPairs
from algorithms.result import Note, Result, Table
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter

# The window's span may exceed this many times N intervals before its line is called doubtful.
LONGEST_SPAN = 3.0
# |D| below so many of its standard deviations says little about s.
LEAST_D_SIGMA = 3.0


class LinesParameters(ScatterParameters, FreezeParameters):
    """Parameters of the closed form."""

    formula: Literal[14, 17, 18, 19] = parameter(
        14,
        title="Formula",
        group="motion",
        choices={
            "14": "angular velocity and crossing times",
            "17": "slopes and crossing times, as printed",
            "18": "mean slope and crossing times",
            "19": "mean slope and angular velocity",
        },
    )
    """Formula of the paper for the crossing distance."""
    formula_17_origin: Literal["window", "start"] = parameter(
        "window",
        title="Origin of time in (17)",
        group="motion",
        advanced=True,
        choices={"window": "centre of the window", "start": "first instant, as printed"},
    )
    """From where (17) counts its times; its answer depends on it."""
    omega: Literal["lines", "mean_difference", "mean_of_all"] = parameter(
        "lines",
        title="Angular velocity from",
        group="motion",
        advanced=True,
        choices={
            "lines": "the two lines",
            "mean_difference": "the mean difference of the pairs in the window",
            "mean_of_all": "the mean difference of all pairs so far",
        },
    )
    """The first two differ where values are missing only; all pairs have less noise and more curvature."""
    curvature_correction: bool = parameter(False, title="Curvature correction", group="motion", advanced=True)
    """Allow for the angular velocity being smaller beside the base line."""


def options_of(parameters: LinesParameters, conditions: Conditions) -> sequence.Options:
    """Return what the kernel is told; the base and the error belong to a pair of Dopplers."""
    return sequence.Options(
        window=parameters.window,
        rule=RULES.index(parameters.freeze_rule),
        delay=parameters.freeze_delay,
        confirm=parameters.confirm,
        formula=parameters.formula,
        omega=("lines", "mean_difference", "mean_of_all").index(parameters.omega),
        robust=ROBUST.index(parameters.robust),
        curvature=parameters.curvature_correction,
        from_start=parameters.formula_17_origin == "start",
        sigma=conditions.sigma,
        sigma_rate=float(parameters.sigma_doppler_rate_hz_s or 0.0),
        a=conditions.a,
        b=1.0,
        wavelength=conditions.wavelength,
    )


def run(recording: DopplerPairs, parameters: LinesParameters, context: RunContext) -> Result:
    """Follow every pass of a recording.

    Raises
    ------
    RecordingError
        No site, one that does not fit or is not symmetrical, or one Doppler only.
    """
    conditions = conditions_of(recording, parameters)
    pairs, notes = pairs_of(conditions)
    options = options_of(parameters, conditions)
    doubtful = {"window_long": 0, "geometry_weak": 0}

    def method(piece: Piece, arrays: Arrays) -> None:
        found = [follow_pair(piece, pair, options) for pair in pairs]
        answers = [answer_of(one, pair, conditions.a) for one, pair in zip(found, pairs, strict=True)]
        put_answer(piece, arrays, joined(answers, conditions.a))
        first = found[0]
        piece.put(arrays, "line", first.line)
        piece.put(arrays, "crossing_s", first.tau)
        piece.put(arrays, "frozen", first.frozen)
        piece.put(arrays, "omega_rad_s", first.omega)
        piece.put(arrays, "difference_hz", first.difference)
        used = np.isfinite(piece.doppler)
        for one, pair in zip(found, pairs, strict=True):
            for j, channels in enumerate((pair.lower, pair.upper)):
                for c in channels:
                    used[:, c] &= one.agrees[:, j]
        piece.put(arrays, "used", used)
        if 0 in piece.lanes:
            lane = int(np.flatnonzero(piece.lanes == 0)[0])
            doubtful["window_long"] += _long_windows(piece, parameters.window)
            doubtful["geometry_weak"] += _weak_crossings(first, lane)

    arrays, more = estimate(recording, conditions, parameters, context, method, lines=True)
    said = {
        "window_long": "Windows run over more than three times their usual span, because values are missing: low "
        "confidence.",
        "geometry_weak": "The crossing times of the two receivers differ by less than three of their standard "
        "deviations at the end of a pass: the target is near the transmitter, or the receivers too close; formula 19 "
        "or maximum likelihood is better.",
    }
    doubts = tuple(Note(code, said[code], count) for code, count in doubtful.items() if count)
    return Result(arrays, (*notes, *more, *doubts), conditions.settings)


def _long_windows(piece: Piece, window: int) -> int:
    """How many windows span more than three times N intervals."""
    first = np.maximum(np.arange(piece.time.size) - window + 1, 0)
    return int((piece.time - piece.time[first] > LONGEST_SPAN * window * piece.interval).sum())


def _weak_crossings(found: sequence.Answers, lane: int) -> int:
    """1 where the pass ends with |D| < 3 sd(D)."""
    tau = found.tau[-1, :, lane]
    line = found.line[-1, :, :, lane]
    variance = found.covariance[-1, 0, 0, lane]
    if not np.isfinite(tau).all() or not np.isfinite(line).all() or not np.isfinite(variance):
        return 0
    # tau = (tau_1 + tau_2) / 2 with independent halves: D has four times its variance.
    return int(abs(tau[1] - tau[0]) < LEAST_D_SIGMA * np.sqrt(4 * variance))


def score(recording: DopplerPairs, parameters: LinesParameters, context: RunContext) -> Scores:
    """Follow simulated passes and score them against the truth."""
    return score_with(run, recording, parameters, context)


def _tables(recording: DopplerPairs, result: Result) -> dict[str, Table]:
    return tabulate(recording, result) | calibration_tables(run, LinesParameters, recording, result)


ALGORITHM = Algorithm(
    name="forward_scatter_lines",
    title="Lines and closed form (the paper's)",
    summary="Straight lines through the last Dopplers of two receivers give the crossing times and the angular "
    "velocity; a formula gives distance, velocity and coordinates.",
    family="forward_scatter",
    takes=("doppler_pairs",),
    parameters=LinesParameters,
    outputs=LINE_OUTPUTS,
    charts=(
        "base_plan",
        "crossing",
        "doppler_lines",
        "angular_velocity",
        "doppler_residuals",
        "sensitivity",
        "base_bound",
        "plan",
        "trials_crossing",
        "trials_range",
        "trials_crossing_sweep",
        "trials_paths",
    ),
    references=(Reference("scatter2014", "eqs. (3)-(19)"),),
    run=run,
    tabulate=_tables,
    measure=measure,
    score=score,
)
