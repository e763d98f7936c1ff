"""Fewer points for display: largest triangles (LTTB) for curves, every k-th for marks; gaps stay gaps."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tsdownsample import LTTBDownsampler

from backend.charts.columns import Floats, Ints

GAP = -1
# A segment keeps its ends and its farthest point, however many segments share the budget.
FEWEST = 3
HOLE_S = 60.0
HOLE_INTERVALS = 5.0


@dataclass(frozen=True)
class Picked:
    """Positions to draw in order, GAP where the line is broken; how many of how many points they are."""

    positions: Ints
    shown: int
    of: int

    def take(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values at the positions; NaN (floats), -1 (integers) or empty text at gaps."""
        if values.shape[0] == 0:
            return values[:0]
        out = values[self.positions]
        gap = self.positions == GAP
        if gap.any():
            out[gap] = np.nan if out.dtype.kind == "f" else GAP if out.dtype.kind in "iu" else ""
        return out

    @property
    def piece_starts(self) -> Ints:
        """Positions of the first points of the unbroken pieces."""
        there = self.positions != GAP
        begins = there & ~np.append(False, there[:-1])[: there.size]
        starts: Ints = self.positions[begins]
        return starts


def line_starts(key: Ints, time: Floats) -> NDArray[np.bool_]:
    """First points of lines over points sorted by key (track, target) and time.

    A line ends with its key, and at a hole: longer than a minute and than five usual intervals, it says that nothing
    is known between its sides.
    """
    starts = np.append(True, key[1:] != key[:-1])[: key.size]
    step = np.append(np.nan, np.diff(time))[: key.size]
    within = step[~starts & (step > 0)]
    hole = max(HOLE_S, HOLE_INTERVALS * float(np.median(within))) if within.size else np.inf
    return starts | (step > hole)


def curve(time: Floats, values: tuple[Floats, ...], starts: NDArray[np.bool_], most: int | None) -> Picked:
    """Pick points of broken lines over time.

    Parameters
    ----------
    time : (n,) float, s, rising within a line
    values : curves over the same instants (two for a path in the plane); where any is not finite the line breaks
    starts : (n,) bool, True at the first point of each line
    most : largest number of points to keep, None = all; every segment keeps at least three
    """
    finite = np.isfinite(time)
    for value in values:
        finite &= np.isfinite(value)
    kept = np.flatnonzero(finite)
    segment = np.cumsum(starts.astype(np.int64) + ~finite)[kept]
    of = int(kept.size)
    if most is not None and of > most:
        kept, segment = _largest_triangles(time, values, kept, segment, most / of)
    breaks = np.flatnonzero(np.diff(segment)) + 1
    return Picked(np.insert(kept, breaks, GAP), int(kept.size), of)


def _largest_triangles(
    time: Floats, values: tuple[Floats, ...], kept: Ints, segment: Ints, share: float
) -> tuple[Ints, Ints]:
    picked = []
    edges = np.concatenate(([0], np.flatnonzero(np.diff(segment)) + 1, [kept.size]))
    for first, last in itertools.pairwise(edges.tolist()):
        part = kept[first:last]
        fewer = max(FEWEST, int(part.size * share / len(values)))
        if part.size <= fewer:
            picked.append(np.arange(first, last))
            continue
        # Time relative to the start: LTTB only compares areas, and offsets keep the digits.
        since = np.ascontiguousarray(time[part] - time[part[0]])
        chosen = [
            LTTBDownsampler().downsample(since, np.ascontiguousarray(value[part]), n_out=fewer).astype(np.int64)
            for value in values
        ]
        picked.append(first + np.unique(np.concatenate(chosen)))
    order = np.concatenate(picked)
    return kept[order], segment[order]


def thin(positions: Ints, most: int | None) -> Picked:
    """Every k-th of the marks at these positions: an even sample, unlike a choice of extremes."""
    step = 1 if most is None else max(1, -(-positions.size // most))
    chosen = positions[::step]
    return Picked(chosen, int(chosen.size), int(positions.size))
