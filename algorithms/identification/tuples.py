"""Plots of K radars: which sets of them, one or none of each radar, are one target?

A *tuple* holds at most one plot of each radar, two at least. With the information-weighted mean p and P = (sum R^-1)^-1
its cost is c = S/2 + (|t|-1) ln 2 pi + sum ln det R/2 - ln det P/2, and its score the log-likelihood ratio to "each is
alone":

    ln nu - c + sum_detected ln p_k + sum_missed ln(1 - p_k) - sum_detected ln w_k,
    w_k = lambda_k + nu p_k prod_(j != k) (1 - p_j).

The best set of disjoint tuples is a set packing, solved exactly as an integer program; where there are too many tuples,
radar by radar: plots of the next one are assigned to the tuples so far. The probability of a tuple is the share of all
sets of disjoint tuples that hold it.

References
----------
barshalom2001, section 1.4; crouse2016; specification 7.

Differences from the paper
--------------------------
The paper has two radars; for two the scores are those of the pairs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from algorithms.errors import AlgorithmError
from algorithms.identification.pairs import Points
from algorithms.toolbox.association.assignment import LEAST_DENSITY, most_likely_matching
from algorithms.toolbox.association.packings import packing_probabilities

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_CANDIDATES = 20_000
LEAST_MISS = 1e-9
# So many tuples are chosen anew to see what lacks one of them.
MOST_NEAR = 700
Tuple = tuple[int, ...]
"""Plot of each radar, -1 = none."""


@dataclass(frozen=True)
class Densities:
    """Detection probability and densities of targets and of clutter, 1/m2, the same for all K radars."""

    detection: float
    target: float
    clutter: float
    radars: int

    @property
    def log_seen(self) -> float:
        """What a detected plot adds to a score."""
        p = min(self.detection, 1 - LEAST_MISS)
        lone = self.clutter + self.target * self.detection * (1 - self.detection) ** (self.radars - 1)
        return float(np.log(p) - np.log(max(lone, LEAST_DENSITY)))

    @property
    def log_missed(self) -> float:
        """What a miss adds to a score."""
        return float(np.log(max(1 - self.detection, LEAST_MISS)))


@dataclass(frozen=True)
class Packed:
    """The best set of tuples.

    Attributes
    ----------
    tuples : (T, K) plot of each radar, -1 = none
    scores, statistic : (T,)
    place, covariance : (T, 2) and (T, 3) xx yy xy
    probability : (T,) of each tuple; NaN where it was not asked for
    bounded : (T,) whether that is an upper bound, because there are too many choices to sum over
    listed, listed_probability : (C, K) and (C,) all tuples that were possible; NaN where they were not summed
    exact : whether the integer program was solved
    """

    tuples: Ints
    scores: Floats
    statistic: Floats
    place: Floats
    covariance: Floats
    probability: Floats
    bounded: NDArray[np.bool_]
    listed: Ints
    listed_probability: Floats
    exact: bool


class Looked:
    """Plots of all radars at one look of one trial."""

    def __init__(self, points: list[Points], densities: Densities, threshold: float) -> None:
        self.count = [int(p.x.size) for p in points]
        self.densities = densities
        self.place = [np.stack([p.x, p.y], axis=1) for p in points]
        self.log_det = []
        self.info = []
        for p in points:
            determinant = p.xx * p.yy - p.xy * p.xy
            self.log_det.append(np.log(determinant))
            self.info.append(np.stack([p.yy, p.xx, -p.xy], axis=1) / determinant[:, None])
        self.near = self._gates(points, threshold)

    def _gates(self, points: list[Points], threshold: float) -> dict[tuple[int, int], NDArray[np.bool_]]:
        near = {}
        for a, b in combinations(range(len(points)), 2):
            p, q = points[a], points[b]
            dx, dy = p.x[:, None] - q.x, p.y[:, None] - q.y
            xx, yy, xy = p.xx[:, None] + q.xx, p.yy[:, None] + q.yy, p.xy[:, None] + q.xy
            determinant = xx * yy - xy * xy
            near[a, b] = (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / determinant <= threshold
        return near

    def evaluate(self, tuples: Ints, radars: int | None = None) -> tuple[Floats, Floats, Floats, Floats]:
        """Scores (T,), statistics (T,), places (T, 2) and covariances (T, 3) of tuples (T, K).

        `radars` = so many have been looked at: only these can have missed a target.
        """
        size = len(tuples)
        info, right = np.zeros((size, 3)), np.zeros((size, 2))
        log_det, energy, seen = np.zeros(size), np.zeros(size), np.zeros(size)
        for k in range(tuples.shape[1]):
            rows = np.flatnonzero(tuples[:, k] >= 0)
            plot = tuples[rows, k]
            i, z = self.info[k][plot], self.place[k][plot]
            pull = np.stack([i[:, 0] * z[:, 0] + i[:, 2] * z[:, 1], i[:, 2] * z[:, 0] + i[:, 1] * z[:, 1]], axis=1)
            info[rows] += i
            right[rows] += pull
            log_det[rows] += self.log_det[k][plot]
            seen[rows] += 1
        determinant = info[:, 0] * info[:, 1] - info[:, 2] ** 2
        covariance = np.stack([info[:, 1], info[:, 0], -info[:, 2]], axis=1) / determinant[:, None]
        xx, yy, xy = covariance.T
        place = np.stack([xx * right[:, 0] + xy * right[:, 1], xy * right[:, 0] + yy * right[:, 1]], axis=1)
        # About the mean, because sums of squares of coordinates lose the digits that matter.
        for k in range(tuples.shape[1]):
            rows = np.flatnonzero(tuples[:, k] >= 0)
            plot = tuples[rows, k]
            i, d = self.info[k][plot], self.place[k][plot] - place[rows]
            energy[rows] += i[:, 0] * d[:, 0] ** 2 + 2 * i[:, 2] * d[:, 0] * d[:, 1] + i[:, 1] * d[:, 1] ** 2
        cost = energy / 2 + (seen - 1) * np.log(2 * np.pi) + log_det / 2 + np.log(determinant) / 2
        d = self.densities if radars is None else replace(self.densities, radars=radars)
        score = np.log(d.target) - cost + seen * d.log_seen + (d.radars - seen) * d.log_missed
        return np.where(seen > 1, score, 0.0), energy, place, covariance

    def candidates(self, limit: int) -> Ints | None:
        """All tuples that pass all gates of their pairs; None where they are more than `limit`."""
        partial: list[Tuple] = [()]
        for k, n in enumerate(self.count):
            grown: list[Tuple] = []
            for t in partial:
                grown.append((*t, -1))
                fits = np.ones(n, np.bool_)
                for j, plot in enumerate(t):
                    if plot >= 0:
                        fits &= self.near[j, k][plot]
                grown += [(*t, int(i)) for i in np.flatnonzero(fits)]
                if len(grown) > 4 * limit:
                    return None
            partial = grown
        found = np.array(partial, np.int64).reshape(-1, len(self.count))
        found = found[(found >= 0).sum(axis=1) >= 2]
        return found if len(found) <= limit else None


def pack(looked: Looked, *, limit: int = MOST_CANDIDATES, probabilities: bool = False, bounds: bool = True) -> Packed:
    """Find the best set of disjoint tuples, and if asked for the probability of every tuple.

    `bounds` = where plots are too dense to sum over all choices, upper bounds take the place of probabilities.
    """
    if len(looked.count) == 2 and not probabilities:
        # Two radars are a plain assignment.
        return replace(_sequential(looked), exact=True)
    tuples = looked.candidates(limit)
    if tuples is None:
        return _sequential(looked)
    scores, *_ = looked.evaluate(tuples)
    worth = scores > 0
    kept = tuples[worth]
    chosen = _solve(looked.count, kept, scores[worth])[1]
    best = kept[chosen]
    listed = np.full(len(tuples), np.nan)
    own, bounded = np.full(len(best), np.nan), np.zeros(len(best), np.bool_)
    if probabilities:
        listed = packing_probabilities(numbered(looked.count, tuples), scores, int(sum(looked.count)))
        own = listed[np.flatnonzero(worth)[chosen]]
        bounded = np.isnan(own) & bounds
        own[bounded] = _upper_bounds(looked.count, kept, scores[worth], np.isnan(listed[worth]), chosen[bounded])
    return Packed(best, *looked.evaluate(best), own, bounded, tuples, listed, exact=True)


def numbered(counts: list[int], tuples: Ints) -> Ints:
    """(T, K) numbers of the plots among those of all radars one after another, -1 = none."""
    offset = np.concatenate([[0], np.cumsum(counts)])[:-1]
    return np.where(tuples >= 0, tuples + offset, -1)


def _upper_bounds(counts: list[int], tuples: Ints, scores: Floats, large: NDArray[np.bool_], best: Ints) -> Floats:
    """(T,) bounds of the tuples of the best choice: it against the best one found that lacks the tuple.

    `large` says which tuples are in groups that are not summed: the other ones do not depend on them. Only what stands
    near a tuple is chosen anew without it, the rest of the best choice stays: others make its probability smaller only,
    and what lacks the tuple far away is worth no more than what lacks it here.
    """
    out = np.empty(len(best))
    plots = int(sum(counts))
    own = np.flatnonzero(large)
    members = numbered(counts, tuples[own])
    column, which = np.nonzero(members >= 0)
    holds = coo_array((np.ones(column.size), (column, members[column, which])), shape=(own.size, plots)).tocsr()
    size = np.asarray(holds.sum(axis=1)).ravel()
    chosen = np.searchsorted(own, best)
    taken = np.asarray(holds[chosen].sum(axis=0)).ravel() > 0
    for i, c in enumerate(chosen):
        near = np.zeros(plots)
        near[members[c][members[c] >= 0]] = 1
        inside = np.zeros(own.size, np.bool_)
        while True:
            # What touches a plot that is near, and whatever of the best choice stands in its way, is near too.
            touching = holds.T @ (holds @ near > 0) > 0
            of_best = holds[chosen] @ touching > 0
            wider = np.asarray(holds[chosen[of_best]].sum(axis=0) > 0).ravel() | (near > 0)
            found = holds @ (wider | ~taken) == size
            done = (wider == (near > 0)).all()
            if inside.any() and (done or found.sum() > MOST_NEAR):
                break
            near, inside = wider.astype(float), found
        fixed = holds[chosen] @ near > 0
        now = float(scores[own[chosen[fixed]]].sum())
        inside[c] = False
        rest = own[inside]
        out[i] = 1 / (1 + np.exp(_solve(counts, tuples[rest], scores[rest])[0] - now))
    return out


def _solve(counts: list[int], tuples: Ints, scores: Floats) -> tuple[float, Ints]:
    """Total score and positions of the best set of disjoint tuples."""
    if not len(tuples):
        return 0.0, np.empty(0, np.int64)
    column, radar = np.nonzero(tuples >= 0)
    row = numbered(counts, tuples)[column, radar]
    matrix = coo_array((np.ones(row.size), (row, column)), shape=(int(sum(counts)), len(tuples))).tocsc()
    found = milp(
        -scores, integrality=np.ones(len(tuples)), bounds=Bounds(0, 1), constraints=LinearConstraint(matrix, ub=1)
    )
    if found.x is None:
        raise AlgorithmError(
            "The integer program of the tuples was not solved.",
            remedy="Make the region smaller or the gate narrower.",
            code="integer_program",
        )
    chosen = np.flatnonzero(found.x > 0.5)
    return float(scores[chosen].sum()), chosen


def _sequential(looked: Looked) -> Packed:
    """Assign the plots of one radar after another to the tuples so far; alone they begin a tuple."""
    radars = len(looked.count)
    current = np.full((looked.count[0], radars), -1)
    current[:, 0] = np.arange(looked.count[0])
    for k in range(1, radars):
        n, m = len(current), looked.count[k]
        before = looked.evaluate(current, k + 1)[0]
        joined = np.repeat(current, m, axis=0)
        joined[:, k] = np.tile(np.arange(m), n)
        gain = looked.evaluate(joined, k + 1)[0].reshape(n, m) - before[:, None]
        for j in range(k):
            has = np.flatnonzero(current[:, j] >= 0)
            gain[has] = np.where(looked.near[j, k][current[has, j]], gain[has], -np.inf)
        partner = most_likely_matching(gain)
        taken = np.flatnonzero(partner >= 0)
        current[taken, k] = partner[taken]
        alone = np.setdiff1d(np.arange(m), partner[taken])
        begun = np.full((alone.size, radars), -1)
        begun[:, k] = alone
        current = np.concatenate([current, begun])
    several = current[(current >= 0).sum(axis=1) >= 2]
    scores, *_ = looked.evaluate(several)
    best = several[scores > 0]
    unknown = np.full(len(best), np.nan)
    nothing = np.zeros(len(best), np.bool_)
    return Packed(best, *looked.evaluate(best), unknown, nothing, best, unknown, exact=False)
