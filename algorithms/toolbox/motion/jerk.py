"""Constant acceleration disturbed by jerk, the same on three axes: state [x vx ax  y vy ay  z vz az].

Per axis, over an interval T,

    F1 = [[1, T, T^2/2], [0, 1, T], [0, 0, 1]],     P' = F P F^T + Q,

with the process noise Q1 in one of three forms (sigma = standard deviation of the jerk sample, m/s^3):

* `paper`: sigma^2 g g^T, g = [0, 0, T]: only the acceleration is disturbed (chugunov2023, eq. (6));
* `pwc`:   sigma^2 g g^T, g = [T^3/6, T^2/2, T]: jerk constant between marks;
* `white`: q [[T^5/20, T^4/8, T^3/6], [., T^3/3, T^2/2], [., ., T]], q = sigma^2 * 1 s: white jerk. It depends only
  on the elapsed time, not on how many marks fell in it, and is the one to use for irregular marks.

Differences from the paper: it knows the first form only; for marks 1 s apart the three give the same accuracy to
four digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import LANES, inlined, kernel

Floats = NDArray[np.float64]

PROCESS_NOISE = ("paper", "pwc", "white")
"""Names of the forms; a kernel takes the position in this tuple."""

T_REF_S = 1.0


@inlined
def noise_block(t, sigma, form):
    """Return the six lower elements of Q1 over t seconds."""
    s = sigma * sigma
    t2 = t * t
    t3 = t2 * t
    # The forms are chosen without a branch: inside a loop over lanes each of them costs less than one.
    white = 1.0 if form == 2 else 0.0
    w = white * T_REF_S * s
    k = (1.0 - white) * s
    g0 = t3 * (1.0 / 6.0) if form == 1 else 0.0
    g1 = 0.5 * t2 if form == 1 else 0.0
    return (
        w * t3 * t2 * (1.0 / 20.0) + k * g0 * g0,
        w * t2 * t2 * (1.0 / 8.0) + k * g1 * g0,
        w * t3 * (1.0 / 3.0) + k * g1 * g1,
        w * t3 * (1.0 / 6.0) + k * t * g0,
        w * t2 * 0.5 + k * t * g1,
        w * t + k * t2,
    )


@kernel
def predict_jerk(x, p, t, sigma, form):
    """Predict a block over t seconds, in place; a lane with t = 0 stays as it is.

    F is three equal 3 x 3 blocks, so F P F^T is done block by block with T and T^2/2; no 9 x 9 product exists.

    Parameters
    ----------
    x : (9, LANES), p : (45, LANES), t : (LANES,) s
    sigma : float, m/s^3
    form : int, position in PROCESS_NOISE
    """
    # Flat views: with the row length known, the compiler sees that rows do not overlap, and vectorises.
    f = p.reshape(p.size)
    y = x.reshape(x.size)
    for a in range(3):
        i = 3 * a
        for lane in range(LANES):
            tau = t[lane]
            y[(i) * LANES + lane] += tau * (y[(i + 1) * LANES + lane] + 0.5 * tau * y[(i + 2) * LANES + lane])
            y[(i + 1) * LANES + lane] += tau * y[(i + 2) * LANES + lane]
    for a in range(3):
        r0 = 3 * a * (3 * a + 1) // 2
        r1 = (3 * a + 1) * (3 * a + 2) // 2
        r2 = (3 * a + 2) * (3 * a + 3) // 2
        for b in range(a):
            c = 3 * b
            for lane in range(LANES):
                tau = t[lane]
                hh = 0.5 * tau * tau
                m20 = f[(r2 + c) * LANES + lane]
                m21 = f[(r2 + c + 1) * LANES + lane]
                m22 = f[(r2 + c + 2) * LANES + lane]
                m10 = f[(r1 + c) * LANES + lane]
                m11 = f[(r1 + c + 1) * LANES + lane]
                m12 = f[(r1 + c + 2) * LANES + lane]
                a00 = f[(r0 + c) * LANES + lane] + tau * m10 + hh * m20
                a01 = f[(r0 + c + 1) * LANES + lane] + tau * m11 + hh * m21
                a02 = f[(r0 + c + 2) * LANES + lane] + tau * m12 + hh * m22
                a10 = m10 + tau * m20
                a11 = m11 + tau * m21
                a12 = m12 + tau * m22
                f[(r0 + c) * LANES + lane] = a00 + tau * a01 + hh * a02
                f[(r0 + c + 1) * LANES + lane] = a01 + tau * a02
                f[(r0 + c + 2) * LANES + lane] = a02
                f[(r1 + c) * LANES + lane] = a10 + tau * a11 + hh * a12
                f[(r1 + c + 1) * LANES + lane] = a11 + tau * a12
                f[(r1 + c + 2) * LANES + lane] = a12
                f[(r2 + c) * LANES + lane] = m20 + tau * m21 + hh * m22
                f[(r2 + c + 1) * LANES + lane] = m21 + tau * m22
        c = 3 * a
        for lane in range(LANES):
            tau = t[lane]
            hh = 0.5 * tau * tau
            m00 = f[(r0 + c) * LANES + lane]
            m10 = f[(r1 + c) * LANES + lane]
            m11 = f[(r1 + c + 1) * LANES + lane]
            m20 = f[(r2 + c) * LANES + lane]
            m21 = f[(r2 + c + 1) * LANES + lane]
            m22 = f[(r2 + c + 2) * LANES + lane]
            a00 = m00 + tau * m10 + hh * m20
            a01 = m10 + tau * m11 + hh * m21
            a02 = m20 + tau * m21 + hh * m22
            a11 = m11 + tau * m21
            a12 = m21 + tau * m22
            q0, q1, q2, q3, q4, q5 = noise_block(tau, sigma, form)
            f[(r0 + c) * LANES + lane] = a00 + tau * a01 + hh * a02 + q0
            f[(r1 + c) * LANES + lane] = a01 + tau * a02 + q1
            f[(r1 + c + 1) * LANES + lane] = a11 + tau * a12 + q2
            f[(r2 + c) * LANES + lane] = a02 + q3
            f[(r2 + c + 1) * LANES + lane] = a12 + q4
            f[(r2 + c + 2) * LANES + lane] = m22 + q5


def jerk_matrices(t: Floats, sigma: float, form: int) -> tuple[Floats, Floats]:
    """Return F and Q (L, 9, 9) of three equal axes over intervals t (L,) s, for a form of PROCESS_NOISE."""
    f1, q1 = np.zeros((t.size, 3, 3)), np.zeros((t.size, 3, 3))
    f1[:, range(3), range(3)] = 1.0
    f1[:, 0, 1] = f1[:, 1, 2] = t
    f1[:, 0, 2] = 0.5 * t * t
    lower = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
    for (i, j), value in zip(lower, noise_block.py_func(t, sigma, form), strict=True):
        q1[:, i, j] = q1[:, j, i] = value
    f, q = np.zeros((t.size, 9, 9)), np.zeros((t.size, 9, 9))
    for a in range(0, 9, 3):
        f[:, a : a + 3, a : a + 3], q[:, a : a + 3, a : a + 3] = f1, q1
    return f, q
