"""Pairs of plots from which the agreement of two radars is judged: their differences, covariances and velocities.

Where radars disagree, the pairs that an algorithm accepted are too few and chosen for agreeing. So pairs can also be
found under an assumed error of one radar: plots of both that are nearest to each other both ways once it is undone.
Their differences are always those of the plots as they are.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.pairs import Points, Side, compared_points, points_of
from algorithms.identification.plots import Plots
from algorithms.identification.registration import Accepted, Hypothesis
from algorithms.identification.scenario import CLUTTER
from algorithms.identification.velocities import MOST_POSITIONS, Lines, joined_tracks, lines, velocities
from algorithms.recording import PolarPlots
from algorithms.toolbox.association.polar_fusion import LEAST_RANGE_M, PolarFusion, fuse_polar
from algorithms.toolbox.frames.polar_conversion import wrapped

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Of one radar: linking so many takes five seconds; of more only those with a target's name have a track.
MOST_LINKED = 40_000
MAX_SPEED_MPS = 1000.0
"""Plots without a target's name are joined to tracks below this speed."""


class Placed(NamedTuple):
    """All plots of the first trial in the common plane: (M, 2) m and xx, yy, xy (M, 3) m2; NaN = unusable."""

    place: Floats
    covariance: Floats

    def points(self, rows: Ints) -> Points:
        """Some of the plots as the pairwise comparison takes them."""
        columns = (*self.place[rows].T, *self.covariance[rows].T)
        return Points(*(c[:, None] for c in columns))


def placed(plots: Plots) -> Placed:
    """Convert every plot of the first trial."""
    marks = plots.range_m.shape[0]
    place, covariance = np.full((marks, 2), np.nan), np.full((marks, 3), np.nan)
    for k in range(len(plots.names)):
        own = np.flatnonzero(plots.radar == k)
        p = points_of(
            Side(
                plots.sites[k],
                plots.range_m[own, :1],
                plots.angle_rad[own, :1],
                float(plots.sigma_range[k]),
                float(plots.sigma_angle[k]),
            ),
            "mucm",
        )
        place[own] = np.hstack([p.x, p.y])
        covariance[own] = np.hstack([p.xx, p.yy, p.xy])
    return Placed(place if plots.shift_m is None else place + plots.shift_m, covariance)


def moved(plots: Plots, radar: int, kind: int, value: Floats, velocity: Floats) -> Plots:
    """Undo an error of one radar: of which kind and how large is told as by a `Hypothesis`.

    Parameters
    ----------
    velocity : (M, 2) m/s of each plot's target; a wrong clock cannot be undone where it is NaN
    """
    own = (plots.radar == radar)[:, None]
    before = 0.0 if plots.shift_m is None else plots.shift_m
    if kind == 1:
        return replace(plots, angle_rad=np.where(own, plots.angle_rad + np.radians(value[0]), plots.angle_rad))
    if kind == 2:
        return replace(plots, range_m=np.where(own, np.maximum(plots.range_m - value[0], 1.0), plots.range_m))
    # The error of a plot keeps its axes: it is the place that is moved, not range and azimuth.
    away = value if kind == 0 else np.nan_to_num(velocity) * value[0]
    return replace(plots, shift_m=before + np.where(own, -away, 0.0))


def undone(plots: Plots, hypothesis: Hypothesis, second: int, velocity: Floats) -> Plots:
    """Undo what a hypothesis about two radars says."""
    radar = hypothesis.radar if hypothesis.kind in (1, 2) else second
    return moved(plots, radar, hypothesis.kind, hypothesis.value, velocity)


def statistics(where: Placed, rows: Ints, others: Ints) -> Floats:
    """(n, m) squared normalised distances of plots, infinite where one is unusable."""
    out = np.empty((rows.size, others.size, 1))
    compared_points(where.points(rows), where.points(others), out, None)
    finite: Floats = np.where(np.isfinite(out[:, :, 0]), out[:, :, 0], np.inf)
    return finite


def lone_pairs(plots: Plots, radars: tuple[int, int], limit: float) -> Ints:
    """(N, 2) rows of plots that are near each other and near no other plot, as a squared distance says.

    With a rival in reach a pair would be chosen for agreeing, and chosen pairs confirm any error that one assumes.
    """
    where = placed(plots)
    out = []
    for look in plots.looks:
        rows, others = (look.rows[r] for r in radars)
        if not (rows.size and others.size):
            continue
        near = statistics(where, rows, others) <= limit
        i, j = np.nonzero(near & (near.sum(axis=1) == 1)[:, None] & (near.sum(axis=0) == 1))
        out.append(np.stack([rows[i], others[j]], axis=1))
    return np.concatenate(out) if out else np.empty((0, 2), np.int64)


def target_numbers(recording: PolarPlots) -> Ints:
    """(M,) number of each plot's target where it has a name, else -1."""
    known = np.array([name not in ("", CLUTTER) for name in recording.targets])
    numbers: Ints = np.where(known[recording.target], recording.target, -1)
    return numbers


def velocities_of_plots(recording: PolarPlots, plots: Plots, radar: int) -> Floats:
    """(M, 2) m/s of one radar's targets from its own plots; NaN for other radars and where no track is straight."""
    return lines_of_plots(recording, plots, radar).velocity


def lines_of_plots(recording: PolarPlots, plots: Plots, radar: int) -> Lines:
    """Straight flights of one radar's targets from its own plots; NaN for other radars and where there is none."""
    where = placed(plots)
    looks = [look.rows[radar][plots.usable[look.rows[radar], 0]] for look in plots.looks]
    named = np.where(plots.usable[:, 0] & (plots.radar == radar), target_numbers(recording), -1)
    if sum(int((named[rows] < 0).sum()) for rows in looks) > MOST_LINKED:
        looks = []
    tracks = joined_tracks(looks, named, recording.time_s, where.place, where.covariance, MAX_SPEED_MPS)
    return lines(tracks, recording.time_s, where.place, where.covariance)


def velocities_of_pairs(recording: PolarPlots, plots: Plots, rows: Ints) -> Floats:
    """(N, 2) m/s of the targets of pairs, from the positions fused from both plots."""
    n = len(rows)
    if not n or n > MOST_POSITIONS:
        return np.full((n, 2), np.nan)
    found = _fused(plots, rows)
    covariance = np.stack([found.covariance[:, 0, 0], found.covariance[:, 1, 1], found.covariance[:, 0, 1]], axis=1)
    frame = plots.frame[rows[:, 0]]
    order = np.argsort(frame, kind="stable")
    looks = np.split(order, np.flatnonzero(np.diff(frame[order])) + 1)
    named = target_numbers(recording)[rows]
    named = np.where(named[:, 0] == named[:, 1], named[:, 0], -1)
    time_s = recording.time_s[rows].mean(axis=1)
    tracks = joined_tracks(looks, named, time_s, found.point, covariance, MAX_SPEED_MPS)
    return velocities(tracks, time_s, found.point, covariance)


def _fused(plots: Plots, rows: Ints) -> PolarFusion:
    """The most likely places of pairs."""
    radar = plots.radar[rows[0]]
    return fuse_polar(
        _origins(plots, rows.T),
        plots.range_m[rows.T, 0],
        plots.angle_rad[rows.T, 0],
        plots.sigma_range[radar],
        plots.sigma_angle[radar],
    )


def _origins(plots: Plots, rows: Ints) -> Floats:
    """Where plots (...) are counted from, (..., 2) m."""
    origins: Floats = plots.sites[plots.radar[rows]]
    return origins if plots.shift_m is None else origins + plots.shift_m[rows]


def differences(recording: PolarPlots, plots: Plots, rows: Ints, velocity: Floats) -> Accepted:
    """What the test of the registration takes, of pairs (N, 2); the second plot goes on to the instant of the first.

    Both plots are carried into the plane along and across the lines of sight to the place where the target most likely
    is. Axes at the measured azimuth would be turned by its error, which for wide azimuths looks like a radar that
    measures too far.
    """
    if not len(rows):
        return Accepted.nothing()
    place = _fused(plots, rows).point
    at, spread, offsets = np.zeros(place.shape), np.zeros((len(rows), 3)), []
    for side, sign in ((0, 1.0), (1, -1.0)):
        own, radar = rows[:, side], plots.radar[rows[0, side]]
        offset = place - _origins(plots, own)
        distance = np.maximum(np.hypot(*offset.T), LEAST_RANGE_M)
        ux, uy = offset.T / distance
        along = plots.range_m[own, 0] - distance
        across = distance * wrapped(plots.angle_rad[own, 0] - np.arctan2(uy, ux))
        at = at + sign * np.stack([along * ux - across * uy, along * uy + across * ux], axis=1)
        rr = plots.sigma_range[radar] ** 2
        bb = (distance * plots.sigma_angle[radar]) ** 2
        spread = spread + np.stack([rr * ux**2 + bb * uy**2, rr * uy**2 + bb * ux**2, (rr - bb) * ux * uy], axis=1)
        offsets.append(offset)
    apart = recording.time_s[rows[:, 0]] - recording.time_s[rows[:, 1]]
    ahead = np.where(np.isfinite(velocity), velocity * apart[:, None], 0.0)
    return Accepted(at - ahead, spread, offsets[0], offsets[1], velocity)


def inverse(symmetric: Floats) -> Floats:
    """(N, 3) inverses of symmetric matrices xx, yy, xy."""
    xx, yy, xy = symmetric.T
    inverted: Floats = np.stack([yy, xx, -xy], axis=1) / (xx * yy - xy * xy)[:, None]
    return inverted


def times(symmetric: Floats, vector: Floats) -> Floats:
    """Symmetric matrices xx, yy, xy (N, 3) times vectors (N, 2)."""
    x, y = vector.T
    return np.stack([symmetric[:, 0] * x + symmetric[:, 2] * y, symmetric[:, 2] * x + symmetric[:, 1] * y], axis=1)
