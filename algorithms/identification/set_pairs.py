"""What sets of plots of many radars say about their pairs: probabilities, decisions, and who is alone."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.compare import side_of
from algorithms.identification.outputs import ACCEPTED, REJECTED, UNDECIDED
from algorithms.identification.pairs import Points, Side, on_one_line
from algorithms.identification.plots import Look, Plots
from algorithms.identification.tuples import Packed

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class SetPairs:
    """Pairs of each two radars at one look, trials side by side.

    Attributes
    ----------
    probability, decision : by radars, (n, m, L); the probability of a pair is the sum over all sets that hold it
    alone : of each radar, (n, L) probability that a plot is in no set
    """

    def __init__(self, look: Look, lanes: int) -> None:
        sizes = [rows.size for rows in look.rows]
        both = list(combinations(range(len(sizes)), 2))
        self.probability = {(a, b): np.zeros((sizes[a], sizes[b], lanes)) for a, b in both}
        self.decision = {(a, b): np.full((sizes[a], sizes[b], lanes), REJECTED) for a, b in both}
        self.alone = [np.ones((n, lanes)) for n in sizes]

    def take(self, lane: int, packed: Packed, there: list[Ints], accepted: Bools) -> None:
        """Take in one trial; `there` are the plots of each radar that the sets count."""
        listed, share = packed.listed, packed.listed_probability
        for k, alone in enumerate(self.alone):
            has = np.flatnonzero(listed[:, k] >= 0)
            np.subtract.at(alone[:, lane], there[k][listed[has, k]], share[has])
            np.clip(alone[:, lane], 0.0, 1.0, out=alone[:, lane])
        for (a, b), probability in self.probability.items():
            has = np.flatnonzero((listed[:, a] >= 0) & (listed[:, b] >= 0))
            np.add.at(probability[:, :, lane], (there[a][listed[has, a]], there[b][listed[has, b]]), share[has])
            if not packed.exact:
                probability[:, :, lane] = np.nan
            chosen = np.flatnonzero((packed.tuples[:, a] >= 0) & (packed.tuples[:, b] >= 0))
            i, j = there[a][packed.tuples[chosen, a]], there[b][packed.tuples[chosen, b]]
            self.decision[a, b][i, j, lane] = np.where(accepted[chosen], ACCEPTED, UNDECIDED)
            bound = packed.bounded[chosen]
            probability[i[bound], j[bound], lane] = packed.probability[chosen[bound]]
        if not packed.exact:
            for alone in self.alone:
                alone[:, lane] = np.nan


def all_on_one_line(plots: Plots, marks: Ints, lane: int) -> bool:
    """Whether all radars of a set look along one line to it, so that nothing tells its plots from their neighbours."""
    for one, other in combinations(marks.tolist(), 2):
        sides = [_alone(side_of(plots, int(plots.radar[k]), np.array([k])), lane) for k in (one, other)]
        if not on_one_line(sides[0], sides[1], np.zeros((1, 1), np.int64)).all():
            return False
    return True


def _alone(side: Side, lane: int) -> Side:
    cut = slice(lane, lane + 1)
    ahead = None if side.ahead is None else Points(*(c[:, cut] for c in side.ahead))
    return side._replace(range_m=side.range_m[:, cut], angle_rad=side.angle_rad[:, cut], ahead=ahead)
