"""Polynomials in X and Y apart, of degree 1 to 3, through the plots of windows: what a joint curve is compared with.

References
----------
plots2006, section 3 (cubics bend both ways); specification 4.3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.plot_tracking.window import Bools, Window, covariance_of, solved
from algorithms.toolbox.motion.curvature import Floats

# Instants of a window at which the bend of a polynomial is looked at.
LOOKS = 50


class Polynomials(NamedTuple):
    """Of W windows, at the epochs of their newest plots."""

    x: Floats
    """(degree + 1, W) derivatives of X, the place first"""
    y: Floats
    covariance: Floats
    """(degree + 1, degree + 1, W) of either"""

    def at(self, t: Floats) -> tuple[Floats, Floats]:
        """X and Y in m at t (W,) s after the epoch."""
        return _value(self.x, t), _value(self.y, t)

    def bends_both_ways(self, span_s: Floats) -> Bools:
        """(W,) whether the curvature changes its sign between the oldest and the newest plot."""
        t = -span_s * np.linspace(0.0, 1.0, LOOKS)[:, None]
        vx, vy = _value(self.x[1:], t), _value(self.y[1:], t)
        ax, ay = _value(self.x[2:], t), _value(self.y[2:], t)
        cross = vx * ay - vy * ax
        out: Bools = (cross.min(axis=0) < 0) & (cross.max(axis=0) > 0)
        return out


def fit_polynomials(window: Window, degree: int) -> Polynomials:
    """Weighted polynomials; a plot's weight is that of the mean of its errors along and across the ray."""
    x, y = window.cartesian
    weight = 2.0 * window.known / (window.sigma_r**2 + (window.rho * window.sigma_th) ** 2)
    count, size = window.rho.shape[1], degree + 1
    n = np.zeros((size, size, count))
    gx, gy = np.zeros((size, count)), np.zeros((size, count))
    for k in range(window.rho.shape[0]):
        to = [np.ones(count)]
        for power in range(1, size):
            to.append(to[-1] * window.t[k] / power)
        rows = np.stack(to)
        n += weight[k] * rows[:, None] * rows[None]
        gx += weight[k] * rows * x[k]
        gy += weight[k] * rows * y[k]
    return Polynomials(solved(n, gx), solved(n, gy), covariance_of(n))


def _value(derivatives: Floats, t: Floats) -> Floats:
    """Taylor's sum of derivatives (k, W) at t."""
    total: Floats = derivatives[0] + 0.0 * t
    term = np.ones_like(total)
    for n, d in enumerate(derivatives[1:], start=1):
        term = term * t / n
        total = total + d * term
    return total
