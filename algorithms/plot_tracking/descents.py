"""Full steps of the normal equations, undamped, in one or another set of parameters: what the paper compares.

The lowest minimum does not depend on the parameters; whether full steps find it does. Centre and radius of the circle
go to infinity in straight flight and fail there; course, speed, acceleration and curvature need a good start; the polar
coordinates of three plots are the best conditioned. Many windows side by side; a step that cannot be solved is none.

References
----------
plots2006, section 3; specification 4.2.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from algorithms.plot_tracking.curve_fit import three_point_plots, three_point_start
from algorithms.plot_tracking.window import Bools, Fit, Window, cost_of, solved, whitened
from algorithms.toolbox.motion.curvature import (
    Floats,
    from_three_positions,
    position_jacobian,
    with_forward_speed,
)

STEPS = 40
STEP_DONE = 1e-7

# Six parameters p (6, W) of other coordinates q, and their derivatives dp/dq (6, 6, W).
Turned = Callable[[Floats], tuple[Floats, Floats]]


def by_course_and_speed(window: Window, start: Floats) -> Fit:
    """Steps in the six parameters themselves, from `start` (6, W)."""
    return _descended(window, start, lambda q: (q, np.broadcast_to(np.eye(6)[:, :, None], (6, *q.shape))))


def by_centre_and_radius(window: Window, start: Floats) -> Fit:
    """Steps in the circle's centre and radius, course, speed and acceleration."""
    with np.errstate(all="ignore"):
        radius = 1.0 / start[5]
        x, y = start[0] - radius * np.sin(start[2]), start[1] + radius * np.cos(start[2])
        return _descended(window, np.stack([x, y, radius, *start[2:5]]), _of_centre)


def by_base_points(window: Window) -> Fit:
    """Steps in the polar coordinates of the oldest, a middle and the newest plot, from the curve through them."""
    rho, theta, t = three_point_plots(window)

    def turned(q: Floats) -> tuple[Floats, Floats]:
        p = from_three_positions(q[:3] * np.cos(q[3:]), q[:3] * np.sin(q[3:]), t)
        x, y, dx, dy = position_jacobian(p[:, None], t)
        square = x * x + y * y
        to_q = np.concatenate([(x * dx + y * dy) / np.sqrt(square), (x * dy - y * dx) / square], axis=1)
        return p, _inverses(to_q.swapaxes(0, 1))

    return _descended(window, np.concatenate([rho, theta]), turned)


def lowest(window: Window, fits: tuple[Fit, ...], quadratic: Floats) -> Floats:
    """The lowest cost (W,) of some fits and of every way of this module."""
    three = three_point_start(window)
    others = (
        by_course_and_speed(window, quadratic),
        by_course_and_speed(window, three),
        by_base_points(window),
    )
    out: Floats = np.min([np.where(np.isfinite(f.cost), f.cost, np.inf) for f in (*fits, *others)], axis=0)
    return out


def _of_centre(q: Floats) -> tuple[Floats, Floats]:
    x, y, radius, g, b, a = q
    s, c = np.sin(g), np.cos(g)
    d = np.zeros((6, *q.shape))
    d[0, 0] = d[1, 1] = d[2, 3] = d[3, 4] = d[4, 5] = 1.0
    d[0, 2], d[0, 3], d[1, 2], d[1, 3], d[5, 2] = s, radius * c, -c, radius * s, -1.0 / radius**2
    return np.stack([x + radius * s, y - radius * c, g, b, a, 1.0 / radius]), d


def _descended(window: Window, start: Floats, turned: Turned) -> Fit:
    """`converged` where the last step was short."""
    q = np.where(np.isfinite(start).all(axis=0), start, 1.0)
    short = np.zeros(q.shape[1], bool)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            p, g = turned(q)
            r, j = whitened(window, p)
            j = _product(j.swapaxes(0, 1), g)
            normal = _product(j, j)
            step = solved(np.where(np.isfinite(normal).all(axis=(0, 1)), normal, np.nan), _sum(j * r[:, None]))
            scaled = step * np.sqrt(np.maximum(np.einsum("iiw->iw", normal), 0.0))
            short = np.sqrt(_sum(scaled**2)) < STEP_DONE
            q = q + np.where(np.isfinite(step).all(axis=0), step, 0.0)
        p, _ = turned(q)
        _, j = whitened(window, p)
        cost = cost_of(window, p)
        sound = np.isfinite(p).all(axis=0) & np.isfinite(cost)
        p = np.where(sound, with_forward_speed(p), np.nan)
    return Fit(p, _product(j, j), np.where(sound, cost, np.inf), short & sound)


def _product(a: Floats, b: Floats) -> Floats:
    """Sum over k of a (k, i, W) times b (k, j, W), one after the other: (i, j, W) that does not know its neighbours."""
    total: Floats = a[0][:, None] * b[0][None]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x[:, None] * y[None]
    return total


def _sum(rows: Floats) -> Floats:
    total: Floats = rows[0]
    for row in rows[1:]:
        total = total + row
    return total


def _inverses(matrices: Floats) -> Floats:
    """Inverses of (6, 6, W), NaN where there is none."""
    stack = np.moveaxis(matrices, -1, 0)
    sound: Bools = np.asarray(np.isfinite(stack).all(axis=(1, 2)))
    scale = np.sqrt((np.where(sound[:, None, None], stack, 1.0) ** 2).sum(axis=1))
    scaled = np.where(sound[:, None, None], stack / scale[:, None], np.eye(6))
    sound &= np.asarray(np.linalg.det(scaled) != 0)
    inverse = np.linalg.inv(np.where(sound[:, None, None], scaled, np.eye(6))) / scale[:, :, None]
    return np.moveaxis(np.where(sound[:, None, None], inverse, np.nan), 0, -1)
