"""Warnings about what came out of the first trial: numbers that fit and yet cannot be, or should not be relied on.

References
----------
specification 10.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from algorithms.forward_scatter import outputs
from algorithms.forward_scatter.conditions import Conditions
from algorithms.forward_scatter.piece import Arrays, Piece
from algorithms.recording import DopplerPairs
from algorithms.result import Note

LARGEST_SIDE = 0.3
SPEED_MPS = (5.0, 3000.0)
CHI2_QUANTILE = 0.999
FEWEST_FOR_SIGN = 6


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


def doubts(pieces: list[Piece], conditions: Conditions, arrays: Arrays) -> list[Note]:
    """Warnings about the first trial's passes."""
    counts: dict[str, int] = {}
    for piece in pieces:
        if 0 not in piece.lanes:
            continue
        rows = piece.rows
        answered = rows[np.isin(arrays["status"][rows, 0], outputs.ANSWERED)]
        if rising(piece):
            counts["sign_reversed"] = counts.get("sign_reversed", 0) + 1
        if not answered.size:
            continue
        theta = np.asarray(arrays["theta"], float)[answered[-1], :, 0]
        tau, s, vy, _, ay = theta
        if not SPEED_MPS[0] <= abs(vy) <= SPEED_MPS[1]:
            counts["speed_unlikely"] = counts.get("speed_unlikely", 0) + 1
        d = piece.time[np.isfinite(piece.doppler[:, :, 0]).any(axis=1)] - tau
        side = np.abs(vy * d + 0.5 * ay * d * d).max(initial=0.0)
        if side > LARGEST_SIDE * min(s, conditions.a - s):
            counts["far_from_base_line"] = counts.get("far_from_base_line", 0) + 1
        if d.size and d[-1] < 0:
            counts["ends_before_crossing"] = counts.get("ends_before_crossing", 0) + 1
        chi2, dof = float(arrays["chi2"][answered[-1], 0]), int(arrays["dof"][answered[-1], 0])
        if dof > 0 and chi2 > stats.chi2.ppf(CHI2_QUANTILE, dof):
            counts["chi2_large"] = counts.get("chi2_large", 0) + 1
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
    }
    return [Note(code, said[code], count) for code, count in counts.items()]


def rising(piece: Piece) -> bool:
    """Whether every channel of the first trial rises significantly over the whole pass."""
    found = []
    for c in range(piece.doppler.shape[1]):
        f = piece.doppler[:, c, 0]
        known = np.isfinite(f)
        if known.sum() < FEWEST_FOR_SIGN:
            continue
        fit = stats.linregress(piece.time[known], f[known]) if np.ptp(piece.time[known]) > 0 else None
        found.append(fit is not None and fit.slope > 3 * fit.stderr > 0)
    return bool(found) and all(found)
