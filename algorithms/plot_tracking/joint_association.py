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
from algorithms.toolbox.association.sparse import clusters, most_pairs_at_least_cost

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
    found = clusters(track, plot)
    shorter = np.minimum(found.tracks, found.plots)
    alone = (found.tracks == 1) & (found.plots == 1)
    simple = np.flatnonzero(alone[found.of])
    beta[simple] = 1.0 / (1.0 + np.exp(-score[simple]))
    summed = np.flatnonzero(~alone & (shorter <= largest))
    # Clusters of one shape are summed side by side: there are hundreds in a scan, and few shapes.
    shape, kind = np.unique(np.stack([found.tracks, found.plots])[:, summed], axis=1, return_inverse=True)
    at = np.full(found.tracks.size, -1)
    of_shape = np.full(found.tracks.size, -1)
    of_shape[summed] = kind.ravel()
    for k, (rows, columns) in enumerate(shape.T.tolist()):
        mine = summed[kind.ravel() == k]
        at[mine] = np.arange(mine.size)
        pairs = np.flatnonzero(of_shape[found.of] == k)
        place = (found.row[pairs], found.column[pairs], at[found.of[pairs]])
        table = np.full((rows, columns, mine.size), -np.inf)
        table[place] = score[pairs]
        beta[pairs] = exact_probabilities(table)[0][place]
    large = np.flatnonzero(shorter[found.of] > largest)
    if large.size:
        chosen = large[most_pairs_at_least_cost(track[large], plot[large], cost[large])]
        beta[chosen] = 1.0
    return Joint(beta, int((shorter > largest).sum()))
