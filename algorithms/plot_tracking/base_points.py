"""Measured points as parameters: the fit in the polar coordinates of three base plots, and the printed systems.

Three positions fix a curve with constant acceleration and curvature, so the six polar coordinates q of three base plots
are parameters as good as (x0, y0, g0, b, a, K), and better conditioned: 2 to 6 against 220 to 650. With G = dp/dq the
equations are those of the other fit in other words, and so is the minimum.

The paper's reading, eight coordinates of four plots as unknowns, gives two singular systems: p has six entries, turning
everything about the radar changes no range, and scaling every range changes no azimuth. `printed_systems` returns their
matrices, so that anybody can look at their singular values.

References
----------
plots2006, section 3; specification 4.2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.plot_tracking.curve_fit import three_point_start
from algorithms.plot_tracking.window import Fit, Window, cost_of, whitened
from algorithms.toolbox.motion.curvature import (
    Floats,
    from_three_positions,
    position,
    position_jacobian,
    with_forward_speed,
    wrapped,
)

STEPS = 40
STEP_DONE = 1e-7


class Printed(NamedTuple):
    """Whitened matrices of the systems that the paper prints, for the plots of one window."""

    ranges: Floats
    """(n, 8)"""
    azimuths: Floats
    """(n, 8)"""

    @property
    def stacked(self) -> Floats:
        """Both together, (2 n, 8)."""
        return np.concatenate([self.ranges, self.azimuths])


def polar_jacobian(p: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Derivatives of range and azimuth by the six parameters at instants t (n,), each (n, 6)."""
    x, y, dx, dy = position_jacobian(p[:, None], t)
    rho = np.hypot(x, y)
    return ((x * dx + y * dy) / rho).T, ((x * dy - y * dx) / rho**2).T


def printed_systems(p: Floats, t: Floats, base: Floats, sigma_r: float, sigma_th: float) -> Printed:
    """A_R = J_rho G and A_theta = J_theta G, G = dp/dq by least squares over the four base instants.

    Parameters
    ----------
    p : (6,); t : (n,) s, instants of the plots; base : (4,) s, instants of the base plots
    """
    j_rho, j_theta = polar_jacobian(p, t)
    b_rho, b_theta = polar_jacobian(p, base)
    whitened_base = np.concatenate([b_rho / sigma_r, b_theta / sigma_th])
    # Unknowns are in units of their own errors; scaled columns keep the pseudo-inverse well conditioned.
    scale = np.linalg.norm(whitened_base, axis=0)
    g = np.linalg.pinv(whitened_base / scale) / scale[:, None]
    return Printed(j_rho @ g / sigma_r, j_theta @ g / sigma_th)


def fit_by_base_points(window: Window) -> tuple[Fit, Floats]:
    """Undamped Gauss-Newton steps in the polar coordinates of the oldest, a middle and the newest plot.

    Returns
    -------
    fit : at the epoch of the newest plot, one window after another
    condition : (W,) of the normal matrix scaled to a unit diagonal, at the last step
    """
    count = window.rho.shape[1]
    start = three_point_start(window)
    p = np.full((6, count), np.nan)
    information = np.full((6, 6, count), np.nan)
    condition = np.full(count, np.nan)
    converged = np.zeros(count, bool)
    for w in range(count):
        one = window.take(np.array([w]))
        if np.isfinite(start[:, w]).all():
            p[:, w], condition[w], converged[w] = _steps(one, start[:, w])
            _, j = whitened(one, p[:, [w]])
            information[:, :, w] = j[..., 0].T @ j[..., 0]
    return Fit(with_forward_speed(p), information, cost_of(window, np.nan_to_num(p)), converged), condition


def _steps(one: Window, p: Floats) -> tuple[Floats, float, bool]:
    known = np.flatnonzero(one.known[:, 0])
    span = one.t[known[0], 0]
    middle = known[np.argmin(np.abs(one.t[known[1:-1], 0] - 0.5 * span)) + 1]
    base = one.t[[known[0], middle, known[-1]], 0]
    rows = np.concatenate([known, known + one.rho.shape[0]])
    condition = np.nan
    for _ in range(STEPS):
        r, j = whitened(one, p[:, None])
        to_q = np.concatenate(polar_jacobian(p, base))
        a = j[rows, :, 0] @ np.linalg.inv(to_q)
        normal = a.T @ a
        d = np.sqrt(np.diagonal(normal))
        condition = float(np.linalg.cond(normal / d[:, None] / d[None]))
        step = np.linalg.solve(normal / d[:, None] / d[None], a.T @ r[rows, 0] / d) / d
        x, y = position(p[:, None], base)
        rho, theta = np.hypot(x, y) + step[:3], np.arctan2(y, x) + step[3:]
        p = from_three_positions(rho * np.cos(theta), rho * np.sin(theta), base)
        if not np.isfinite(p).all():
            return p, condition, False
        # The epoch of three positions is the newest plot's, which is that of the window.
        p[2] = wrapped(p[2])
        if np.linalg.norm(step * d) < STEP_DONE:
            return p, condition, True
    return p, condition, False
