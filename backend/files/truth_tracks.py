"""The true path of one target at any time: a cubic through its neighbouring positions, and no guess beyond them.

Between two positions the path is the cubic through them and one neighbour on either side (a parabola or a straight
line where neighbours lack). Positions further apart than two periods, a period being the median step, leave a gap,
in which nothing is known, as nothing is before the first and after the last.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints

SAME_TIME_S = 1e-6
"""What the text of an epoch time resolves."""
_LONGEST_GAP_PERIODS = 2.0
# Of positions closer together than this, one is enough: their noise would make the slope between them a wild one.
_CLOSEST_PERIODS = 0.25


@dataclass(frozen=True)
class PathPoints:
    """The path at the wanted times; NaN where nothing is known.

    Attributes
    ----------
    position_m, velocity_mps : (N, 3) float
    exact : (N,) bool, a position of that very time was given
    between : (N, 2) int, the given positions used (twice the same where exact), -1 where nothing is known
    """

    position_m: Floats
    velocity_mps: Floats
    exact: NDArray[np.bool_]
    between: Ints


@dataclass(frozen=True)
class TruthTrack:
    """Given positions of one target in order of time; `index` tells where each stood in what was given."""

    time_s: Floats
    position_m: Floats
    velocity_mps: Floats
    index: Ints
    nodes: Ints = field(repr=False)
    """Those between which is interpolated."""
    period_s: float = np.nan
    """Median step, NaN for a single position."""

    @classmethod
    def of(cls, time_s: Floats, position_m: Floats, velocity_mps: Floats, index: Ints) -> TruthTrack:
        """Sort the positions that are complete; of several at one time the first is kept."""
        complete = np.flatnonzero(np.isfinite(position_m).all(axis=1))
        order = complete[np.argsort(time_s[complete], kind="stable")]
        first = np.diff(time_s[order], prepend=-np.inf) > SAME_TIME_S
        order = order[first]
        time = time_s[order]
        period = float(np.median(np.diff(time))) if len(time) > 1 else np.nan
        return cls(time, position_m[order], velocity_mps[order], index[order], _spread(time, period), period)

    def at(self, wanted_s: Floats) -> PathPoints:
        """Positions and velocities at these times; a velocity is the slope of the path where none was given."""
        shape = (len(wanted_s), 3)
        position, slope, given = (np.full(shape, np.nan) for _ in range(3))
        between = np.full((len(wanted_s), 2), -1, np.int64)
        nearest = _nearest(self.time_s, wanted_s)
        exact = nearest >= 0
        if len(self.nodes) > 1:
            time = self.time_s[self.nodes]
            stencil = _Stencil.of(time, np.where(exact, self.time_s[nearest], wanted_s), self.period_s)
            rows = stencil.rows
            position[rows], slope[rows] = stencil.cubic(self.position_m[self.nodes])
            given[rows] = stencil.cubic(self.velocity_mps[self.nodes])[0]
            between[rows] = self.index[self.nodes[stencil.inner]]
        found = nearest[exact]
        position[exact], given[exact] = self.position_m[found], self.velocity_mps[found]
        between[exact] = self.index[found][:, None]
        return PathPoints(position, np.where(np.isfinite(given), given, slope), exact, between)


def _spread(time_s: Floats, period_s: float) -> Ints:
    """Positions at least a quarter of a period apart, the first and the last always among them."""
    if len(time_s) < 3 or (np.diff(time_s) >= _CLOSEST_PERIODS * period_s).all():
        return np.arange(len(time_s))
    kept = [0]
    for i, t in enumerate(time_s.tolist()):
        if t - time_s[kept[-1]] >= _CLOSEST_PERIODS * period_s:
            kept.append(i)
    last = len(time_s) - 1
    if kept[-1] != last:
        if len(kept) > 1:
            kept.pop()
        kept.append(last)
    return np.array(kept, np.int64)


def _nearest(given_s: Floats, wanted_s: Floats) -> Ints:
    """Place of the same time among the sorted `given_s`, or -1."""
    if not given_s.size:
        return np.full(len(wanted_s), -1, np.int64)
    after = np.clip(np.searchsorted(given_s, wanted_s), 0, len(given_s) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(given_s[before] - wanted_s) <= np.abs(given_s[after] - wanted_s), before, after)
    return np.where(np.abs(given_s[nearest] - wanted_s) <= SAME_TIME_S, nearest, -1)


@dataclass(frozen=True)
class _Stencil:
    """For each time within a step: the four (or fewer) nodes of its polynomial, as Newton's scheme takes them."""

    rows: Ints
    wanted_s: Floats
    time_s: Floats
    nodes: Ints
    """(N, 4): start and end of the step, then its neighbours; -1 where there is none."""

    @property
    def inner(self) -> Ints:
        return self.nodes[:, :2]

    @classmethod
    def of(cls, time_s: Floats, wanted_s: Floats, period_s: float) -> _Stencil:
        longest = _LONGEST_GAP_PERIODS * period_s * (1 + 1e-9)
        joined = np.diff(time_s) <= longest
        step = np.clip(np.searchsorted(time_s, wanted_s, side="right") - 1, 0, len(time_s) - 2)
        # At a node the slope may also come from the step before it, where the one after it is a gap.
        at_start = ~joined[step] & (wanted_s == time_s[step]) & (step > 0)
        step = np.where(at_start, step - 1, step)
        inside = joined[step] & (wanted_s >= time_s[step]) & (wanted_s <= time_s[step + 1])
        rows = np.flatnonzero(inside)
        i = step[rows]
        before, after = i - 1, i + 2
        before = np.where((before >= 0) & joined[np.maximum(before, 0)], before, -1)
        fits = after < len(time_s)
        after = np.where(fits & joined[np.minimum(i + 1, len(joined) - 1)], after, -1)
        # Where one neighbour lacks, the next one on the other side makes the cubic whole.
        far_after = np.minimum(i + 3, len(time_s) - 1)
        take = (before < 0) & (after >= 0) & (i + 3 < len(time_s)) & joined[far_after - 1]
        before = np.where(take, far_after, before)
        far_before = np.maximum(i - 2, 0)
        take = (after < 0) & (before >= 0) & (before < i) & (i - 2 >= 0) & joined[far_before]
        after = np.where(take, far_before, after)
        # The scheme needs present nodes first.
        third = np.where(before >= 0, before, after)
        fourth = np.where(before >= 0, after, -1)
        return cls(rows, wanted_s[rows], time_s, np.stack([i, i + 1, third, fourth], axis=1))

    def cubic(self, values: Floats) -> tuple[Floats, Floats]:
        """Value and slope of the polynomial through `values` (node, 3): divided differences."""
        t = [self.time_s[self.nodes[:, k]][:, None] for k in range(4)]
        v = [values[self.nodes[:, k]] for k in range(4)]
        absent = [(self.nodes[:, k] < 0)[:, None] | ~np.isfinite(v[k]) for k in range(4)]
        with np.errstate(invalid="ignore", divide="ignore"):
            d01 = (v[1] - v[0]) / (t[1] - t[0])
            d12, d23 = (v[2] - v[1]) / (t[2] - t[1]), (v[3] - v[2]) / (t[3] - t[2])
            d012 = (d12 - d01) / (t[2] - t[0])
            d0123 = ((d23 - d12) / (t[3] - t[1]) - d012) / (t[3] - t[0])
        d012 = np.where(absent[2], 0.0, d012)
        d0123 = np.where(absent[2] | absent[3], 0.0, d0123)
        x0, x1, x2 = (self.wanted_s[:, None] - t[k] for k in range(3))
        value = v[0] + x0 * (d01 + x1 * (d012 + x2 * d0123))
        slope = d01 + d012 * (x0 + x1) + d0123 * (x0 * x1 + x0 * x2 + x1 * x2)
        return value, slope
