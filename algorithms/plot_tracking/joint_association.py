"""Joint probabilistic association: which of the plots in their gates belong to which tracks, with what probability.

Tracks and plots that gates join form a cluster. In a cluster the sum runs over all ways to give plots to tracks, each
plot to one track at most and each track one plot at most, exactly. Where both sides of a cluster are longer than
`largest` the sum would not end (its work doubles with each plot): there the nearest-neighbour assignment of the
cluster is taken as certain, and counted.

References
----------
barshalom2001, section 1; crouse2016; the sum: `algorithms.toolbox.association.exact`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.association.exact import exact_probabilities
from algorithms.toolbox.association.sparse import components, most_pairs_at_least_cost

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Joint:
    """Probability of each pair, and in how many clusters the nearest neighbours stand in for the sum."""

    beta: Floats
    too_large: int


def joint_probabilities(track: Ints, plot: Ints, score: Floats, cost: Floats, largest: int) -> Joint:
    """Probabilities of pairs.

    Parameters
    ----------
    track, plot : (K,) pairs inside gates
    score : (K,) ln of the pair's likelihood over that of a missed track and a false plot
    cost : (K,) what the assignment makes small where a cluster is too large
    """
    beta = np.zeros(track.size)
    too_large = 0
    simple: list[Ints] = []
    for pairs in components(track, plot):
        if pairs.size == 1:
            simple.append(pairs)
            continue
        rows, r = np.unique(track[pairs], return_inverse=True)
        columns, c = np.unique(plot[pairs], return_inverse=True)
        if min(rows.size, columns.size) > largest:
            too_large += 1
            chosen = most_pairs_at_least_cost(track[pairs], plot[pairs], cost[pairs])
            beta[pairs[chosen]] = 1.0
            continue
        table = np.full((rows.size, columns.size), -np.inf)
        table[r, c] = score[pairs]
        found, _ = exact_probabilities(table)
        beta[pairs] = found[r, c]
    if simple:
        alone = np.concatenate(simple)
        beta[alone] = 1.0 / (1.0 + np.exp(-score[alone]))
    return Joint(beta, too_large)
