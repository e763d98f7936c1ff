"""Motion models of one target whose three axes move alike: state [x vx ax  y vy ay  z vz az] in east, north, up.

Per axis, over dt seconds, every model is

    F1 = [[1, a, b], [0, c, d], [0, e, g]],     P' = F P F^T + Q,     x' = F x + known part:

* `cv` constant velocity: a = dt, c = 1, the rest 0. The acceleration is pinned to 0 with variance 0: the covariance is
  singular, of rank 6, and nothing here ever factors it.
* `ca` constant acceleration: a = dt, b = dt^2/2, c = 1, d = dt, g = 1.
* `ct` coordinated turn: omega^2 = |v x a|^2 / (|v|^2 + 1e-6)^2, th = omega^2 dt^2 limited to 1, as series.
* `gv` constant velocity but for gravity; acceleration pinned to (0, 0, -g).
* `gd` constant velocity but for gravity and drag, -g up - rho(h) |v| v / (2 beta), taken at the start of the interval.

Process noise has two forms. `step` (the paper's): Q = sigma^2 g g^T with g = [dt^2/2, dt, 0] for the velocity models
and [dt^2/2, dt, 1] for the others: one random number per axis and *step*, so its meaning depends on dt. `rate`: white
noise in the acceleration or in the jerk, which depends on the elapsed time only; it has the same entry of the highest
derivative at the base interval dt0: q^2 = sigma^2 dt0 (velocity models), sigma^2 / dt0 (others). Q has rank 1, 2 or 3:
it is never inverted.

References
----------
trudymai2023, eq. (11); barshalom2001, sections 6.2, 6.3.

Differences from the paper
--------------------------
It calls sigma an acceleration; for `ca` it is an acceleration increment per mark. `ct`, `gv`, `gd` and `rate` are not
in the paper.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.exponential import exponential

KINDS = ("cv", "ca", "ct", "gv", "gd")
"""Names of the models; a kernel takes the position in this tuple."""
CV, CA, CT, GV, GD = range(5)

GRAVITY_MPS2 = 9.80665
SEA_LEVEL_DENSITY = 1.225
SCALE_HEIGHT_M = 7_200.0
LOWEST_M = -10_000.0
"""Air gets no denser below: an estimate that went astray would meet an infinite density."""
BALLISTIC_COEFFICIENT = 10_000.0
"""kg/m2, of the model with drag"""


@bare
def knows_acceleration(kind):
    """Whether a model's acceleration is known, so that position and velocity alone are random."""
    return kind not in (CA, CT)


@bare
def known_acceleration(kind, x, out):
    """Write the acceleration that a model knows into rows 13 to 15 of `out` (16, LANES); 0 where there is none."""
    for a in range(13, 16):
        for lane in range(LANES):
            out[a, lane] = 0.0
    if kind in (GV, GD):
        for lane in range(LANES):
            out[15, lane] = -GRAVITY_MPS2
    if kind == GD:
        for lane in range(LANES):
            vx, vy, vz = x[1, lane], x[4, lane], x[7, lane]
            density = SEA_LEVEL_DENSITY * exponential(-max(x[6, lane], LOWEST_M) / SCALE_HEIGHT_M)
            drag = density * np.sqrt(vx * vx + vy * vy + vz * vz) / (2.0 * BALLISTIC_COEFFICIENT)
            out[13, lane] -= drag * vx
            out[14, lane] -= drag * vy
            out[15, lane] -= drag * vz


@bare
def transition_coefficients(kind, t, x, f):
    """Write the interval and a, b, c, d, e, g into rows 0 to 6 of f (16, LANES), for t (LANES,) s and states x."""
    for lane in range(LANES):
        f[0, lane] = t[lane]
    if kind == CT:
        for lane in range(LANES):
            tau = t[lane]
            vx, vy, vz = x[1, lane], x[4, lane], x[7, lane]
            ax, ay, az = x[2, lane], x[5, lane], x[8, lane]
            cx, cy, cz = vy * az - vz * ay, vz * ax - vx * az, vx * ay - vy * ax
            speed = vx * vx + vy * vy + vz * vz + 1e-6
            rate = (cx * cx + cy * cy + cz * cz) / (speed * speed)
            if rate * tau * tau > 1.0:
                rate = 1.0 / (tau * tau)
            th = rate * tau * tau
            long = tau * (1.0 - th / 6.0 + th * th / 120.0)
            cosine = 1.0 - th / 2.0 + th * th / 24.0
            f[1, lane] = long
            f[2, lane] = tau * tau * (0.5 - th / 24.0 + th * th / 720.0)
            f[3, lane] = cosine
            f[4, lane] = long
            f[5, lane] = -rate * long
            f[6, lane] = cosine
        return
    with_acceleration = 1.0 if kind == CA else 0.0
    for lane in range(LANES):
        tau = t[lane]
        f[1, lane] = tau
        f[2, lane] = with_acceleration * 0.5 * tau * tau
        f[3, lane] = 1.0
        f[4, lane] = with_acceleration * tau
        f[5, lane] = 0.0
        f[6, lane] = with_acceleration


@bare
def noise_coefficients(kind, sigma, t, as_rate, base, q):
    """Write the lower triangle of Q1 into rows 7 to 12 of q (16, LANES), in each lane's form; none over no time.

    Parameters
    ----------
    sigma : (LANES,) m/s^2, of the step form at the interval `base`
    t : (LANES,) s; as_rate : (LANES,) 1 = rate form, 0 = step form
    """
    carries = 1.0 if kind in (CA, CT) else 0.0
    for lane in range(LANES):
        tau = t[lane]
        s = sigma[lane] * sigma[lane]
        h = 0.5 * tau * tau
        r = as_rate[lane]
        jerk = r * carries * s / base
        push = r * (1.0 - carries) * s * base
        step = (1.0 - r) * s if tau > 0.0 else 0.0
        t3 = tau * tau * tau
        q[7, lane] = step * h * h + jerk * t3 * tau * tau / 20.0 + push * t3 / 3.0
        q[8, lane] = step * h * tau + jerk * t3 * tau / 8.0 + push * h
        q[9, lane] = step * tau * tau + jerk * t3 / 3.0 + push * tau
        q[10, lane] = carries * step * h + jerk * t3 / 6.0
        q[11, lane] = carries * step * tau + jerk * h
        q[12, lane] = carries * step + jerk * tau
