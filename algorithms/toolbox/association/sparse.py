"""Nearest neighbours of many tracks and plots at once: pairs inside gates, and the best assignment among them.

Gates leave each track a few plots, so the pairs are kept as a list. They fall into connected components, each of which
is assigned by itself; most hold one track or one plot and need no solver.

References
----------
crouse2016.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def pairs_within(group: Ints, low: Floats, high: Floats, plot_group: Ints, plot_value: Floats) -> tuple[Ints, Ints]:
    """Every (track, plot) of one group whose value lies in the track's interval, in the order of tracks.

    Parameters
    ----------
    group, low, high : (T,) group of a track (its trial) and the interval that its gate spans
    plot_group, plot_value : (P,) in the order of group, then value
    """
    first = _position(plot_group, plot_value, group, low, "left")
    stop = _position(plot_group, plot_value, group, high, "right")
    count = np.maximum(stop - first, 0)
    track = np.repeat(np.arange(group.size), count)
    begin = np.repeat(first - np.concatenate([[0], np.cumsum(count)[:-1]]), count) if group.size else first
    return track, begin + np.arange(track.size)


def _position(plot_group: Ints, plot_value: Floats, group: Ints, value: Floats, side: Literal["left", "right"]) -> Ints:
    """Where a (group, value) would stand among the plots."""
    out = np.empty(group.size, np.int64)
    for g in np.unique(group):
        begin, end = np.searchsorted(plot_group, (g, g + 1))
        mine = group == g
        out[mine] = begin + np.searchsorted(plot_value[begin:end], value[mine], side)
    return out


def most_pairs_at_least_cost(track: Ints, plot: Ints, cost: Floats) -> Ints:
    """Positions of the chosen pairs: as many as can be made, and of those the cheapest, in rising order.

    Parameters
    ----------
    track, plot : (K,) the two sides of each possible pair; cost : (K,) finite
    """
    if not track.size:
        return np.empty(0, np.int64)
    tracks, t = np.unique(track, return_inverse=True)
    plots, p = np.unique(plot, return_inverse=True)
    n = tracks.size + plots.size
    graph = coo_array((np.ones(track.size), (t, tracks.size + p)), shape=(n, n))
    _, part = connected_components(graph, directed=False)
    component = part[t]
    # A track with its plots, or a plot with its tracks, is one pair: the cheapest.
    star = (np.bincount(part[: tracks.size], minlength=n) == 1) | (np.bincount(part[tracks.size :], minlength=n) == 1)
    simple = np.flatnonzero(star[component])
    simple = simple[np.lexsort((cost[simple], component[simple]))]
    _, cheapest = np.unique(component[simple], return_index=True)
    order = np.argsort(component, kind="stable")
    order = order[~star[component[order]]]
    several = np.split(order, np.flatnonzero(np.diff(component[order])) + 1) if order.size else []
    return np.sort(np.concatenate([simple[cheapest], *(_assigned(pairs, t, p, cost) for pairs in several)]))


def _assigned(pairs: Ints, t: Ints, p: Ints, cost: Floats) -> Ints:
    rows, r = np.unique(t[pairs], return_inverse=True)
    columns, c = np.unique(p[pairs], return_inverse=True)
    # Dearer than any sum of real costs: only taken where nothing else is left, and thrown away afterwards.
    least, most = float(cost[pairs].min()), float(cost[pairs].max())
    table = np.full((rows.size, columns.size), (most - least + 1.0) * (min(rows.size, columns.size) + 1))
    table[r, c] = cost[pairs] - least
    at = np.full(table.shape, -1)
    at[r, c] = pairs
    found: Ints = at[linear_sum_assignment(table)]
    return found[found >= 0]


def greatest_gain(track: Ints, plot: Ints, gain: Floats) -> Ints:
    """Positions of the pairs of the matching with the largest total gain, in rising order; a gain of 0 is no pair.

    Parameters
    ----------
    track, plot : (K,) the two sides of each possible pair; gain : (K,) >= 0
    """
    chosen = [
        pairs[(gain[pairs] > 0)] if pairs.size == 1 else _gaining(pairs, track, plot, gain)
        for pairs in components(track, plot)
    ]
    return np.sort(np.concatenate(chosen)) if chosen else np.empty(0, np.int64)


def components(track: Ints, plot: Ints) -> list[Ints]:
    """Positions of the pairs of each connected component: of tracks and plots that gates join, also through others."""
    if not track.size:
        return []
    tracks, t = np.unique(track, return_inverse=True)
    plots, p = np.unique(plot, return_inverse=True)
    n = tracks.size + plots.size
    graph = coo_array((np.ones(track.size), (t, tracks.size + p)), shape=(n, n))
    _, part = connected_components(graph, directed=False)
    component = part[t]
    order = np.argsort(component, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(component[order])) + 1)


def _gaining(pairs: Ints, track: Ints, plot: Ints, gain: Floats) -> Ints:
    rows, r = np.unique(track[pairs], return_inverse=True)
    columns, c = np.unique(plot[pairs], return_inverse=True)
    table = np.zeros((rows.size, columns.size))
    table[r, c] = gain[pairs]
    at = np.full(table.shape, -1)
    at[r, c] = pairs
    found: Ints = at[linear_sum_assignment(table, maximize=True)]
    found = found[found >= 0]
    return found[gain[found] > 0]
