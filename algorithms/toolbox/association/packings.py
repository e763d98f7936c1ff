"""Probability of each set of plots: the share of all choices of disjoint sets that hold it, each choice weighted.

Plots that no set joins have nothing to do with each other, so each connected group is summed by itself. A group is
swept plot by plot: the state is which of the later plots are already taken by a set begun earlier, and each plot is
alone, taken, or the first one of a set. Sums over the states forwards and backwards give all probabilities at once, as
for a hidden Markov chain. In an order of small bandwidth (Cuthill and McKee) the states stay few; a group with more
steps than `MOST_STEPS` is not summed.

References
----------
specification 5 and 7: for sets of two plots these are the probabilities of the pairs.
"""

from __future__ import annotations

from math import exp, inf, log1p

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_STEPS = 200_000
"""Steps from state to state up to which a group is summed: half a second."""

_Step = tuple[int, int, float]
"""Number of a set, its plots after the first one as bits, its score."""


def packing_probabilities(members: Ints, scores: Floats, plots: int, most_steps: int = MOST_STEPS) -> Floats:
    """(T,) probability of each set, NaN where its group is too large.

    Parameters
    ----------
    members : (T, K) numbers of the plots of each set, below `plots`; -1 = none
    scores : (T,) ln of how much more likely a set is than that its plots are all alone
    """
    out = np.full(len(scores), np.nan)
    column, which = np.nonzero(members >= 0)
    holds = coo_array((np.ones(column.size), (column, members[column, which])), shape=(len(scores), plots)).tocsr()
    graph = (holds.T @ holds).tocsr()
    _, group = connected_components(graph, directed=False)
    position = np.empty(plots, np.int64)
    position[reverse_cuthill_mckee(graph, symmetric_mode=True)] = np.arange(plots)
    of_set = group[members.max(axis=1)] if len(scores) else np.empty(0, np.int64)
    for g in np.unique(of_set):
        chosen = np.flatnonzero(of_set == g)
        own = np.flatnonzero(group == g)
        own = own[np.argsort(position[own])]
        place = np.full(plots + 1, -1)
        place[own] = np.arange(own.size)
        out[chosen] = _swept(place[members[chosen]], scores[chosen], own.size, most_steps)
    return out


def _swept(members: Ints, scores: Floats, plots: int, most_steps: int) -> Floats:
    """Probabilities of the sets of one group, whose plots are numbered in the order of the sweep."""
    begins: list[list[_Step]] = [[] for _ in range(plots)]
    for t, row in enumerate(members.tolist()):
        taken = sorted(i for i in row if i >= 0)
        begins[taken[0]].append((t, sum(1 << i for i in taken[1:]), float(scores[t])))
    layers: list[dict[int, float]] = [{0: 0.0}]
    steps = 0
    for i in range(plots):
        following: dict[int, float] = {}
        for state, value in layers[i].items():
            if state >> i & 1:
                _add(following, state ^ 1 << i, value)
                steps += 1
                continue
            _add(following, state, value)
            for _, rest, score in begins[i]:
                if not state & rest:
                    _add(following, state | rest, value + score)
            steps += 1 + len(begins[i])
        if steps > most_steps:
            return np.full(len(scores), np.nan)
        layers.append(following)
    total = layers[plots][0]
    out = np.full(len(scores), -inf)
    after: dict[int, float] = {0: 0.0}
    for i in reversed(range(plots)):
        before: dict[int, float] = {}
        for state, value in layers[i].items():
            if state >> i & 1:
                before[state] = after[state ^ 1 << i]
                continue
            sum_of = {state: after[state]}
            for t, rest, score in begins[i]:
                if not state & rest:
                    on = score + after[state | rest]
                    _add(sum_of, state, on)
                    out[t] = _both(out[t], value + on - total)
            before[state] = sum_of[state]
        after = before
    return np.minimum(np.exp(out), 1.0)


def _add(sums: dict[int, float], state: int, value: float) -> None:
    """Add what has this logarithm to a state's sum."""
    sums[state] = _both(sums.get(state, -inf), value)


def _both(a: float, b: float) -> float:
    """Ln (e^a + e^b)"""
    if a < b:
        a, b = b, a
    return a if b == -inf else a + log1p(exp(b - a))
