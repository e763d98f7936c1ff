"""Association probabilities of any number of measurements: exact where that can be, else ranked with a stated error.

The pairs inside the gate split the measurements into groups that have nothing to do with each other. A group whose
shorter side has at most `EXACT_COLUMNS` members is summed over all its matchings; a larger one over its most likely
matchings, and the largest share of likelihood that these can lack is given. No probability of a pair is wrong by more
than that share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from algorithms.toolbox.association.exact import EXACT_COLUMNS, exact_probabilities
from algorithms.toolbox.association.ranked import ranked_matchings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

RANKED_MATCHINGS = 500
"""How many matchings of a group too large for the exact sum are listed."""


@dataclass(frozen=True)
class AssociationProbabilities:
    """Probabilities of the pairs of n with m measurements.

    Attributes
    ----------
    pairs : (n, m)
    groups : number of groups of two and more measurements
    ranked_groups : how many of them were too large for the exact sum
    truncation : no probability is wrong by more than this; 0 where all groups are exact
    """

    pairs: Floats
    groups: int
    ranked_groups: int
    truncation: float

    @property
    def row_alone(self) -> Floats:
        """(n,) probability that a row has no partner."""
        alone: Floats = np.clip(1 - self.pairs.sum(axis=1), 0.0, 1.0)
        return alone

    @property
    def column_alone(self) -> Floats:
        """(m,) probability that a column has no partner."""
        alone: Floats = np.clip(1 - self.pairs.sum(axis=0), 0.0, 1.0)
        return alone


def association_probabilities(
    score: Floats, *, exact_columns: int = EXACT_COLUMNS, ranked: int = RANKED_MATCHINGS
) -> AssociationProbabilities:
    """Probabilities of all pairs from their log-likelihood ratios.

    Parameters
    ----------
    score : (n, m), -inf = outside the gate
    exact_columns : longest shorter side of a group that is summed exactly
    ranked : number of matchings of a larger group
    """
    n, m = score.shape
    pairs = np.zeros((n, m))
    count = ranked_groups = 0
    truncation = 0.0
    for rows, columns in linked_groups(score):
        count += 1
        own = score[np.ix_(rows, columns)]
        if min(own.shape) <= exact_columns:
            found, _ = exact_probabilities(own)
        else:
            ranked_groups += 1
            found, error = _ranked(own, ranked)
            truncation = max(truncation, error)
        pairs[np.ix_(rows, columns)] = found
    return AssociationProbabilities(pairs, count, ranked_groups, truncation)


def linked_groups(score: Floats) -> list[tuple[Ints, Ints]]:
    """Rows and columns of each group that possible pairs hold together; lone measurements are in none."""
    n, m = score.shape
    rows, columns = np.nonzero(score > -np.inf)
    graph = coo_array((np.ones(rows.size, np.int8), (rows, n + columns)), shape=(n + m, n + m))
    _, label = connected_components(graph, directed=False)
    out = []
    for group in np.unique(label[rows]):
        members = np.flatnonzero(label == group)
        out.append((members[members < n], members[members >= n] - n))
    return out


def _ranked(score: Floats, limit: int) -> tuple[Floats, float]:
    found = ranked_matchings(score, limit)
    weight = np.exp(found.log_likelihood - found.log_likelihood.max())
    weight /= weight.sum()
    pairs = np.zeros(score.shape)
    for columns, share in zip(found.columns, weight, strict=True):
        matched = np.flatnonzero(columns >= 0)
        pairs[matched, columns[matched]] += share
    return pairs, found.truncation
