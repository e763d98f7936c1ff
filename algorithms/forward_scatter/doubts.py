"""Warnings about what came out of the first trial: numbers that fit and yet cannot be, or should not be relied on.

References
----------
specification 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from algorithms.forward_scatter import outputs
from algorithms.forward_scatter.conditions import Conditions
from algorithms.forward_scatter.piece import Arrays, Piece
from algorithms.recording import DopplerPairs
from algorithms.result import Note

Floats = NDArray[np.float64]

LARGEST_SIDE = 0.3
SPEED_MPS = (5.0, 3000.0)
CHI2_QUANTILE = 0.999
FEWEST_FOR_SIGN = 6
LEAST_AGREEING = 0.5
# Without chi2: the bias of the closed form makes residuals of some sigma, noise about a pass hundreds.
LARGEST_RESIDUAL_SIGMA = 25.0


def sign_notes(recording: DopplerPairs) -> list[Note]:
    """Warn where no Doppler of the first trial is negative."""
    f = recording.doppler_hz[:, :, 0]
    known = f[np.isfinite(f)]
    if known.size >= FEWEST_FOR_SIGN * f.shape[1] and (known >= 0).all():
        return [
            Note(
                "doppler_without_sign",
                "No Doppler is negative, though every crossing goes from plus to minus: where the receiver gives "
                "magnitudes, set `unsigned`.",
            )
        ]
    return []


@dataclass(frozen=True)
class PassAnswer:
    """What a pass measured and what was answered: K rows, C channels; theta (K, 5), `used` and `residual` (K, C)."""

    time: Floats
    doppler: Floats
    answered: NDArray[np.bool_]
    theta: Floats
    chi2: Floats
    dof: NDArray[np.int64]
    used: NDArray[np.bool_]
    residual: Floats
    """Dopplers minus those of the last answer, in standard deviations."""
    a: float
    """Length of the base line, m."""


def doubts_of(one: PassAnswer) -> tuple[str, ...]:
    """Codes of what is doubtful about a pass, by its last answer."""
    out = ["sign_reversed"] if rising(one.time, one.doppler) else []
    if not one.answered.any():
        return tuple(out)
    last = int(np.flatnonzero(one.answered)[-1])
    tau, s, vy, _, ay = one.theta[last]
    if not SPEED_MPS[0] <= abs(vy) <= SPEED_MPS[1]:
        out.append("speed_unlikely")
    measured = np.isfinite(one.doppler)
    # What was rejected as false does not lengthen the pass.
    d = one.time[(measured & one.used).any(axis=1)] - tau
    side = np.abs(vy * d + 0.5 * ay * d * d).max(initial=0.0)
    if side > LARGEST_SIDE * min(s, one.a - s):
        out.append("far_from_base_line")
    if d.size and d[-1] < 0:
        out.append("ends_before_crossing")
    if np.isfinite(one.chi2[last]):
        large = one.dof[last] > 0 and one.chi2[last] > stats.chi2.ppf(CHI2_QUANTILE, one.dof[last])
    else:
        known = np.abs(one.residual[measured & one.used & np.isfinite(one.residual)])
        large = known.size > 0 and np.median(known) > LARGEST_RESIDUAL_SIGMA
    if large:
        out.append("chi2_large")
    if (one.used & measured).sum() < LEAST_AGREEING * measured.sum():
        out.append("few_agree")
    return tuple(out)


def doubts(pieces: list[Piece], conditions: Conditions, arrays: Arrays) -> list[Note]:
    """Warnings about the first trial's passes."""
    counts: dict[str, int] = {}
    for piece in pieces:
        if 0 not in piece.lanes:
            continue
        rows = piece.rows
        one = PassAnswer(
            time=piece.time,
            doppler=piece.doppler[:, :, 0],
            answered=np.isin(arrays["status"][rows, 0], outputs.ANSWERED),
            theta=np.asarray(arrays["theta"], float)[rows, :, 0],
            chi2=np.asarray(arrays["chi2"], float)[rows, 0],
            dof=np.asarray(arrays["dof"], np.int64)[rows, 0],
            used=np.asarray(arrays["used"], np.bool_)[rows, :, 0],
            residual=np.asarray(arrays["residual_hz"], float)[rows, :, 0] / conditions.sigma,
            a=conditions.a,
        )
        for code in doubts_of(one):
            counts[code] = counts.get(code, 0) + 1
    said = {
        "sign_reversed": "The Dopplers rise through the pass: the Doppler sign convention is probably reversed.",
        "speed_unlikely": "The velocity across the base line is outside 5 to 3000 m/s: probably a wrong unit, kHz "
        "for Hz or km for m.",
        "far_from_base_line": "The pass goes further from the base line than 0.3 of the distance to its nearer end: "
        "the method is made for |y| much smaller.",
        "ends_before_crossing": "The pass ends before the target crosses the base line: crossing times are "
        "extrapolated, expect two to four times the error. Formula 19 or maximum likelihood is better.",
        "chi2_large": "The residuals are larger than the Doppler error allows (99.9 %): false values (set robust to "
        "consensus), an acceleration (five unknowns), or a wrong error.",
        "few_agree": "Less than half of the Dopplers of a pass agree with its answer: perhaps there is no target "
        "in it.",
    }
    return [Note(code, said[code], count) for code, count in counts.items()]


def rising(time: Floats, doppler: Floats) -> bool:
    """Whether every channel of Dopplers (K, C) rises significantly over the whole pass."""
    found = []
    for f in doppler.T:
        known = np.isfinite(f)
        if known.sum() < FEWEST_FOR_SIGN:
            continue
        fit = stats.linregress(time[known], f[known]) if np.ptp(time[known]) > 0 else None
        found.append(fit is not None and fit.slope > 3 * fit.stderr > 0)
    return bool(found) and all(found)
