"""Which measurement of one sensor belongs to which of another: scores of pairs, and the most likely matching.

A *matching* pairs each row with at most one column. Its log-likelihood ratio to "nothing belongs together" is the sum
of the scores of its pairs; a row or column without a partner (seen by one sensor only, or clutter) adds 0. A pair
outside the gate has the score -inf and is never made. In the *complete* case every target is seen once by both sensors
and nothing else is: as many pairs as the shorter side has rows are made, whatever they cost.

References
----------
barshalom2001, section 1.4; crouse2016.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_DENSITY = 1e-30
"""1/m2; a density of lone measurements below this counts as this, so that a score stays finite."""


def pair_costs(statistic: Floats, log_determinant: Floats) -> Floats:
    """-ln of the likelihood that two points in the plane are one target whose place is unknown, ln m2.

    The integral of both likelihoods over the place with a flat prior: S/2 + ln det(R1 + R2)/2 + ln 2 pi.
    """
    cost: Floats = statistic / 2 + log_determinant / 2 + np.log(2 * np.pi)
    return cost


def pair_scores(
    cost: Floats,
    *,
    detection_probability: tuple[float, float],
    target_density: float | Floats,
    clutter_density: tuple[float, float],
) -> Floats:
    """Log-likelihood ratio of "these two are one target" to "each is clutter, or a target seen by one sensor only".

    Parameters
    ----------
    cost : (..., n, m) from `pair_costs`
    detection_probability : of the two sensors, in (0, 1]
    target_density, clutter_density : 1/m2 in the plane; of targets (one number, or one for each trial in the last axis
        of `cost`), and of the clutter of the two sensors
    """
    p1, p2 = detection_probability
    lone1 = np.maximum(clutter_density[0] + p1 * (1 - p2) * target_density, LEAST_DENSITY)
    lone2 = np.maximum(clutter_density[1] + p2 * (1 - p1) * target_density, LEAST_DENSITY)
    scores: Floats = np.log(p1 * p2 * target_density) - np.log(lone1) - np.log(lone2) - cost
    return scores


def most_likely_matching(score: Floats, *, complete: bool = False) -> Ints:
    """Column of each row in the matching of the largest total score, -1 = none.

    Parameters
    ----------
    score : (n, m); -inf = impossible
    complete : make as many pairs as can be, instead of those that are better than none

    Raises
    ------
    ValueError
        `complete`, and no matching of that size keeps to the possible pairs.
    """
    n, m = score.shape
    column = np.full(n, -1)
    if not (n and m):
        return column
    if complete:
        rows, columns = linear_sum_assignment(score, maximize=True)
        column[rows] = columns
        return column
    # One column of score 0 for each row: its place "none".
    padded = np.concatenate([score, np.full((n, n), -np.inf)], axis=1)
    padded[np.arange(n), m + np.arange(n)] = 0.0
    rows, columns = linear_sum_assignment(padded, maximize=True)
    column[rows] = np.where(columns < m, columns, -1)
    return column
