"""How far a set of estimates lies from a set of true points: OSPA, and GOSPA with its three parts.

With pairs (i, j) of the best matching, every distance cut at c,

    OSPA   = [ (sum over pairs d^p + c^p (max(m, n) - pairs)) / max(m, n) ]^(1/p)
    GOSPA  = [  sum over pairs d^p + c^p / 2 (missed + false)             ]^(1/p)         (alpha = 2)

where a pair farther apart than c is none: its point is missed and its estimate false. One matching serves both: it
makes the sum of c^p - d^p over its pairs as large as can be.

References
----------
schuhmacher2008; rahmathullah2017.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.association.sparse import greatest_gain

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CUT_M = 2000.0
ORDER = 2


@dataclass(frozen=True)
class SetDistance:
    """For each of L trials."""

    ospa_m: Floats
    gospa_m: Floats
    localisation: Floats
    """m^p, the pairs' part of GOSPA to the power p"""
    missed: Floats
    """number of points without an estimate"""
    false: Floats
    """number of estimates without a point"""


def set_distance(
    lane: Ints, estimate: Floats, point: Floats, lanes: int, *, cut_m: float = CUT_M, order: int = ORDER
) -> SetDistance:
    """Distances between estimates (E, 2) of trials `lane` (E,) and the points (K, 2) that are the same for all."""
    d = np.hypot(*(estimate[:, None] - point[None]).transpose(2, 0, 1)) if estimate.size and point.size else None
    count = np.bincount(lane, minlength=lanes).astype(float)
    near = np.argwhere(d < cut_m) if d is not None else np.empty((0, 2), np.int64)
    e, k = near[:, 0], near[:, 1]
    close = d[e, k] if d is not None else np.empty(0)
    chosen = greatest_gain(e, lane[e] * max(len(point), 1) + k, cut_m**order - close**order)
    pairs = np.bincount(lane[e[chosen]], minlength=lanes).astype(np.float64)
    local = np.bincount(lane[e[chosen]], weights=close[chosen] ** order, minlength=lanes).astype(np.float64)
    missed, false = len(point) - pairs, count - pairs
    larger = np.maximum(count, float(len(point)))
    ospa = (local + cut_m**order * (larger - pairs)) / np.maximum(larger, 1.0)
    gospa = local + cut_m**order / 2 * (missed + false)
    return SetDistance(ospa ** (1 / order), gospa ** (1 / order), local, missed, false)
