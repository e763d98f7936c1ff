"""A track's last plots, side by side for many tracks, and what a trajectory leaves of them.

W windows of at most H plots each: arrays (H, W), the newest plot last at t = 0, unused places before the oldest marked
by `known`. Every sum runs over the plots one after the other, so a window's numbers do not depend on its neighbours.

The cost of a trajectory is the sum of ((rho - rho(t)) / sigma_r)^2 + (wrap(theta - theta(t)) / sigma_th)^2, twice the J
of the specification. The weights cannot be left out: metres and radians stand in one sum.

References
----------
plots2006, section 3; specification 4.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.motion.curvature import Floats, position, position_jacobian, wrapped

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

LARGEST_CONDITION = 1e14


class Window(NamedTuple):
    """W windows of at most H plots; the newest is the last one, at t = 0."""

    rho: Floats
    """(H, W) m"""
    theta: Floats
    """(H, W) rad, clockwise from north"""
    t: Floats
    """(H, W) s, <= 0"""
    known: Bools
    """(H, W)"""
    sigma_r: Floats
    """(H, W) m"""
    sigma_th: Floats
    """(H, W) rad"""

    def take(self, which: Ints) -> Window:
        """Some of the windows."""
        return Window(
            self.rho[:, which],
            self.theta[:, which],
            self.t[:, which],
            self.known[:, which],
            self.sigma_r[:, which],
            self.sigma_th[:, which],
        )

    @property
    def plots(self) -> Ints:
        """(W,) number of plots."""
        out: Ints = self.known.sum(axis=0)
        return out

    @property
    def span_s(self) -> Floats:
        """(W,) time from the oldest to the newest plot, s."""
        out: Floats = -np.where(self.known, self.t, 0.0).min(axis=0)
        return out

    @property
    def cartesian(self) -> tuple[Floats, Floats]:
        """(H, W) north and east, m."""
        return self.rho * np.cos(self.theta), self.rho * np.sin(self.theta)


class Fit(NamedTuple):
    """A trajectory for each window, at the epoch of its newest plot."""

    p: Floats
    """(6, W): x0, y0, g0, b, a, K (`algorithms.toolbox.motion.curvature`)"""
    information: Floats
    """(6, 6, W), with the penalty where there is one; a line leaves the rows of a and K empty"""
    cost: Floats
    """(W,), without the penalty: chi-square"""
    converged: Bools
    """(W,)"""

    def put(self, where: Ints, other: Fit) -> None:
        """Write the windows of another fit into places of this one."""
        self.p[:, where] = other.p
        self.information[:, :, where] = other.information
        self.cost[where] = other.cost
        self.converged[where] = other.converged

    def take(self, which: Ints) -> Self:
        """Some of the windows."""
        return self._replace(
            p=self.p[:, which],
            information=self.information[:, :, which],
            cost=self.cost[which],
            converged=self.converged[which],
        )


def residuals(window: Window, p: Floats) -> Floats:
    """Whitened residuals of ranges, then azimuths, (2 H, W); 0 where there is no plot."""
    x, y = position(p[:, None], window.t)
    out = np.concatenate(
        [
            (window.rho - np.hypot(x, y)) / window.sigma_r,
            wrapped(window.theta - np.arctan2(y, x)) / window.sigma_th,
        ]
    )
    return np.where(np.concatenate([window.known, window.known]), out, 0.0)


def whitened(window: Window, p: Floats) -> tuple[Floats, Floats]:
    """Whitened residuals (2 H, W) and their negative derivatives by the parameters (2 H, 6, W)."""
    x, y, dx, dy = position_jacobian(p[:, None], window.t)
    rho = np.maximum(np.hypot(x, y), 1e-3)
    to_rho = (x * dx + y * dy) / (rho * window.sigma_r)
    to_theta = (x * dy - y * dx) / (rho**2 * window.sigma_th)
    jacobian = np.concatenate([to_rho, to_theta], axis=1).swapaxes(0, 1)
    known = np.concatenate([window.known, window.known])
    return residuals(window, p), np.where(known[:, None], jacobian, 0.0)


def cost_of(window: Window, p: Floats) -> Floats:
    """Chi-square of a trajectory, (W,)."""
    return sum_of_squares(residuals(window, p))


def sum_of_squares(rows: Floats) -> Floats:
    """Sum over the first axis, one row after the other."""
    return _sum(rows * rows)


def moments(weight: Floats, t: Floats, order: int) -> list[Floats]:
    """Sums (W,) over the plots of weight t^0, weight t^1 ... weight t^order, one plot after the other."""
    out = []
    power = np.ones_like(t)
    for _ in range(order + 1):
        out.append(_sum(weight * power))
        power = power * t
    return out


def _sum(rows: Floats) -> Floats:
    total = np.zeros(rows.shape[1:])
    for row in rows:
        total += row
    return total


def covariance_of(information: Floats) -> Floats:
    """Inverse of an information matrix (n, n, W), scaled to a unit diagonal first; NaN where it is singular.

    In SI units its condition is 1e16, scaled some hundreds.
    """
    out = np.full_like(information, np.nan)
    diagonal = np.einsum("iiw->iw", information)
    used = np.flatnonzero((diagonal > 0).all(axis=0) & np.isfinite(information).all(axis=(0, 1)))
    if used.size:
        d = np.sqrt(diagonal[:, used])
        scaled = np.moveaxis(information[:, :, used] / (d[:, None] * d[None]), -1, 0)
        inverse, sound = _inverted(scaled)
        inverse = np.moveaxis(inverse, 0, -1)
        inverse = 0.5 * (inverse + inverse.swapaxes(0, 1)) / (d[:, None] * d[None])
        out[:, :, used] = np.where(sound, inverse, np.nan)
    return out


def solved(n: Floats, g: Floats) -> Floats:
    """Solutions of symmetric systems (m, m, W) x = (m, ..., W) with a unit diagonal; NaN where one is singular."""
    diagonal = np.einsum("iiw->iw", n)
    d = np.sqrt(np.where(diagonal > 0, diagonal, np.nan))
    scaled = np.moveaxis(n / (d[:, None] * d[None]), -1, 0)
    sound = np.isfinite(scaled).all(axis=(1, 2))
    _, sound[sound] = _inverted(scaled[sound])
    right = g.reshape(len(g), math.prod(g.shape[1:-1]), g.shape[-1]) / d[:, None]
    out = np.full_like(right, np.nan)
    found = np.linalg.solve(scaled[sound], np.moveaxis(right[..., sound], -1, 0))
    out[..., sound] = np.moveaxis(found, 0, -1) / d[:, None, sound]
    return out.reshape(g.shape)


def _inverted(matrices: Floats) -> tuple[Floats, Bools]:
    """Inverses of a stack (W, m, m), and which of them mean something: their condition (1-norm) is small enough."""
    # What the determinant calls singular would stop the inversion of all others.
    sound = np.linalg.det(matrices) > 0
    inverse = np.linalg.inv(np.where(sound[:, None, None], matrices, np.eye(matrices.shape[-1])))
    condition = np.abs(matrices).sum(axis=1).max(axis=1) * np.abs(inverse).sum(axis=1).max(axis=1)
    return inverse, sound & (condition < LARGEST_CONDITION)
