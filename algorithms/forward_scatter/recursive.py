"""Recursive filters for comparison: extended or unscented Kalman filter of the motion, iterated one of the crossing.

- ekf, ukf: state x, v_x, y, v_y moves straight on, disturbed by white acceleration;
- static: parameters (tau, gamma, s, v_x) stay; gamma, the slope at the crossing, in place of v_y, because the data
  measure it best: v_y = +-sqrt(-gamma lambda s (a - s) / a). Each pair is linearised anew three times.

All start from a likelihood fit of the first pairs. Started early they lose up to half (static: several times), because
the posterior is a curved ridge; and [x v_x y v_y] stays overconfident.

References
----------
specification 6.4; barshalom2001, sec. 10.3. Differences from the paper: it has no filter.
"""

from __future__ import annotations

import numpy as np

from algorithms.forward_scatter.motion import UNKNOWNS, model, model_gradient
from algorithms.toolbox.kernels import strict
from algorithms.toolbox.sensors.doppler import doppler, doppler_gradient

EKF, UKF, STATIC = range(3)
FORMS = ("ekf", "ukf", "static")
ROUNDS = 3
N = 4
# Sigma points lie sqrt(3) standard deviations out: right to the fourth moment of a normal distribution.
KAPPA = 3.0 - N


@strict
def _update(x, p, h, innovation, variance):
    """One scalar measurement."""
    w = np.zeros(N)
    s = variance
    for i in range(N):
        for j in range(N):
            w[i] += p[i, j] * h[j]
        s += h[i] * w[i]
    for i in range(N):
        x[i] += w[i] * innovation / s
    for i in range(N):
        for j in range(i + 1):
            p[i, j] -= w[i] * w[j] / s
            p[j, i] = p[i, j]


@strict
def _root(p, lower):
    """Cholesky factor; False where p is not positive definite."""
    lower[:] = 0.0
    for i in range(N):
        for j in range(i + 1):
            total = p[i, j]
            for m in range(j):
                total -= lower[i, m] * lower[j, m]
            if i == j:
                if not total > 0.0:
                    return False
                lower[i, i] = np.sqrt(total)
            else:
                lower[i, j] = total / lower[j, j]
    return True


@strict
def _predict(x, p, dt, q):
    """Straight on for dt; q is the density of the white acceleration, m2/s3, on each axis."""
    f = np.zeros((N, N))
    for i in range(N):
        f[i, i] = 1.0
    f[0, 1] = dt
    f[2, 3] = dt
    y = np.zeros(N)
    half = np.zeros((N, N))
    new = np.zeros((N, N))
    for i in range(N):
        for j in range(N):
            y[i] += f[i, j] * x[j]
            for m in range(N):
                half[i, j] += f[i, m] * p[m, j]
    for i in range(N):
        for j in range(N):
            for m in range(N):
                new[i, j] += half[i, m] * f[j, m]
    for a in range(2):
        new[2 * a, 2 * a] += q * dt**3 / 3.0
        new[2 * a, 2 * a + 1] += q * dt * dt / 2.0
        new[2 * a + 1, 2 * a] += q * dt * dt / 2.0
        new[2 * a + 1, 2 * a + 1] += q * dt
    for i in range(N):
        x[i] = y[i]
        for j in range(N):
            p[i, j] = 0.5 * (new[i, j] + new[j, i])


@strict
def _update_unscented(x, p, f, feet, wavelength, altitude, variance, lower):
    """One Doppler by sigma points."""
    if not _root(p, lower):
        return
    points = np.empty((2 * N + 1, N))
    value = np.empty(2 * N + 1)
    spread = np.sqrt(N + KAPPA)
    for m in range(2 * N + 1):
        for i in range(N):
            points[m, i] = x[i]
            if 0 < m <= N:
                points[m, i] += spread * lower[i, m - 1]
            elif m > N:
                points[m, i] -= spread * lower[i, m - N - 1]
        value[m] = doppler(points[m, 0], points[m, 2], altitude, points[m, 1], points[m, 3], 0.0, feet, wavelength)
    centre = KAPPA / (N + KAPPA)
    side = 0.5 / (N + KAPPA)
    mean = centre * value[0]
    for m in range(1, 2 * N + 1):
        mean += side * value[m]
    s = variance + centre * (value[0] - mean) ** 2
    cross = np.zeros(N)
    for m in range(1, 2 * N + 1):
        s += side * (value[m] - mean) ** 2
        for i in range(N):
            cross[i] += side * (points[m, i] - x[i]) * (value[m] - mean)
    if not s > 0.0:
        return
    for i in range(N):
        x[i] += cross[i] * (f - mean) / s
    for i in range(N):
        for j in range(i + 1):
            p[i, j] -= cross[i] * cross[j] / s
            p[j, i] = p[i, j]


@strict
def _theta_of(static, sign, a, wavelength, theta):
    """(tau, gamma, s, v_x) to theta."""
    s = min(max(static[2], 1.0), a - 1.0)
    theta[0] = static[0]
    theta[1] = s
    theta[2] = sign * np.sqrt(max(-static[1], 1e-9) * wavelength * s * (a - s) / a)
    theta[3] = static[3]
    theta[4] = 0.0


@strict
def _update_static(x, p, t, f, feet, wavelength, altitude, variance, sign, a, work, row, theta):
    """Both Dopplers of an instant (f (C,), NaN = none), linearised three times about the last answer."""
    x0 = x.copy()
    p0 = p.copy()
    h = np.empty(N)
    for _ in range(ROUNDS):
        at = x.copy()
        x[:] = x0
        p[:] = p0
        _theta_of(at, sign, a, wavelength, theta)
        by_gamma = 0.5 * theta[2] / min(at[1], -1e-9)
        by_s = 0.5 * theta[2] * (1.0 / theta[1] - 1.0 / (a - theta[1]))
        for c in range(f.shape[0]):
            if np.isfinite(f[c]):
                value = model_gradient(t, theta, altitude, feet[c], wavelength, work, row)
                h[0] = row[0]
                h[1] = row[2] * by_gamma
                h[2] = row[1] + row[2] * by_s
                h[3] = row[3]
                predicted = value
                for i in range(N):
                    predicted += h[i] * (x[i] - at[i])
                _update(x, p, h, f[c] - predicted, variance)
        x[1] = min(x[1], -1e-6)
        x[2] = min(max(x[2], 50.0), a - 50.0)


@strict
def _spread(j, p, rows, out):
    """J P J' of a (rows, 4) Jacobian into the corner of `out` (5, 5)."""
    out[:] = 0.0
    for q in range(rows):
        for r in range(q + 1):
            total = 0.0
            for i in range(N):
                for m in range(N):
                    total += j[q, i] * p[i, m] * j[r, m]
            out[q, r] = total
            out[r, q] = total


@strict
def filter_pass(problem, f, begin, start, start_covariance, form, q, theta_out, covariance_out, chi2_out, dof_out):
    """Filter a pass from the epoch after each lane's `begin` on (L,), -1 = none; f (C, K, L).

    start (5, L) and start_covariance (5, 5, L) are the fit at `begin`; outputs as those of `fit.Fits`.
    """
    channels, epochs, lanes = f.shape
    variance = problem.sigma**2
    x = np.empty(N)
    p = np.empty((N, N))
    j = np.zeros((UNKNOWNS, N))
    old = np.empty((N, N))
    lower = np.empty((N, N))
    work = np.empty(6)
    row = np.empty(UNKNOWNS)
    theta = np.zeros(UNKNOWNS)
    h = np.empty(N)
    one = np.empty(channels)
    spread = np.empty((UNKNOWNS, UNKNOWNS))
    for lane in range(lanes):
        k0 = begin[lane]
        if k0 < 0:
            continue
        tau = start[0, lane]
        s = start[1, lane]
        vy = start[2, lane]
        vx = start[3, lane]
        sign = 1.0 if vy > 0.0 else -1.0
        for i in range(N):
            for m in range(N):
                old[i, m] = start_covariance[i, m, lane]
        j[:] = 0.0
        d = problem.time[k0] - tau
        if form == STATIC:
            gamma = -vy * vy * problem.a / (problem.wavelength * s * (problem.a - s))
            x[0] = tau
            x[1] = gamma
            x[2] = s
            x[3] = vx
            j[0, 0] = 1.0
            j[1, 1] = -gamma * (1.0 / s - 1.0 / (problem.a - s))
            j[1, 2] = 2.0 * gamma / vy
            j[2, 1] = 1.0
            j[3, 3] = 1.0
        else:
            x[0] = s + vx * d
            x[1] = vx
            x[2] = vy * d
            x[3] = vy
            j[0, 0] = -vx
            j[0, 1] = 1.0
            j[0, 3] = d
            j[1, 3] = 1.0
            j[2, 0] = -vy
            j[2, 2] = d
            j[3, 2] = 1.0
        _spread(j, old, N, spread)
        for i in range(N):
            for m in range(N):
                p[i, m] = spread[i, m]
        chi2 = 0.0
        count = 0
        for k in range(k0 + 1, epochs):
            t = problem.time[k]
            if form != STATIC:
                _predict(x, p, t - problem.time[k - 1], q)
            for c in range(channels):
                one[c] = f[c, k, lane]
                if not np.isfinite(one[c]):
                    continue
                if form == STATIC:
                    _theta_of(x, sign, problem.a, problem.wavelength, theta)
                    rest = one[c] - model(t, theta, problem.altitude, problem.feet[c], problem.wavelength)
                else:
                    rest = one[c] - doppler_gradient(
                        x[0], x[2], problem.altitude, x[1], x[3], 0.0, problem.feet[c], problem.wavelength, work
                    )
                    h[0] = work[0]
                    h[1] = work[3]
                    h[2] = work[1]
                    h[3] = work[4]
                    if form == EKF:
                        _update(x, p, h, rest, variance)
                    else:
                        _update_unscented(
                            x, p, one[c], problem.feet[c], problem.wavelength, problem.altitude, variance, lower
                        )
                chi2 += rest * rest / variance
                count += 1
            if form == STATIC:
                _update_static(
                    x, p, t, one, problem.feet, problem.wavelength, problem.altitude, variance, sign, problem.a,
                    work, row, theta,
                )  # fmt: skip
            j[:] = 0.0
            if form == STATIC:
                _theta_of(x, sign, problem.a, problem.wavelength, theta)
                j[0, 0] = 1.0
                j[1, 2] = 1.0
                j[2, 1] = 0.5 * theta[2] / x[1]
                j[2, 2] = 0.5 * theta[2] * (1.0 / theta[1] - 1.0 / (problem.a - theta[1]))
                j[3, 3] = 1.0
            else:
                back = x[2] / x[3]
                theta[0] = t - back
                theta[1] = x[0] - x[1] * back
                theta[2] = x[3]
                theta[3] = x[1]
                theta[4] = 0.0
                j[0, 2] = -1.0 / x[3]
                j[0, 3] = back / x[3]
                j[1, 0] = 1.0
                j[1, 1] = -back
                j[1, 2] = -x[1] / x[3]
                j[1, 3] = x[1] * back / x[3]
                j[2, 3] = 1.0
                j[3, 1] = 1.0
            _spread(j, p, N, spread)
            for i in range(UNKNOWNS):
                theta_out[k, i, lane] = theta[i]
                for m in range(UNKNOWNS):
                    covariance_out[k, i, m, lane] = spread[i, m]
            chi2_out[k, lane] = chi2
            dof_out[k, lane] = count
