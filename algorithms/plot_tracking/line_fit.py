"""The weighted straight line through a track's plots.

References
----------
Specification 4.1, step 1.
"""

from __future__ import annotations

import numpy as np

from algorithms.plot_tracking.window import Fit, Window, cost_of, moments, solved
from algorithms.toolbox.motion.curvature import Floats


def fit_line(window: Window) -> Fit:
    """Weighted straight line through the plots, turned into east and north with their covariances.

    The information of course and speed is that of the velocity turned into them, so a speed near zero leaves the course
    open. A window needs two plots.
    """
    x, y = window.cartesian
    along = window.known / window.sigma_r**2
    across = window.known / (window.rho * window.sigma_th) ** 2
    cosine, sine = np.cos(window.theta), np.sin(window.theta)
    xx = along * cosine**2 + across * sine**2
    yy = along * sine**2 + across * cosine**2
    xy = (along - across) * cosine * sine
    count = window.rho.shape[1]
    gx, gy = xx * x + xy * y, xy * x + yy * y
    n, g = np.empty((4, 4, count)), np.empty((4, count))
    # Unknowns: x0, vx, y0, vy.
    for i, j, weight in ((0, 0, xx), (2, 2, yy), (0, 2, xy)):
        n[i, j], once, n[i + 1, j + 1] = moments(weight, window.t, 2)
        n[i, j + 1] = n[i + 1, j] = once
    n[2:, :2] = n[:2, 2:]
    for i, weight in ((0, gx), (2, gy)):
        g[i], g[i + 1] = moments(weight, window.t, 1)
    x0, vx, y0, vy = solved(n, g)
    speed = np.hypot(vx, vy)
    course = np.arctan2(vy, vx)
    p = np.stack([x0, y0, course, speed, np.zeros(count), np.zeros(count)])
    # Derivatives of (x0, vx, y0, vy) by (x0, y0, course, speed).
    d = np.zeros((4, 6, count))
    d[0, 0] = d[2, 1] = 1.0
    d[1, 2], d[1, 3] = -speed * np.sin(course), np.cos(course)
    d[3, 2], d[3, 3] = speed * np.cos(course), np.sin(course)
    information = _sandwich(n, d)
    return Fit(p, information, cost_of(window, p), np.isfinite(p).all(axis=0))


def _sandwich(n: Floats, d: Floats) -> Floats:
    """Product d' n d of stacks (m, m, W) and (m, k, W), summed in order."""
    m, k = d.shape[0], d.shape[1]
    out = np.zeros((k, k, d.shape[2]))
    for i in range(m):
        for j in range(m):
            out += n[i, j] * d[i][:, None] * d[j][None]
    return 0.5 * (out + out.swapaxes(0, 1))
