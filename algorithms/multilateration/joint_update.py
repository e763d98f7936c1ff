"""Other updates than the extended filter's, for comparisons: iterated, unscented, cubature, and raw times of arrival.

A lane's mark enters as one vector: range differences against the last reception and the altitude, with the covariance
V = diag(sigma_j^2) + sigma_ref^2 (1 1^T). Where the emission time is a state of its own (`raw`), the receptions enter
as they are and the emission's prior, common to all, adds its variance to every element of V.

    iekf   Gauss-Newton: linearised again at its own solution (bell1993)
    ukf    19 points, alpha = 0.5, beta = 2, kappa = 0 (julier1997)
    ckf    18 points at sqrt(9) along each axis of a root of P (arasaratnam2009)

Two more show what the article's printed formulas do: `PRINTED_SIGN` subtracts the correction as (19) does,
`PRINTED_GRADIENT` has z for R + z in the numerator of (26).

In the robust profile the noise of a surprising mark is scaled as that of the extended filter (specification 6.4(b)).
Nothing here is written for speed: a mark takes some ten times as long as in the filter of scalar rows.

References
----------
bell1993; julier1997; arasaratnam2009; specification 6.3.
"""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.lanes import CKF, EIGENVALUE_FLOOR, IEKF, RAW, SCALE_FROM_SIGMA, UKF
from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import LANES, strict

# After the updates of `lanes.UPDATES`: the extended filter with one formula as it is printed.
PRINTED_SIGN, PRINTED_GRADIENT = 5, 6
ITERATIONS = 5
ALPHA, BETA, KAPPA = 0.5, 2.0, 0.0
SPREAD = ALPHA * ALPHA * (9.0 + KAPPA)
NEAREST_M = 1e-3


@strict
def update_jointly(setup, now, go, x, p, nis_out):
    """Update every lane whose `go` is set; x (9, LANES), p (45, LANES); NIS, scale and determinant into `now`."""
    for lane in range(LANES):
        now.scale[lane] = 1.0
        now.determinant[lane] = 1.0
        nis_out[lane] = 0.0
        if go[lane] > 0.0:
            _update_lane(lane, setup, now, x, p, nis_out)


@strict
def _update_lane(lane, setup, now, x, p, nis_out):
    raw = setup.update == RAW
    count = now.receptions[lane] if now.receptions[lane] >= 2 else 0
    who = np.empty(max(count, 1), np.int64)
    n = 0
    for s in range(setup.stations.shape[0]):
        if now.used[s, lane] > 0.0 and count > 0:
            who[n] = s
            n += 1
    known = 1 if now.has_altitude[lane] > 0.0 else 0
    rows = (count if raw else max(count - 1, 0)) + known
    if rows == 0:
        return
    z = np.zeros(rows)
    noise = np.zeros((rows, rows))
    _observe(lane, setup, now, who, count, known, raw, z, noise)
    mean = np.empty(9)
    full = np.empty((9, 9))
    for i in range(9):
        mean[i] = x[i, lane]
        for j in range(i + 1):
            full[i, j] = p[i * (i + 1) // 2 + j, lane]
            full[j, i] = full[i, j]
    # The claim of surprise is made with the declared noise; what exceeds it scales the noise, and the mark is taken.
    scale = 1.0
    for attempt in range(2):
        innovation, cross, s_matrix, sound = _innovate(lane, setup, now, who, count, known, mean, full, z, noise, scale)
        root = np.zeros((rows, rows))
        if not sound or not _cholesky(s_matrix, root):
            return
        nis = _squared(root, innovation)
        if attempt == 0:
            now.nis[lane] = nis
            dof = (count - 1 if count > 0 else 0) + known
            limit = SCALE_FROM_SIGMA**2 * dof
            if not setup.robust or not nis > limit:
                break
            scale = nis / limit
            now.scale[lane] = scale
    nis_out[lane] = _squared(root, innovation)
    now.determinant[lane] = _determinant(root) / (_determinant_of(noise) * scale**rows)
    gain = _solved(root, cross)
    sign = -1.0 if setup.update == PRINTED_SIGN else 1.0
    for i in range(9):
        total = mean[i]
        for r in range(rows):
            total += sign * gain[i, r] * innovation[r]
        x[i, lane] = total
        for j in range(i + 1):
            value = full[i, j]
            for r in range(rows):
                value -= gain[i, r] * cross[j, r]
            p[i * (i + 1) // 2 + j, lane] = value


@strict
def _observe(lane, setup, now, who, count, known, raw, z, noise):
    """What was measured and its covariance: differences against the last reception, or the times themselves."""
    n = count if raw else max(count - 1, 0)
    last = who[count - 1] if count > 0 else 0
    for i in range(n):
        s = who[i]
        z[i] = now.toa[s, lane] if raw else now.toa[last, lane] - now.toa[s, lane]
        common = setup.emission_variance if raw else setup.variance[last]
        for j in range(n):
            noise[i, j] = common + (setup.variance[s] if i == j else 0.0)
    if known == 1:
        z[n] = now.altitude[lane]
        noise[n, n] = setup.altitude_variance + now.altitude_extra[lane]


@strict
def _expect(a, b, c, setup, who, count, known, raw, h, jacobian):
    """Measurements that a position (a, b, c) makes, and their derivatives by it; raw ones without the emission."""
    u = np.empty((max(count, 1), 3))
    r = np.empty(max(count, 1))
    for i in range(count):
        dx = a - setup.stations[who[i], 0]
        dy = b - setup.stations[who[i], 1]
        dz = c - setup.stations[who[i], 2]
        r[i] = max(np.sqrt(dx * dx + dy * dy + dz * dz), NEAREST_M)
        u[i, 0] = dx / r[i]
        u[i, 1] = dy / r[i]
        u[i, 2] = dz / r[i]
    n = count if raw else max(count - 1, 0)
    for i in range(n):
        h[i] = r[i] if raw else r[count - 1] - r[i]
        for k in range(3):
            jacobian[i, k] = u[i, k] if raw else u[count - 1, k] - u[i, k]
    if known == 1:
        height, gx, gy, gz = height_and_up(a, b, c, setup.earth)
        h[n] = height
        jacobian[n, 0] = gx
        jacobian[n, 1] = gy
        jacobian[n, 2] = gz * c / (setup.earth[1] + c) if setup.update == PRINTED_GRADIENT else gz


@strict
def _innovate(lane, setup, now, who, count, known, mean, full, z, noise, scale):
    """Innovation, its covariance with the state (9, rows) and its own; False where no root of P exists."""
    rows = z.shape[0]
    raw = setup.update == RAW
    h = np.zeros(rows)
    jacobian = np.zeros((rows, 3))
    cross = np.zeros((9, rows))
    s_matrix = np.zeros((rows, rows))
    innovation = np.zeros(rows)
    if setup.update == UKF or setup.update == CKF:
        sound = _over_points(setup, who, count, known, mean, full, z, innovation, cross, s_matrix)
        for i in range(rows):
            for j in range(rows):
                s_matrix[i, j] += scale * noise[i, j]
        return innovation, cross, s_matrix, sound
    at = np.empty(3)
    for a in range(3):
        at[a] = now.at[a, lane]
    root = np.zeros((rows, rows))
    for step in range(ITERATIONS if setup.update == IEKF else 1):
        _expect(at[0], at[1], at[2], setup, who, count, known, raw, h, jacobian)
        for i in range(rows):
            innovation[i] = z[i] - h[i]
            for a in range(3):
                innovation[i] -= jacobian[i, a] * (mean[3 * a] - at[a])
            for k in range(9):
                cross[k, i] = 0.0
                for a in range(3):
                    cross[k, i] += full[k, 3 * a] * jacobian[i, a]
        if raw:
            # The emission is expected where the prediction would have it.
            middle = 0.0
            for i in range(count):
                middle += innovation[i] / count
            for i in range(count):
                innovation[i] -= middle
        for i in range(rows):
            for j in range(rows):
                s_matrix[i, j] = scale * noise[i, j]
                for a in range(3):
                    s_matrix[i, j] += jacobian[i, a] * cross[3 * a, j]
        if step + 1 < ITERATIONS and setup.update == IEKF:
            if not _cholesky(s_matrix, root):
                return innovation, cross, s_matrix, False
            gain = _solved(root, cross)
            for a in range(3):
                at[a] = mean[3 * a]
                for r in range(rows):
                    at[a] += gain[3 * a, r] * innovation[r]
    return innovation, cross, s_matrix, True


@strict
def _over_points(setup, who, count, known, mean, full, z, innovation, cross, s_matrix):
    """Statistical linearisation over the points of the unscented or the cubature rule."""
    rows = z.shape[0]
    unscented = setup.update == UKF
    root = np.zeros((9, 9))
    if not _cholesky(full, root):
        values, vectors = np.linalg.eigh(full)
        for i in range(9):
            for j in range(9):
                root[i, j] = vectors[i, j] * np.sqrt(max(values[j], EIGENVALUE_FLOOR))
    reach = np.sqrt(SPREAD if unscented else 9.0)
    weight = 0.5 / SPREAD if unscented else 1.0 / 18.0
    centre = 1.0 - 9.0 / SPREAD if unscented else 0.0
    centre_covariance = centre + 1.0 - ALPHA * ALPHA + BETA if unscented else 0.0
    values_at = np.zeros((19, rows))
    waste = np.zeros((rows, 3))
    for k in range(19):
        sign = 0.0 if k == 18 else 1.0 if k < 9 else -1.0
        column = k % 9
        a = mean[0] + sign * reach * root[0, column]
        b = mean[3] + sign * reach * root[3, column]
        c = mean[6] + sign * reach * root[6, column]
        _expect(a, b, c, setup, who, count, known, False, values_at[k], waste)
    for i in range(rows):
        expected = centre * values_at[18, i]
        for k in range(18):
            expected += weight * values_at[k, i]
        innovation[i] = z[i] - expected
        for k in range(19):
            values_at[k, i] -= expected
    for i in range(rows):
        for j in range(rows):
            total = centre_covariance * values_at[18, i] * values_at[18, j]
            for k in range(18):
                total += weight * values_at[k, i] * values_at[k, j]
            s_matrix[i, j] = total
        for m in range(9):
            total = 0.0
            for column in range(9):
                total += root[m, column] * (values_at[column, i] - values_at[9 + column, i])
            cross[m, i] = weight * reach * total
    return True


@strict
def _cholesky(matrix, root):
    """Lower root of a symmetric matrix; False where it has none."""
    for i in range(matrix.shape[0]):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= root[i, k] * root[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                root[i, i] = np.sqrt(total)
            else:
                root[i, j] = total / root[j, j]
    return True


@strict
def _squared(root, e):
    """Squared length of e (n,) in units of the matrix whose root is given."""
    n = e.shape[0]
    y = np.empty(n)
    total = 0.0
    for i in range(n):
        y[i] = e[i]
        for k in range(i):
            y[i] -= root[i, k] * y[k]
        y[i] /= root[i, i]
        total += y[i] * y[i]
    return total


@strict
def _solved(root, cross):
    """(9, n): each row of `cross` times the inverse of the matrix whose root is given."""
    n = root.shape[0]
    gain = np.empty((9, n))
    for m in range(9):
        for i in range(n):
            gain[m, i] = cross[m, i]
            for k in range(i):
                gain[m, i] -= root[i, k] * gain[m, k]
            gain[m, i] /= root[i, i]
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                gain[m, i] -= root[k, i] * gain[m, k]
            gain[m, i] /= root[i, i]
    return gain


@strict
def _determinant(root):
    value = 1.0
    for i in range(root.shape[0]):
        value *= root[i, i] * root[i, i]
    return value


@strict
def _determinant_of(matrix):
    root = np.zeros(matrix.shape)
    return _determinant(root) if _cholesky(matrix, root) else 1.0
