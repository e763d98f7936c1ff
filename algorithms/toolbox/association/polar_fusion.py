"""The place from which several radars saw a target, and how well they agree: the exact likelihood in polar axes.

For measurements r_k, b_k of K radars at s_k the place minimises

    J(p) = sum_k ((r_k - |p - s_k|) / sigma_rk)^2 + (wrapped(b_k - angle(p - s_k)) / sigma_bk)^2,

by Gauss-Newton steps, damped as soon as one makes J grow. S = min J is chi-square with 2 K - 2 degrees of freedom where
all saw one target, at any nonlinearity: nothing is converted.

References
----------
more1978, the damping. The cost of a pair is Laplace's approximation of the integral over the place.

Differences from the paper
--------------------------
The paper tests converted points only. In its geometry the approximation of the integral is within 0.0024 nats.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.frames.polar_conversion import cartesian_from_polar, wrapped

Floats = NDArray[np.float64]

STEPS = 25
CONVERGED = 1e-10
# A place on top of a radar has no direction from it; its distance counts as this much in the slopes.
LEAST_RANGE_M = 1e-6


@dataclass(frozen=True)
class PolarFusion:
    """Places and their agreement, for N sets of measurements.

    Attributes
    ----------
    point : (N, 2) m
    covariance : (N, 2, 2) m2, of the linearisation at the minimum
    statistic : (N,) the minimum of J
    converged : (N,) whether the steps became negligible within `STEPS`
    cost : (N,) -ln of the likelihood that all are one target, each measurement's density taken per m2 of the plane:
        for two radars comparable with `assignment.pair_costs`
    """

    point: Floats
    covariance: Floats
    statistic: Floats
    converged: NDArray[np.bool_]
    cost: Floats


def fuse_polar(
    site: Floats, range_m: Floats, angle_rad: Floats, sigma_range_m: Floats, sigma_rad: Floats
) -> PolarFusion:
    """Find the most likely places.

    Parameters
    ----------
    site : (K, 2) m, the radars; (K, N, 2) where they differ from set to set
    range_m, angle_rad : (K, N) m and rad counter-clockwise from east
    sigma_range_m, sigma_rad : (K,) or (K, N)
    """
    shape = range_m.shape
    weights = (
        np.broadcast_to(_per_radar(sigma_range_m, shape), shape),
        np.broadcast_to(_per_radar(sigma_rad, shape), shape),
    )
    sites = site[:, None] if site.ndim == 2 else site
    measured = _Measured(np.broadcast_to(sites, (*shape, 2)), range_m, angle_rad, *weights)
    point = _weighted_mean(measured)
    value = measured.objective(point)
    damping = np.zeros(shape[1])
    active = np.arange(shape[1])
    converged = np.zeros(shape[1], np.bool_)
    for _ in range(STEPS):
        if not active.size:
            break
        here = measured.take(active)
        normal, gradient = here.normal_equations(point[active])
        # Scaled by the diagonal, because an ellipse of error is easily a thousand times longer than wide.
        scale = 1 + damping[active]
        damped = normal.copy()
        damped[:, 0, 0] *= scale
        damped[:, 1, 1] *= scale
        step = _solved(damped, gradient)
        trial = point[active] + step
        after = here.objective(trial)
        better = after <= value[active]
        negligible = np.abs(after - value[active]) <= CONVERGED * (1 + value[active])
        good = active[better]
        point[good], value[good] = trial[better], after[better]
        damping[active] = np.where(better, damping[active] * 0.1, np.maximum(damping[active] * 10, 1e-3))
        converged[active[negligible]] = True
        active = active[~negligible]
    normal, _ = measured.normal_equations(point)
    covariance = _inverse(normal)
    determinant = normal[:, 0, 0] * normal[:, 1, 1] - normal[:, 0, 1] ** 2
    radars = np.log(2 * np.pi * measured.sigma_range * measured.sigma_angle).sum(axis=0) + np.log(range_m).sum(axis=0)
    cost = value / 2 + radars - np.log(2 * np.pi) + np.log(determinant) / 2
    return PolarFusion(point, covariance, value, converged, cost)


@dataclass(frozen=True)
class _Measured:
    """Measurements of K radars, N sets of them."""

    site: Floats
    range: Floats
    angle: Floats
    sigma_range: Floats
    sigma_angle: Floats

    def take(self, sets: NDArray[np.int64]) -> _Measured:
        """Return the same with only these sets."""
        if sets.size == self.range.shape[1]:
            return self
        every = (self.site, self.range, self.angle, self.sigma_range, self.sigma_angle)
        return _Measured(*(a[:, sets] for a in every))

    def residuals(self, point: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Offsets (K, N, 2) from the radars, distances, and normalised residuals of range and angle, (K, N)."""
        offset = point[None] - self.site
        distance = np.maximum(np.hypot(offset[..., 0], offset[..., 1]), LEAST_RANGE_M)
        along = (self.range - distance) / self.sigma_range
        across = wrapped(self.angle - np.arctan2(offset[..., 1], offset[..., 0])) / self.sigma_angle
        return offset, distance, along, across

    def objective(self, point: Floats) -> Floats:
        """J of each set."""
        _, _, along, across = self.residuals(point)
        total: Floats = (along * along + across * across).sum(axis=0)
        return total

    def normal_equations(self, point: Floats) -> tuple[Floats, Floats]:
        """(N, 2, 2) information of the linearisation, and (N, 2) its right side."""
        offset, distance, along, across = self.residuals(point)
        ux, uy = offset[..., 0] / distance, offset[..., 1] / distance
        wr, wb = 1 / self.sigma_range, 1 / (distance * self.sigma_angle)
        xx = (ux * ux * wr * wr + uy * uy * wb * wb).sum(axis=0)
        yy = (uy * uy * wr * wr + ux * ux * wb * wb).sum(axis=0)
        xy = (ux * uy * (wr * wr - wb * wb)).sum(axis=0)
        gx = (ux * wr * along - uy * wb * across).sum(axis=0)
        gy = (uy * wr * along + ux * wb * across).sum(axis=0)
        normal = np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)
        return normal, np.stack([gx, gy], axis=-1)


def _per_radar(sigma: Floats, shape: tuple[int, ...]) -> Floats:
    values = np.asarray(sigma, float)
    return values[:, None] if values.ndim == 1 and len(shape) == 2 else values


def _weighted_mean(measured: _Measured) -> Floats:
    """(N, 2) mean of the converted measurements, weighted with their information: where the steps begin."""
    points, covariances = cartesian_from_polar(
        measured.range, measured.angle, measured.sigma_range, measured.sigma_angle
    )
    information = _inverse(covariances)
    weighted = np.einsum("knij,knj->ni", information, points + measured.site)
    return _solved(information.sum(axis=0), weighted)


def _inverse(matrix: Floats) -> Floats:
    xx, yy, xy = matrix[..., 0, 0], matrix[..., 1, 1], matrix[..., 0, 1]
    inverse = np.stack([np.stack([yy, -xy], axis=-1), np.stack([-xy, xx], axis=-1)], axis=-2)
    return inverse / (xx * yy - xy * xy)[..., None, None]


def _solved(matrix: Floats, right: Floats) -> Floats:
    return (_inverse(matrix) @ right[..., None])[..., 0]
