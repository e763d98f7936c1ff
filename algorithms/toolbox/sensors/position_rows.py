"""Measurements that fix a position, as three uncorrelated scalar rows: bicone, polar and Cartesian coordinates.

A sensor at d with axes A (rows in east, north, up) measures three functions of X = A (x - d):

* `cartesian`  X itself;
* `bicone`     r = |X|, eps = asin(X2 / r), alpha = asin(X3 / r), for X1 > 0;
* `polar`      r = |X|, azimuth clockwise from the second axis, elevation asin(X3 / r);
* `plan`       ground range, azimuth, and X3: a height that is assumed or decoded.

Their errors are independent, so the gradients are rows with the variances s_i^2. With J the derivative of X by the
coordinates, the converted mark's covariance is R = J diag(s^2) J': the same gradients J^-1 with the same variances
decorrelate a *converted* mark too, whose innovations are J^-1 (Y - x). The ways to filter differ only in where the
gradients are taken and in what the innovation is:

* `converted`                gradients at the mark, innovation J^-1 (Y - x) (the paper);
* `converted_at_prediction`  gradients at the prediction, the same innovation;
* `ekf`                      gradients at the prediction, innovation z - h(x);
* `ukf`                      statistical linearisation over six sigma points of the position (kappa = 0).

References
----------
trudymai2023, eq. (10); barshalom2001, section 10.4.3; julier1997.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import LANES, bare, kernel
from algorithms.toolbox.kernels.angle import arctangent2
from algorithms.toolbox.kernels.exponential import logarithm

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SENSORS = ("cartesian", "bicone", "polar", "plan")
CARTESIAN, BICONE, POLAR, PLAN = range(4)
MEASUREMENTS = ("converted", "converted_at_prediction", "ekf", "ukf")
"""Names of the ways to filter; a kernel takes the position in this tuple."""
CONVERTED, AT_PREDICTION, EKF, UKF = range(4)

# Nearer to the edge of its half-space a prediction is no point to linearise at; the mark itself then is.
LEAST_COSINE = 0.02


class PositionMark(NamedTuple):
    """One mark in every lane."""

    kind: int
    axes: Floats
    """(3, 3)"""
    origin: Floats
    """(3,) m"""
    sd: Floats
    """(3, LANES), of the three coordinates"""
    z: Floats
    """(3, LANES), the coordinates as measured"""
    y: Floats
    """(3, LANES) m, the converted mark"""


class PositionRows(NamedTuple):
    """What an update takes."""

    r: Floats
    """(23, LANES): gradients of the three rows, innovations, variances, 1 where the lane has them; see `update_9`"""
    log_volume: Floats
    """(LANES,), ln det R in m less the sum of ln variance: -2 ln |det h|; 0 for the innovations of `ekf` and `ukf`"""
    at: Floats
    """(3, LANES), where the gradients are taken"""
    found: Floats
    """(3, LANES), the coordinates there"""


def new_rows() -> PositionRows:
    """Room for one mark."""
    return PositionRows(
        r=np.ones((23, LANES)),
        log_volume=np.zeros(LANES),
        at=np.zeros((3, LANES)),
        found=np.zeros((3, LANES)),
    )


@bare
def coordinates(kind, axes, origin, x, y, z):
    """Return the three coordinates of one point; NaN where it has none."""
    dx, dy, dz = x - origin[0], y - origin[1], z - origin[2]
    a = axes[0, 0] * dx + axes[0, 1] * dy + axes[0, 2] * dz
    b = axes[1, 0] * dx + axes[1, 1] * dy + axes[1, 2] * dz
    c = axes[2, 0] * dx + axes[2, 1] * dy + axes[2, 2] * dz
    if kind == CARTESIAN:
        return a, b, c
    if kind == PLAN:
        return np.sqrt(a * a + b * b), np.arctan2(a, b), c
    r = np.sqrt(a * a + b * b + c * c)
    if kind == BICONE:
        return r, np.arcsin(b / r), np.arcsin(c / r)
    return r, np.arctan2(a, b), np.arcsin(c / r)


@bare
def coordinates_in_lanes(kind, axes, origin, at, out):
    """Write the coordinates of points at (3, LANES) m into out (3, LANES)."""
    a00, a01, a02 = axes[0, 0], axes[0, 1], axes[0, 2]
    a10, a11, a12 = axes[1, 0], axes[1, 1], axes[1, 2]
    a20, a21, a22 = axes[2, 0], axes[2, 1], axes[2, 2]
    o0, o1, o2 = origin[0], origin[1], origin[2]
    x, y, z = at[0], at[1], at[2]
    first, second, third = out[0], out[1], out[2]
    for lane in range(LANES):
        dx, dy, dz = x[lane] - o0, y[lane] - o1, z[lane] - o2
        first[lane] = a00 * dx + a01 * dy + a02 * dz
        second[lane] = a10 * dx + a11 * dy + a12 * dz
        third[lane] = a20 * dx + a21 * dy + a22 * dz
    if kind == CARTESIAN:
        return
    for lane in range(LANES):
        a, b, c = first[lane], second[lane], third[lane]
        plan2 = a * a + b * b
        if kind == BICONE:
            second[lane] = arctangent2(b, np.sqrt(a * a + c * c))
        else:
            second[lane] = arctangent2(a, b)
        if kind == PLAN:
            first[lane] = np.sqrt(plan2)
        else:
            first[lane] = np.sqrt(plan2 + c * c)
            third[lane] = arctangent2(c, np.sqrt(plan2))


@bare
def gradients(kind, axes, origin, at, h):
    """Write the gradients, nine rows of h, of the coordinates at (3, LANES) m."""
    a00, a01, a02 = axes[0, 0], axes[0, 1], axes[0, 2]
    a10, a11, a12 = axes[1, 0], axes[1, 1], axes[1, 2]
    a20, a21, a22 = axes[2, 0], axes[2, 1], axes[2, 2]
    o0, o1, o2 = origin[0], origin[1], origin[2]
    x, y, z = at[0], at[1], at[2]
    for lane in range(LANES):
        dx, dy, dz = x[lane] - o0, y[lane] - o1, z[lane] - o2
        a = a00 * dx + a01 * dy + a02 * dz
        b = a10 * dx + a11 * dy + a12 * dz
        c = a20 * dx + a21 * dy + a22 * dz
        # In the sensor's axes first: g_ij = d coordinate i / d X_j.
        g00, g01, g02 = 1.0, 0.0, 0.0
        g10, g11, g12 = 0.0, 1.0, 0.0
        g20, g21, g22 = 0.0, 0.0, 1.0
        plan2 = max(a * a + b * b, 1e-12)
        if kind == BICONE:
            side2 = max(a * a + c * c, 1e-12)
            u = 1.0 / np.sqrt(plan2 + c * c)
            g00, g01, g02 = a * u, b * u, c * u
            s = u * u / np.sqrt(side2)
            g10, g11, g12 = -b * a * s, side2 * s, -b * c * s
            s = u * u / np.sqrt(plan2)
            g20, g21, g22 = -c * a * s, -c * b * s, plan2 * s
        elif kind == POLAR:
            u = 1.0 / np.sqrt(plan2 + c * c)
            g00, g01, g02 = a * u, b * u, c * u
            g10, g11, g12 = b / plan2, -a / plan2, 0.0
            s = u * u / np.sqrt(plan2)
            g20, g21, g22 = -c * a * s, -c * b * s, plan2 * s
        elif kind == PLAN:
            u = 1.0 / np.sqrt(plan2)
            g00, g01, g02 = a * u, b * u, 0.0
            g10, g11, g12 = b / plan2, -a / plan2, 0.0
        h[0, lane] = g00 * a00 + g01 * a10 + g02 * a20
        h[1, lane] = g00 * a01 + g01 * a11 + g02 * a21
        h[2, lane] = g00 * a02 + g01 * a12 + g02 * a22
        h[3, lane] = g10 * a00 + g11 * a10 + g12 * a20
        h[4, lane] = g10 * a01 + g11 * a11 + g12 * a21
        h[5, lane] = g10 * a02 + g11 * a12 + g12 * a22
        h[6, lane] = g20 * a00 + g21 * a10 + g22 * a20
        h[7, lane] = g20 * a01 + g21 * a11 + g22 * a21
        h[8, lane] = g20 * a02 + g21 * a12 + g22 * a22


@bare
def position_covariance(h, sd, lane, out):
    """Write G diag(sd^2) G', G the inverse of one lane's gradients: the packed covariance (6,) of a converted mark."""
    a, b, c = h[0, lane], h[1, lane], h[2, lane]
    d, e, f = h[3, lane], h[4, lane], h[5, lane]
    g, i, j = h[6, lane], h[7, lane], h[8, lane]
    det = a * (e * j - f * i) - b * (d * j - f * g) + c * (d * i - e * g)
    m00, m01, m02 = (e * j - f * i) * sd[0], (c * i - b * j) * sd[1], (b * f - c * e) * sd[2]
    m10, m11, m12 = (f * g - d * j) * sd[0], (a * j - c * g) * sd[1], (c * d - a * f) * sd[2]
    m20, m21, m22 = (d * i - e * g) * sd[0], (b * g - a * i) * sd[1], (a * e - b * d) * sd[2]
    scale = 1.0 / (det * det)
    out[0] = (m00 * m00 + m01 * m01 + m02 * m02) * scale
    out[1] = (m10 * m00 + m11 * m01 + m12 * m02) * scale
    out[2] = (m10 * m10 + m11 * m11 + m12 * m12) * scale
    out[3] = (m20 * m00 + m21 * m01 + m22 * m02) * scale
    out[4] = (m20 * m10 + m21 * m11 + m22 * m12) * scale
    out[5] = (m20 * m20 + m21 * m21 + m22 * m22) * scale


@bare
def _wrap(angle):
    """Bring an angle into -pi to pi."""
    return angle - 2.0 * np.pi * np.floor(angle / (2.0 * np.pi) + 0.5)


@bare
def linearised(mark, way, go, x, rows):
    """Write the rows of a mark for the predicted hypothesis x (54, LANES); lanes with go = 0 get none."""
    if way == CONVERTED:
        for a in range(3):
            for lane in range(LANES):
                rows.at[a, lane] = mark.y[a, lane]
    else:
        for lane in range(LANES):
            px, py, pz = x[0, lane], x[3, lane], x[6, lane]
            if mark.kind == BICONE:
                dx, dy, dz = px - mark.origin[0], py - mark.origin[1], pz - mark.origin[2]
                before = mark.axes[0, 0] * dx + mark.axes[0, 1] * dy + mark.axes[0, 2] * dz
                if before < LEAST_COSINE * np.sqrt(dx * dx + dy * dy + dz * dz):
                    px, py, pz = mark.y[0, lane], mark.y[1, lane], mark.y[2, lane]
            rows.at[0, lane] = px
            rows.at[1, lane] = py
            rows.at[2, lane] = pz
    gradients(mark.kind, mark.axes, mark.origin, rows.at, rows.r)
    for lane in range(LANES):
        rows.log_volume[lane] = 0.0
    for i in range(3):
        h0, h1, h2 = rows.r[3 * i], rows.r[3 * i + 1], rows.r[3 * i + 2]
        nu, variance, active, sd = rows.r[9 + i], rows.r[12 + i], rows.r[15 + i], mark.sd[i]
        for lane in range(LANES):
            here = go[lane] > 0.0
            active[lane] = go[lane]
            variance[lane] = sd[lane] * sd[lane] if here else 1.0
            dx, dy, dz = mark.y[0, lane] - x[0, lane], mark.y[1, lane] - x[3, lane], mark.y[2, lane] - x[6, lane]
            nu[lane] = h0[lane] * dx + h1[lane] * dy + h2[lane] * dz if here else 0.0
    if way in (CONVERTED, AT_PREDICTION) or mark.kind == CARTESIAN:
        for lane in range(LANES):
            det = (
                rows.r[0, lane] * (rows.r[4, lane] * rows.r[8, lane] - rows.r[5, lane] * rows.r[7, lane])
                - rows.r[1, lane] * (rows.r[3, lane] * rows.r[8, lane] - rows.r[5, lane] * rows.r[6, lane])
                + rows.r[2, lane] * (rows.r[3, lane] * rows.r[7, lane] - rows.r[4, lane] * rows.r[6, lane])
            )
            rows.log_volume[lane] = -logarithm(max(det * det, 1e-300) if go[lane] > 0.0 else 1.0)
        return
    if way == UKF:
        for lane in range(LANES):
            if go[lane] > 0.0:
                _statistical(mark, lane, x, rows)
        return
    coordinates_in_lanes(mark.kind, mark.axes, mark.origin, rows.at, rows.found)
    for i in range(3):
        h0, h1, h2, nu, z, found = (
            rows.r[3 * i],
            rows.r[3 * i + 1],
            rows.r[3 * i + 2],
            rows.r[9 + i],
            mark.z[i],
            rows.found[i],
        )
        angle = i > 0 and (i == 1 or mark.kind != PLAN)
        for lane in range(LANES):
            # Where the prediction was no point to linearise at, the innovation is counted from the mark.
            dx, dy, dz = rows.at[0, lane] - x[0, lane], rows.at[1, lane] - x[3, lane], rows.at[2, lane] - x[6, lane]
            value = (z[lane] - found[lane]) + h0[lane] * dx + h1[lane] * dy + h2[lane] * dz
            turns = np.floor(value / (2.0 * np.pi) + 0.5) if angle else 0.0
            nu[lane] = value - 2.0 * np.pi * turns if go[lane] > 0.0 else 0.0


@kernel
def _statistical(mark, lane, x, rows):
    """Rows of one lane by statistical linearisation: h = P_zx P_xx^-1, noise P_zz - h P_xx h' + R, decorrelated."""
    low = np.zeros((3, 3))
    for a in range(3):
        for b in range(a + 1):
            i = 9 + 3 * a * (3 * a + 1) // 2 + 3 * b
            total = x[i, lane]
            for k in range(b):
                total -= low[a, k] * low[b, k]
            if a == b:
                low[a, a] = np.sqrt(max(total, 1e-12))
            else:
                low[a, b] = total / low[b, b]
    root3 = np.sqrt(3.0)
    z = np.empty((6, 3))
    for k in range(6):
        sign = 1.0 if k < 3 else -1.0
        c = k % 3
        found = coordinates(
            mark.kind,
            mark.axes,
            mark.origin,
            x[0, lane] + sign * root3 * low[0, c],
            x[3, lane] + sign * root3 * low[1, c],
            x[6, lane] + sign * root3 * low[2, c],
        )
        for i in range(3):
            # Angles are counted from the measured one, so that no mean crosses the seam.
            away = found[i] - mark.z[i, lane]
            z[k, i] = _wrap(away) if i > 0 and (i == 1 or mark.kind != PLAN) else away
    mean = np.zeros(3)
    for i in range(3):
        for k in range(6):
            mean[i] += z[k, i] / 6.0
    # P_zx L^-T: column c is (z+ - z-) sqrt(3) / 6.
    slope = np.empty((3, 3))
    noise = np.zeros((3, 3))
    for i in range(3):
        for c in range(3):
            slope[i, c] = (z[c, i] - z[c + 3, i]) * root3 / 6.0
    for i in range(3):
        for j in range(i + 1):
            total = 0.0
            for k in range(6):
                total += (z[k, i] - mean[i]) * (z[k, j] - mean[j]) / 6.0
            for c in range(3):
                total -= slope[i, c] * slope[j, c]
            if i == j:
                total = max(total, 0.0) + mark.sd[i, lane] * mark.sd[i, lane]
            noise[i, j] = total
            noise[j, i] = total
    # h = slope L^-1.
    h = np.empty((3, 3))
    for i in range(3):
        h[i, 2] = slope[i, 2] / low[2, 2]
        h[i, 1] = (slope[i, 1] - h[i, 2] * low[2, 1]) / low[1, 1]
        h[i, 0] = (slope[i, 0] - h[i, 1] * low[1, 0] - h[i, 2] * low[2, 0]) / low[0, 0]
    # Decorrelate with the factor of the noise: noise = G D G', rows G^-1 h, G^-1 nu, variances D.
    for i in range(3):
        nu = -mean[i]
        for a in range(3):
            rows.r[3 * i + a, lane] = h[i, a]
        d = noise[i, i]
        for k in range(i):
            g = noise[i, k] / noise[k, k]
            nu -= g * rows.r[9 + k, lane]
            for a in range(3):
                rows.r[3 * i + a, lane] -= g * rows.r[3 * k + a, lane]
            d -= g * noise[i, k]
            for m in range(i + 1, 3):
                noise[m, i] -= g * noise[m, k]
        noise[i, i] = max(d, 1e-300)
        rows.r[9 + i, lane] = nu
        rows.r[12 + i, lane] = noise[i, i]
