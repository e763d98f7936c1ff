"""Nearest neighbours of many tracks and plots at once: pairs inside gates, and the best assignment among them.

Gates leave each track a few plots, so the pairs are kept as a list. They fall into connected components, each of which
is assigned by itself; most hold one track or one plot and need no solver.

References
----------
crouse2016.
"""

from __future__ import annotations

from dataclasses import dataclass
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
    track, plot : (K,) the two sides of each possible pair, positions >= 0 in some table
    cost : (K,) finite
    """
    alone, rest = _pairs_alone(track, plot)
    if not rest.size:
        return alone
    found = clusters(track[rest], plot[rest])
    # A track with its plots, or a plot with its tracks, is one pair: the cheapest.
    star = ((found.tracks == 1) | (found.plots == 1))[found.of]
    simple = np.flatnonzero(star)
    simple = simple[np.lexsort((cost[rest[simple]], found.of[simple]))]
    first = np.ones(simple.size, bool)
    first[1:] = np.diff(found.of[simple]) > 0
    cheapest = _assigned(found, np.flatnonzero(~star), cost[rest])
    return np.sort(np.concatenate([alone, rest[simple[first]], rest[cheapest]]))


def _pairs_alone(track: Ints, plot: Ints) -> tuple[Ints, Ints]:
    """Positions of the pairs whose track and plot are in no other pair, and of all the others, in rising order."""
    if not track.size:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    alone = (np.bincount(track)[track] == 1) & (np.bincount(plot)[plot] == 1)
    return np.flatnonzero(alone), np.flatnonzero(~alone)


def _labelled(track: Ints, plot: Ints) -> tuple[Ints, Ints, Ints]:
    """Number of each pair's connected component, and how many tracks and plots each component has."""
    t, tracks = _numbered(track)
    p, plots = _numbered(plot)
    graph = coo_array((np.ones(t.size), (t, tracks + p)), shape=(tracks + plots, tracks + plots))
    count, part = connected_components(graph, directed=False)
    return part[t], np.bincount(part[:tracks], minlength=count), np.bincount(part[tracks:], minlength=count)


def _numbered(value: Ints) -> tuple[Ints, int]:
    """Values numbered in their order, and how many different ones there are."""
    there = np.bincount(value) > 0
    return (np.cumsum(there) - 1)[value], int(there.sum())


def _split(pairs: Ints, component: Ints) -> list[Ints]:
    """Pairs of each component, one after the other."""
    order = pairs[np.argsort(component[pairs], kind="stable")]
    return np.split(order, np.flatnonzero(np.diff(component[order])) + 1) if order.size else []


@dataclass(frozen=True)
class Clusters:
    """Tracks and plots that gates join, also through others; N clusters of K pairs."""

    of: Ints
    """(K,) cluster of each pair"""
    row: Ints
    """(K,) which of its cluster's tracks it has, in the order of tracks"""
    column: Ints
    """(K,) which of its cluster's plots"""
    tracks: Ints
    """(N,)"""
    plots: Ints
    """(N,)"""


def clusters(track: Ints, plot: Ints) -> Clusters:
    """The connected components of pairs (K,), and the place of each pair in the table of its component."""
    if not track.size:
        none = np.empty(0, np.int64)
        return Clusters(none, none, none, none, none)
    of, tracks, plots = _labelled(track, plot)
    return Clusters(of, _place(of, track), _place(of, plot), tracks, plots)


def _place(group: Ints, value: Ints) -> Ints:
    """(K,) how many smaller values there are in the group of each."""
    order = np.lexsort((value, group))
    g, v = group[order], value[order]
    new_group, new_value = np.ones(g.size, bool), np.ones(g.size, bool)
    new_group[1:] = np.diff(g) > 0
    new_value[1:] = new_group[1:] | (np.diff(v) > 0)
    at = np.cumsum(new_value) - 1
    out = np.empty(g.size, np.int64)
    out[order] = at - np.maximum.accumulate(np.where(new_group, at, 0))
    return out


def _assigned(found: Clusters, among: Ints, cost: Floats) -> Ints:
    """The pairs `among` that are chosen, cluster by cluster: as many as can be made, and of those the cheapest."""
    chosen = [np.empty(0, np.int64)]
    for pairs in _split(among, found.of):
        rows, columns = (int(side[found.of[pairs[0]]]) for side in (found.tracks, found.plots))
        own, r, c = cost[pairs], found.row[pairs], found.column[pairs]
        # Dearer than any sum of real costs: only taken where nothing else is left, and thrown away afterwards.
        least, most = own.min(), own.max()
        table = np.full((rows, columns), (most - least + 1.0) * (min(rows, columns) + 1))
        table[r, c] = own - least
        at = np.full(table.shape, -1)
        at[r, c] = pairs
        taken = at[linear_sum_assignment(table)]
        chosen.append(taken[taken >= 0])
    return np.concatenate(chosen)


def greatest_gain(track: Ints, plot: Ints, gain: Floats) -> Ints:
    """Positions of the pairs of the matching with the largest total gain, in rising order; a gain of 0 is no pair.

    Parameters
    ----------
    track, plot : (K,) the two sides of each possible pair, positions >= 0; gain : (K,) >= 0
    """
    alone, rest = _pairs_alone(track, plot)
    several: list[Ints] = []
    if rest.size:
        component, _, _ = _labelled(track[rest], plot[rest])
        several = [rest[pairs] for pairs in _split(np.arange(rest.size), component)]
    chosen = (_gaining(pairs, track, plot, gain) for pairs in several)
    return np.sort(np.concatenate([alone[gain[alone] > 0], *chosen]))


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
