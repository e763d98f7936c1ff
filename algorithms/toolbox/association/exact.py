"""Probabilities of all pairs from the sum over all matchings, by dynamic programming over sets of columns.

f[i, A] is the total likelihood of the rows before i using exactly the columns A; g[i, A] that of the rows from i on
while A is taken. A pair's share is then the sum over A of f[i, A] L_ij g[i + 1, A + j]. The work is n m 2^m, so the
shorter side is made the columns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError

Floats = NDArray[np.float64]

EXACT_COLUMNS = 14
"""Length of the shorter side up to which the sum over all matchings is made where nobody says otherwise."""
LARGEST_EXACT = 18
"""Beyond, the sum takes minutes and gigabytes."""


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
    sets = np.arange(1 << m)
    free = [sets[(sets >> j) & 1 == 0] for j in range(m)]
    before = np.full((n + 1, 1 << m, *trials), -np.inf)
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
    pairs = np.empty((n, m, *trials))
    known = np.where(np.isfinite(log_total), log_total, np.nan)
    for i in range(n):
        for j in range(m):
            terms = before[i, free[j]] + score[i, j] + after[i + 1, free[j] | (1 << j)]
            # A sum of rounded terms may exceed the total by a unit in the last place.
            pairs[i, j] = np.minimum(np.exp(terms - known).sum(axis=0), 1.0)
    return pairs, log_total
