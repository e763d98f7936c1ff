"""The k most likely matchings, one after another, with an upper bound of everything that is left out (Murty).

The set of all matchings is split into disjoint parts, each given by pairs that are fixed and pairs that are forbidden;
the best matching of each part is known. The best part is taken, its matching listed, and the rest of it split again. At
any moment the parts that wait hold all that was not listed. The likelihood of a part is at most the product, over its
free rows, of the sum of all that the row may be, because that product also counts matchings in which rows share a
column. The bound is therefore rigorous, not an estimate.

References
----------
murty1968; crouse2016.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import logsumexp

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LOOK_EVERY = 8
"""After so many matchings the rest is held against what is negligible."""


@dataclass(frozen=True)
class RankedMatchings:
    """The most likely matchings.

    Attributes
    ----------
    columns : (k, n) column of each row, -1 = none; the most likely first
    log_likelihood : (k,) total scores
    log_rest : upper bound of ln of the total likelihood of all matchings that are not listed; -inf = none is left
    """

    columns: Ints
    log_likelihood: Floats
    log_rest: float

    @property
    def truncation(self) -> float:
        """Largest possible share of the likelihood that is not listed."""
        listed = logsumexp(self.log_likelihood) if self.log_likelihood.size else -np.inf
        if self.log_rest == -np.inf:
            return 0.0
        return float(1 / (1 + np.exp(min(listed - self.log_rest, 700.0))))


def ranked_matchings(score: Floats, limit: int, *, complete: bool = False, negligible: float = 1e-9) -> RankedMatchings:
    """List the most likely matchings until `limit` are found or the rest is at most a share of `negligible`.

    Parameters
    ----------
    score : (n, m) log-likelihood ratios, -inf = impossible
    complete : only matchings with n pairs count; needs n <= m
    """
    n, m = score.shape
    padded = score
    if not complete:
        padded = np.concatenate([score, np.full((n, n), -np.inf)], axis=1)
        padded[np.arange(n), m + np.arange(n)] = 0.0
    waiting: list[tuple[float, int, _Part]] = []
    made = 0
    for part in _solved(padded, 0):
        heapq.heappush(waiting, (-part.total, made, part))
        made += 1
    columns: list[Ints] = []
    totals: list[float] = []
    while waiting and len(columns) < limit:
        _, _, best = heapq.heappop(waiting)
        columns.append(best.columns)
        totals.append(best.total)
        for part in _split(best):
            heapq.heappush(waiting, (-part.total, made, part))
            made += 1
        # Adding up all that waits takes longer than listing one more.
        if negligible and len(columns) % LOOK_EVERY == 0 and _log_sum(waiting) - logsumexp(totals) < np.log(negligible):
            break
    rest = _log_sum(waiting)
    found = np.array(columns, np.int64).reshape(-1, n)
    return RankedMatchings(np.where(found < m, found, -1), np.array(totals), rest)


def _log_sum(waiting: list[tuple[float, int, _Part]]) -> float:
    return float(logsumexp([part.bound for _, _, part in waiting])) if waiting else -np.inf


@dataclass(frozen=True)
class _Part:
    """Matchings that keep to `allowed`: the rows before `fixed` have one possibility each."""

    allowed: Floats
    fixed: int
    columns: Ints
    total: float
    bound: float


def _solved(allowed: Floats, fixed: int) -> Iterator[_Part]:
    """Give the part with its best matching and bound; nothing where no matching is possible."""
    try:
        rows, columns = linear_sum_assignment(allowed, maximize=True)
    except ValueError:
        return
    total = float(allowed[rows, columns].sum())
    if total == -np.inf:
        return
    yield _Part(allowed, fixed, columns, total, float(logsumexp(allowed, axis=1).sum()))


def _split(part: _Part) -> Iterator[_Part]:
    """Give the part less its best matching, as disjoint parts: the first rows as there, the next one otherwise."""
    base = part.allowed.copy()
    for row in range(part.fixed, base.shape[0]):
        other = base.copy()
        other[row, part.columns[row]] = -np.inf
        if np.isfinite(other[row]).any():
            yield from _solved(other, row)
        kept = base[row, part.columns[row]]
        base[row] = -np.inf
        base[row + 1 :, part.columns[row]] = -np.inf
        base[row, part.columns[row]] = kept
