"""The last plots of known targets as windows, one for every plot that has enough before it.

Whose a plot is says its target's name, where the recording has names, else its address; a recording without either is
one target. A target has one plot in a scan at most: the first in order of range.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.radars import Feed
from algorithms.plot_tracking.window import Window
from algorithms.recording import CLUTTER, PolarPlots

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Rows(NamedTuple):
    """Places of W windows in a radar's plots: arrays (W,), and (n, W) of their plots."""

    lane: Ints
    number: Ints
    """of the target, from 1"""
    scan: Ints
    """position of the newest plot's scan among the radar's"""
    mark: Ints
    """(n, W) rows of the recording, the newest last"""
    t: Floats
    """(n, W) s"""
    rho: Floats
    """(n, W) m, along the ground from the radar"""
    theta: Floats
    """(n, W) rad"""

    def window(self, which: slice, feed: Feed) -> Window:
        """Some of the windows with their errors."""
        rho = self.rho[:, which]
        sigma_th = np.maximum(feed.sigma_th, feed.across_m / np.maximum(rho, 1.0))
        t = self.t[:, which]
        return Window(
            rho, self.theta[:, which], t - t[-1], np.ones(rho.shape, bool), np.full(rho.shape, feed.sigma_r), sigma_th
        )


def numbers_of(recording: PolarPlots) -> tuple[Ints, dict[str, int]]:
    """Number of each row's target (M,), 0 = none, and the numbers of the named ones."""
    named = np.array([name not in ("", CLUTTER) for name in recording.targets], bool)
    by_name = {name: i + 1 for i, name in enumerate(recording.targets) if name not in ("", CLUTTER)}
    if named.any():
        return np.where(named[recording.target], recording.target + 1, 0), by_name
    if (recording.address >= 0).any():
        return recording.address + 1, {}
    false = np.array([name == CLUTTER for name in recording.targets], bool)
    return np.where(false[recording.target], 0, 1), {}


def rows_of(feed: Feed, number: Ints, plots: int) -> Rows:
    """Windows of so many plots of every target that a radar saw."""
    parts = []
    for s, scan in enumerate(feed.plots.scans):
        of = number[scan.position]
        known = np.flatnonzero(of > 0)
        order = known[np.lexsort((scan.rho[known], of[known], scan.lane[known]))]
        key = np.stack([scan.lane[order], of[order]])
        first = np.ones(order.size, bool)
        first[1:] = (np.diff(key, axis=1) != 0).any(axis=0)
        one = order[first]
        index = np.full(one.size, s)
        parts.append((scan.lane[one], of[one], index, scan.position[one], scan.t[one], scan.rho[one], scan.theta[one]))
    lane, of, scans, position, t, rho, theta = (
        np.concatenate([p[i] for p in parts]) if parts else np.empty(0, np.int64 if i < 4 else float) for i in range(7)
    )
    order = np.lexsort((scans, of, lane))
    lane, of, scans = lane[order], of[order], scans[order]
    # A window ends where a plot of the same target and trial lies so many places before.
    back = np.arange(plots) - (plots - 1)
    newest = np.arange(plots - 1, order.size)
    oldest = newest - (plots - 1)
    newest = newest[(lane[newest] == lane[oldest]) & (of[newest] == of[oldest])]
    # Scan by scan, as everything that is tracked.
    newest = newest[np.lexsort((of[newest], lane[newest], scans[newest]))]
    inside = order[newest[None] + back[:, None]]
    return Rows(
        lane[newest], of[newest], scans[newest], position[inside], t[inside], rho[inside], theta[inside]
    )  # fmt: skip
