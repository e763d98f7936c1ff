"""How well the plots of two radars agree, pair by pair, trials side by side.

Components stand in arrays of their own with the trials innermost, so that every line is elementwise arithmetic and a
trial's bytes do not depend on its neighbours. Long blocks are cut into pieces that stay in the cache.

References
----------
prosov2008, eqs. (1)-(4) and the test after them; specification 4 to 6.

Differences from the paper
--------------------------
The cost of a pair joins its squared distance with the determinant; `polar` converts nothing and minimises the exact
likelihood over the place of the target.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import AlgorithmError
from algorithms.identification.parameters import PlotConversion
from algorithms.toolbox.association.assignment import pair_costs
from algorithms.toolbox.association.gate import LARGEST_CONDITION
from algorithms.toolbox.association.polar_fusion import PolarFusion, fuse_polar
from algorithms.toolbox.frames.polar_conversion import plane_components

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# So many trials at a time stay in the cache.
BLOCK = 2048
# Pairs farther apart than this by the converted points are not asked for the exact likelihood: no gate is that wide.
FAR_STATISTIC = 400.0


class Points(NamedTuple):
    """Plots in the common plane, each (n, L): m and m2."""

    x: Floats
    y: Floats
    xx: Floats
    yy: Floats
    xy: Floats


class Side(NamedTuple):
    """Plots of one radar: n of them, L trials."""

    site: Floats
    """(2,) m"""
    range_m: Floats
    """(n, L); NaN = none"""
    angle_rad: Floats
    """(n, L) counter-clockwise from east"""
    sigma_range: float
    sigma_angle: float
    ahead: Points | None = None
    """how far each target has gone on from its plot's instant to that of the look, and what covariance this adds"""


class PairStatistics(NamedTuple):
    """What n plots of one radar and m of another have to do with each other."""

    statistic: Floats
    """(n, m, L) squared normalised distance; NaN where one of the two is missing"""
    cost: Floats
    """(n, m, L) -ln of the likelihood that they are one target, ln m2"""
    unsettled: int
    """how many minimisations were replaced by the converted points because they did not settle"""


def points_of(side: Side, conversion: PlotConversion) -> Points:
    """Convert and move into the common plane; what no conversion is meant for gets `mucm`."""
    name = "mucm" if conversion == "polar" else conversion
    cos, sin = np.cos(side.angle_rad), np.sin(side.angle_rad)
    x, y, *covariance = plane_components(side.range_m, cos, sin, side.sigma_range, side.sigma_angle, name)
    points = Points(x + side.site[0], y + side.site[1], *covariance)
    if side.ahead is None:
        return points
    if name == "paper_literal":
        # The misprint's ellipse lies across that of the errors: what the track knows cannot be taken off it.
        return points._replace(x=points.x + side.ahead.x, y=points.y + side.ahead.y)
    return Points(*(a + b for a, b in zip(points, side.ahead, strict=True)))


def pair_statistics(first: Side, second: Side, conversion: PlotConversion) -> PairStatistics:
    """Compare all plots of one radar with all of another.

    Raises
    ------
    AlgorithmError
        The covariance of a difference is singular.
    """
    n, lanes = first.range_m.shape
    m = second.range_m.shape[0]
    statistic, log_determinant = np.empty((n, m, lanes)), np.empty((n, m, lanes))
    for begin in range(0, lanes, BLOCK):
        cut = slice(begin, begin + BLOCK)
        a, b = (
            points_of(
                side._replace(
                    range_m=side.range_m[:, cut],
                    angle_rad=side.angle_rad[:, cut],
                    ahead=None if side.ahead is None else Points(*(c[:, cut] for c in side.ahead)),
                ),
                conversion,
            )
            for side in (first, second)
        )
        compared_points(a, b, statistic[:, :, cut], log_determinant[:, :, cut])
    cost = pair_costs(statistic, log_determinant)
    unsettled = _exact(first, second, statistic, cost) if conversion == "polar" else 0
    return PairStatistics(statistic, cost, unsettled)


def compared_points(a: Points, b: Points, statistic: Floats, log_determinant: Floats | None) -> None:
    """Fill (n, m, L) with d' (R1 + R2)^-1 d of all pairs, and ln det (R1 + R2) where it is wanted."""
    for i in range(a.x.shape[0]):
        dx, dy = a.x[i] - b.x, a.y[i] - b.y
        xx, yy, xy = a.xx[i] + b.xx, a.yy[i] + b.yy, a.xy[i] + b.xy
        determinant = xx * yy - xy * xy
        trace = xx + yy
        if (determinant * LARGEST_CONDITION <= trace * trace).any():
            raise AlgorithmError(
                "Two plots are unknown along the same line only, so nothing can be compared.",
                remedy="Look at the accuracies of range and azimuth: one is many orders of magnitude from the other.",
                code="singular_pair",
            )
        statistic[i] = (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / determinant
        if log_determinant is not None:
            log_determinant[i] = np.log(determinant)


def _exact(first: Side, second: Side, statistic: Floats, cost: Floats) -> int:
    """Replace what the converted points say of pairs that are not far apart by the exact likelihood."""
    i, j, lane = np.nonzero(statistic < FAR_STATISTIC)
    if not i.size:
        return 0
    found = _most_likely((first, (i, lane)), (second, (j, lane)))
    good = found.converged
    statistic[i[good], j[good], lane[good]] = found.statistic[good]
    cost[i[good], j[good], lane[good]] = found.cost[good]
    return int((~good).sum())


def _most_likely(*plots: tuple[Side, tuple[Any, ...]]) -> PolarFusion:
    """The most likely places from one plot of each side; which plots, their positions say."""
    each = zip(*(_as_seen(side, chosen) for side, chosen in plots), strict=True)
    return fuse_polar(*(np.stack(values) for values in each))


def _as_seen(side: Side, chosen: tuple[Any, ...]) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Site (N, 2), range, angle and their standard deviations (N,) of some plots, as of the look's instant.

    A target that has gone on by v looks now as it did then if the radar had stood farther by v. The doubt about v
    widens the errors of range and azimuth by its parts along and across the line of sight.
    """
    r, b = side.range_m[chosen], side.angle_rad[chosen]
    site = np.broadcast_to(side.site, (r.size, 2))
    rr, bb = np.full(r.shape, side.sigma_range), np.full(r.shape, side.sigma_angle)
    if side.ahead is None:
        return site, r, b, rr, bb
    x, y, xx, yy, xy = (c[chosen] for c in side.ahead)
    cos, sin = np.cos(b), np.sin(b)
    along = xx * cos**2 + yy * sin**2 + 2 * xy * sin * cos
    across = xx * sin**2 + yy * cos**2 - 2 * xy * sin * cos
    return site + np.stack([x, y], axis=1), r, b, np.sqrt(rr**2 + along), np.sqrt(bb**2 + across / r**2)


def fused(first: Side, second: Side, conversion: PlotConversion, i: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Places (n, 2, L) and covariances xx, yy, xy (n, 3, L) from each plot and its partner i (n, L), -1 = none.

    Where plots go on to the instant of their look, both are those at that instant.
    """
    chosen = _partners(second, i)
    place, covariance = mean_of(points_of(first, conversion), points_of(chosen, conversion))
    if conversion == "polar":
        both = np.isfinite(place[:, 0])
        if both.any():
            found = _most_likely((first, (both,)), (chosen, (both,)))
            for axis in (0, 1):
                place[:, axis][both] = found.point[:, axis]
            for k, (row, column) in enumerate(((0, 0), (1, 1), (0, 1))):
                covariance[:, k][both] = found.covariance[:, row, column]
    return place, covariance


def on_one_line(first: Side, second: Side, i: NDArray[np.int64]) -> Bools:
    """(n, L) whether both radars measure the same of a plot and its partner i (n, L): how far it is along one line.

    The azimuth error of either radar, seen along the line of sight of the other one, is then smaller than the error
    of its range. Targets beside each other across that line cannot be told apart (specification 10).
    """
    other = _partners(second, i)
    place, _ = mean_of(points_of(first, "mucm"), points_of(other, "mucm"))
    lines = [np.stack([place[:, 0] - side.site[0], place[:, 1] - side.site[1]]) for side in (first, second)]
    far = [np.hypot(*line) for line in lines]
    sine = np.abs(lines[0][0] * lines[1][1] - lines[0][1] * lines[1][0]) / (far[0] * far[1])
    out = np.ones(i.shape, np.bool_)
    for side, distance in zip((first, second), far, strict=True):
        out &= distance * side.sigma_angle * sine <= side.sigma_range
    return out


def _partners(side: Side, i: NDArray[np.int64]) -> Side:
    """Plots i (n, L) of a side, -1 = none."""
    return side._replace(
        range_m=_chosen(side.range_m, i),
        angle_rad=_chosen(side.angle_rad, i),
        ahead=None if side.ahead is None else Points(*(_chosen(c, i) for c in side.ahead)),
    )


def _chosen(values: Floats, i: NDArray[np.int64]) -> Floats:
    if not values.shape[0]:
        return np.full(i.shape, np.nan)
    taken: Floats = np.where(i >= 0, np.take_along_axis(values, np.maximum(i, 0), axis=0), np.nan)
    return taken


def mean_of(a: Points, b: Points) -> tuple[Floats, Floats]:
    """Means (n, 2, L) of two points each, weighted with their information, and covariances (n, 3, L).

    As a + K (b - a) with K = A (A + B)^-1 and K B, so that neither point needs an inverse of its own.
    """
    xx, yy, xy = a.xx + b.xx, a.yy + b.yy, a.xy + b.xy
    determinant = xx * yy - xy * xy
    k11 = (a.xx * yy - a.xy * xy) / determinant
    k12 = (a.xy * xx - a.xx * xy) / determinant
    k21 = (a.xy * yy - a.yy * xy) / determinant
    k22 = (a.yy * xx - a.xy * xy) / determinant
    dx, dy = b.x - a.x, b.y - a.y
    place = np.stack([a.x + k11 * dx + k12 * dy, a.y + k21 * dx + k22 * dy], axis=1)
    cross = (k11 * b.xy + k12 * b.yy + k21 * b.xx + k22 * b.xy) / 2
    return place, np.stack([k11 * b.xx + k12 * b.xy, k21 * b.xy + k22 * b.yy, cross], axis=1)
