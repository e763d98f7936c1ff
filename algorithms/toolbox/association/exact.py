"""Probabilities of all pairs from the sum over all matchings, by dynamic programming over sets of columns.

f[i, A] is the total likelihood of the rows before i using exactly the columns A; g[i, A] that of the rows from i on
while A is taken. A pair's share is then the sum over A of f[i, A] L_ij g[i + 1, A + j]. The work is n m 2^m, so the
shorter side is made the columns.

Where no product of likelihoods can leave the range of numbers they are multiplied and added as they are; else, and
where only complete matchings count, their logarithms are, which takes ten times as long.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError

Floats = NDArray[np.float64]

EXACT_COLUMNS = 14
"""Length of the shorter side up to which the sum over all matchings is made where nobody says otherwise."""
LARGEST_EXACT = 18
"""Beyond, the sum takes minutes and gigabytes."""
_LARGEST_LOG = 600.0
"""Logarithms of sums up to here are numbers: exp(709) is the largest."""


def exact_probabilities(score: Floats, *, complete: bool = False) -> tuple[Floats, Floats]:
    """Posterior probability of each pair over all matchings, and ln of their total likelihood.

    Parameters
    ----------
    score : (n, m, ...) log-likelihood ratios, -inf = impossible; trials side by side in the further axes
    complete : only matchings with min(n, m) pairs count (see `assignment`)

    Returns
    -------
    pairs : (n, m, ...); what a row or column lacks to 1 is the probability that it has no partner. NaN where no
        matching is possible at all.
    log_total : (...)

    Raises
    ------
    ParameterError
        The shorter side is longer than `LARGEST_EXACT`.
    """
    if min(score.shape[:2]) > LARGEST_EXACT:
        raise ParameterError(
            f"The sum over all matchings of {min(score.shape[:2])} measurements is too large; at most {LARGEST_EXACT} "
            "can be.",
            remedy="Split them into groups, or sum over the most likely matchings.",
        )
    if score.shape[0] < score.shape[1]:
        pairs, log_total = exact_probabilities(np.swapaxes(score, 0, 1), complete=complete)
        return np.swapaxes(pairs, 0, 1), log_total
    n, m, *trials = score.shape
    flat = score.reshape(n, m, int(np.prod(trials)))
    # Where nobody needs a partner the total is at least 1, so only what is too large can do harm.
    most = np.maximum(flat.max(axis=1, initial=0.0), 0.0).sum(axis=0) + n * np.log(m + 1.0)
    plain = (most < _LARGEST_LOG) & (not complete)
    pairs, log_total = np.empty(flat.shape), np.empty(flat.shape[2])
    for which, summed in ((plain, _by_products), (~plain, partial(_by_logarithms, complete=complete))):
        if which.any():
            pairs[..., which], log_total[which] = summed(flat[..., which])
    return pairs.reshape(score.shape), log_total.reshape(trials)


def _by_products(score: Floats) -> tuple[Floats, Floats]:
    """The sum over scores (n, m, W) as it is written, none of them large.

    With the sets of columns that are still free in place of those that are taken, g runs through the rows backwards as
    f does forwards: both are made at once.
    """
    n, m, trials = score.shape
    likelihood = np.exp(score)
    both = np.zeros((n + 1, 1 << m, 2, trials))
    both[0, 0, 0] = both[0, :, 1] = 1.0
    of_row = np.stack([likelihood, likelihood[::-1]], axis=2)
    for i in range(n):
        both[i + 1] = both[i]
        for j in range(m):
            _halves(both[i + 1], j)[:, 1] += _halves(both[i], j)[:, 0] * of_row[i, j]
    before, after = both[:-1, :, 0].swapaxes(0, 1), both[-2::-1, ::-1, 1].swapaxes(0, 1)
    total = both[-1, -1, 1]
    pairs = np.empty(score.shape)
    for j in range(m):
        terms = (_halves(before, j)[:, 0] * _halves(after, j)[:, 1]).reshape(-1, n, trials)
        # In halves, so that the order does not depend on the number of trials.
        while len(terms) > 1:
            terms = terms[: len(terms) // 2] + terms[len(terms) // 2 :]
        # A sum of rounded terms may exceed the total by a unit in the last place.
        pairs[:, j] = np.minimum(terms[0] * likelihood[:, j] / total, 1.0)
    return pairs, np.log(total)


def _halves(of_set: Floats, j: int) -> Floats:
    """A view (2^(m-1-j), 2, 2^j, ...) of (2^m, ...): the sets without column j are [:, 0], the same with it [:, 1]."""
    return of_set.reshape(-1, 2, 1 << j, *of_set.shape[1:])


def _by_logarithms(score: Floats, *, complete: bool) -> tuple[Floats, Floats]:
    """The sum over scores (n, m, W) of any size."""
    n, m, trials = score.shape
    sets = np.arange(1 << m)
    free = [sets[(sets >> j) & 1 == 0] for j in range(m)]
    before = np.full((n + 1, 1 << m, trials), -np.inf)
    before[0, 0] = 0.0
    after = np.full_like(before, -np.inf)
    # The rows are the longer side, so that all columns are taken at the end of a complete matching.
    after[n, -1 if complete else slice(None)] = 0.0
    for i in range(n):
        before[i + 1] = before[i]
        for j in range(m):
            taken = free[j] | (1 << j)
            before[i + 1, taken] = np.logaddexp(before[i + 1, taken], before[i, free[j]] + score[i, j])
    for i in range(n - 1, -1, -1):
        after[i] = after[i + 1]
        for j in range(m):
            taken = free[j] | (1 << j)
            after[i, free[j]] = np.logaddexp(after[i, free[j]], after[i + 1, taken] + score[i, j])
    log_total = after[0, 0]
    pairs = np.empty((n, m, trials))
    known = np.where(np.isfinite(log_total), log_total, np.nan)
    for i in range(n):
        for j in range(m):
            terms = before[i, free[j]] + score[i, j] + after[i + 1, free[j] | (1 << j)]
            # A sum of rounded terms may exceed the total by a unit in the last place.
            pairs[i, j] = np.minimum(np.exp(terms - known).sum(axis=0), 1.0)
    return pairs, log_total
