"""Closed forms for one mark: candidate positions from which the least-squares solution starts.

With the last reception as reference, D_i = s_i - s_ref, d_i = c (TOA_i - TOA_ref), rho the range to the reference
and X = p - s_ref, each other reception gives an equation that is *linear* in (X, rho):

    D_i . X + d_i rho = (|D_i|^2 - d_i^2) / 2.

The stations of a ground site lie nearly in a plane. In axes along the plane's principal directions the third
component of D_i is small, and three candidates follow:

1. *plane*: least squares for (X1, X2, rho) from three or more equations, X3 = sqrt(rho^2 - X1^2 - X2^2), clamped at
   zero (negative in a quarter of the marks of a low target at 100 km: that is noise, not an error).
2. *altitude*: (X1, X2) = k0 + k1 rho from two or more equations; the sphere |p - O| = R + h is linear in X3 given
   rho; inserting it into |X|^2 = rho^2 leaves a quartic in rho with up to two admissible roots.
3. *space*: for stations that do not lie in a plane (X1, X2, X3) = k0 + k1 rho and a quadratic in rho.

Differences from the paper: it has no closed form. The three-reception quartic is exact for any three stations
(three points always lie in a plane), not only for horizontal ones.

References
----------
smith1987; specification 5, steps 1 and 2.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import kernel

# Ranges are scaled by this before the quartic is solved: its coefficients then have comparable size.
RANGE_SCALE_M = 1e5

# Where the clamped height would be zero the derivative in height vanishes and an iteration could not leave the
# plane; start this share of the range above it.
LOWEST_START_SHARE = 0.02

# Third principal extent of the stations, relative to the first, from which the *space* form is used.
SPATIAL_SHARE = 0.005

MAX_CANDIDATES = 8


@kernel
def closed_form_candidates(toa_m, used, stations, altitude, centre, radius, out):
    """Write candidate positions of one mark; return their number.

    Parameters
    ----------
    toa_m, used : (S,) float, m and 0/1
    stations : (S, 3) float, m
    altitude : float, m, or NaN
    centre, radius : (3,) and float, m
        Sphere on which the emitter would lie at altitude 0.
    out : (MAX_CANDIDATES, 3) float, m
    """
    count = 0
    ref = -1
    for s in range(stations.shape[0]):
        if used[s] > 0.0:
            count += 1
            ref = s
    m = count - 1
    if m < 2:
        return 0
    big_d = np.empty((m, 3))
    d = np.empty(m)
    filled = 0
    for s in range(stations.shape[0]):
        if used[s] > 0.0 and s != ref:
            for a in range(3):
                big_d[filled, a] = stations[s, a] - stations[ref, a]
            d[filled] = toa_m[s] - toa_m[ref]
            filled += 1
    scatter = np.zeros((3, 3))
    for k in range(m):
        for i in range(3):
            for j in range(3):
                scatter[i, j] += big_d[k, i] * big_d[k, j]
    extent, axes = np.linalg.eigh(scatter)  # ascending: axes[:, 0] is the plane's normal
    if not extent[1] > 1e-12 * extent[2]:
        return 0  # the stations stand on one line
    up = 1.0 if axes[2, 0] >= 0.0 else -1.0
    frame = np.empty((3, 3))  # rows: first, second, normal direction
    for a in range(3):
        frame[0, a] = axes[a, 2]
        frame[1, a] = axes[a, 1]
        frame[2, a] = up * axes[a, 0]
    e = np.zeros((m, 3))
    b = np.empty(m)
    for k in range(m):
        square = 0.0
        for a in range(3):
            square += big_d[k, a] * big_d[k, a]
            for i in range(3):
                e[k, i] += frame[i, a] * big_d[k, a]
        b[k] = 0.5 * (square - d[k] * d[k])
    n = 0
    if altitude == altitude:
        n = _on_sphere(e, d, b, frame, stations[ref], centre, radius + altitude, out, n)
    if m >= 3:
        n = _in_plane(e, d, b, frame, stations[ref], out, n)
        if extent[0] > SPATIAL_SHARE * SPATIAL_SHARE * extent[2]:
            n = _in_space(e, d, b, frame, stations[ref], out, n)
    return n


@kernel
def _place(x, frame, ref, out, n):
    """Append the position with plane coordinates x (3,)."""
    if n >= out.shape[0]:
        return n
    for a in range(3):
        out[n, a] = ref[a] + frame[0, a] * x[0] + frame[1, a] * x[1] + frame[2, a] * x[2]
        if not np.isfinite(out[n, a]):
            return n
    return n + 1


@kernel
def _lines(e, d, b, width):
    """Least squares for the first `width` components of X as k0 + k1 rho; a third array tells success."""
    normal = np.zeros((width, width))
    right = np.zeros((width, 2))
    for k in range(e.shape[0]):
        for i in range(width):
            for j in range(width):
                normal[i, j] += e[k, i] * e[k, j]
            right[i, 0] += e[k, i] * b[k]
            right[i, 1] -= e[k, i] * d[k]
    return np.linalg.solve(normal, right)


@kernel
def _in_plane(e, d, b, frame, ref, out, n):
    normal = np.zeros((3, 3))
    right = np.zeros(3)
    row = np.empty(3)
    # Scale the range column like the others, so that the determinant test means something.
    for k in range(e.shape[0]):
        row[0] = e[k, 0]
        row[1] = e[k, 1]
        row[2] = d[k]
        for i in range(3):
            for j in range(3):
                normal[i, j] += row[i] * row[j]
            right[i] += row[i] * b[k]
    size = normal[0, 0] * normal[1, 1] * normal[2, 2]
    if not np.linalg.det(normal) > 1e-16 * size:
        return n
    x = np.linalg.solve(normal, right)
    rho = abs(x[2])
    height2 = rho * rho - x[0] * x[0] - x[1] * x[1]
    x[2] = max(np.sqrt(max(height2, 0.0)), LOWEST_START_SHARE * rho)
    return _place(x, frame, ref, out, n)


@kernel
def _in_space(e, d, b, frame, ref, out, n):
    k = _lines(e, d, b, 3)
    qa = -1.0
    qb = 0.0
    qc = 0.0
    for i in range(3):
        qa += k[i, 1] * k[i, 1]
        qb += 2.0 * k[i, 0] * k[i, 1]
        qc += k[i, 0] * k[i, 0]
    disc = max(qb * qb - 4.0 * qa * qc, 0.0)
    if qa == 0.0:
        return n
    x = np.empty(3)
    for sign in (-1.0, 1.0):
        rho = (-qb + sign * np.sqrt(disc)) / (2.0 * qa)
        if rho > 0.0:
            for i in range(3):
                x[i] = k[i, 0] + k[i, 1] * rho
            n = _place(x, frame, ref, out, n)
    return n


@kernel
def _on_sphere(e, d, b, frame, ref, centre, radius, out, n):
    k = _lines(e, d, b, 2)
    o = np.zeros(3)
    o2 = 0.0
    for a in range(3):
        diff = centre[a] - ref[a]
        o2 += diff * diff
        for i in range(3):
            o[i] += frame[i, a] * diff
    if o[2] == 0.0:
        return n
    # X3(rho) = z0 + z1 rho + z2 rho^2 from |X|^2 = rho^2 and |X - O|^2 = radius^2; all in units of RANGE_SCALE_M.
    u = RANGE_SCALE_M
    z2 = u / (2.0 * o[2])
    z1 = -(k[0, 1] * o[0] + k[1, 1] * o[1]) / o[2]
    z0 = ((o2 - radius * radius) / (2.0 * o[2]) - (k[0, 0] * o[0] + k[1, 0] * o[1]) / o[2]) / u
    a0 = k[0, 0] / u
    a1 = k[1, 0] / u
    poly = np.empty(5, np.complex128)
    poly[0] = z2 * z2
    poly[1] = 2.0 * z1 * z2
    poly[2] = z1 * z1 + 2.0 * z0 * z2 + k[0, 1] * k[0, 1] + k[1, 1] * k[1, 1] - 1.0
    poly[3] = 2.0 * (z0 * z1 + a0 * k[0, 1] + a1 * k[1, 1])
    poly[4] = z0 * z0 + a0 * a0 + a1 * a1
    roots = np.roots(poly)
    x = np.empty(3)
    found = n
    nearest = -1.0
    nearest_rho = 0.0
    for i in range(roots.shape[0]):
        rho = roots[i].real
        off = abs(roots[i].imag)
        if not rho > 0.0:
            continue
        fits = True
        for j in range(d.shape[0]):
            fits = fits and rho * u + d[j] > 0.0
        z = z0 + z1 * rho + z2 * rho * rho
        if not fits or z < -1.0:
            continue
        if off < 1e-7 * (1.0 + rho):
            for c in range(2):
                x[c] = k[c, 0] + k[c, 1] * rho * u
            x[2] = z * u
            n = _place(x, frame, ref, out, n)
        elif nearest < 0.0 or off < nearest:
            nearest = off
            nearest_rho = rho
    if n == found and nearest >= 0.0:
        # Noise has lifted the curve off the axis: the pair of roots is complex, its real part is the best point.
        for c in range(2):
            x[c] = k[c, 0] + k[c, 1] * nearest_rho * u
        x[2] = (z0 + z1 * nearest_rho + z2 * nearest_rho * nearest_rho) * u
        n = _place(x, frame, ref, out, n)
    return n
