"""Levenberg's and Marquardt's descent to the curve of one window, compiled: nine tenths of the tracker's time.

The equations are those of `window.whitened` (positions in chord form, weights 1 / sigma), summed plot by plot. A window
is descended by itself, so its numbers do not depend on its neighbours.

References
----------
specification 3, 4.1; more1978.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import strict

# Typical are 3 to 12; what takes longer is a flat valley, and moderate motion is then expected instead.
MOST_ITERATIONS = 25
STEP_DONE = 1e-7
DECREASE_DONE = 1e-10
STEP_SMALL = 1e-3
MOST_DAMPING = 1e12
# Behind so many iterations a window that hardly gains is where it will be.
SLOW_AFTER, SLOW_DECREASE, SLOW_STEP = 10, 1e-4, 0.1
# Below this angle the integrals of the Jacobian are taken from their series.
SMALL_ANGLE = 0.01


@strict
def _wrapped(angle):
    """An angle in (-pi, pi]."""
    return -((-angle + np.pi) % (2.0 * np.pi)) + np.pi


@strict
def _normal(n, plots, p, prior, information, gradient):
    """Write J'J (6, 6) and J'r (6,) of the penalised cost at p; return chi-square and the penalised cost.

    plots : (5, n) range m, azimuth rad, time s, sigma of range m, sigma of azimuth rad
    """
    x0, y0, g0, b, a, curvature = p[0], p[1], p[2], p[3], p[4], p[5]
    sin0, cos0 = np.sin(g0), np.cos(g0)
    row = np.empty((2, 6))
    information[:] = 0.0
    gradient[:] = 0.0
    chi2 = 0.0
    for k in range(n):
        t = plots[2, k]
        s = (b + 0.5 * a * t) * t
        w = curvature * s
        u = 0.5 * w
        sin_u, cos_u = np.sin(u), np.cos(u)
        chord = s * (sin_u / u) if u != 0.0 else s
        # Direction of the chord, and of the flight at its end.
        cos1, sin1 = cos0 * cos_u - sin0 * sin_u, sin0 * cos_u + cos0 * sin_u
        cos2, sin2 = cos1 * cos_u - sin1 * sin_u, sin1 * cos_u + cos1 * sin_u
        dx, dy = chord * cos1, chord * sin1
        x, y = x0 + dx, y0 + dy
        rho = max(np.sqrt(x * x + y * y), 1e-3)
        square = w * w
        if abs(w) < SMALL_ANGLE:
            cosine = 0.5 - square / 8.0 + square * square / 144.0
            sine = w / 3.0 - w * square / 30.0 + w * square * square / 840.0
        else:
            sin_w, cos_w = 2.0 * sin_u * cos_u, 1.0 - 2.0 * sin_u * sin_u
            cosine = (w * sin_w - 2.0 * sin_u * sin_u) / square
            sine = (sin_w - w * cos_w) / square
        half = 0.5 * t * t
        bent_x, bent_y = -s * s * (sin0 * cosine + cos0 * sine), s * s * (cos0 * cosine - sin0 * sine)
        # Derivatives of range and azimuth by north and east, in standard deviations.
        rx, ry = x / (rho * plots[3, k]), y / (rho * plots[3, k])
        ax, ay = -y / (rho * rho * plots[4, k]), x / (rho * rho * plots[4, k])
        for i, to_x, to_y in ((0, rx, ry), (1, ax, ay)):
            row[i, 0] = to_x
            row[i, 1] = to_y
            row[i, 2] = to_y * dx - to_x * dy
            row[i, 3] = t * (to_x * cos2 + to_y * sin2)
            row[i, 4] = half * (to_x * cos2 + to_y * sin2)
            row[i, 5] = to_x * bent_x + to_y * bent_y
        r = (plots[0, k] - rho) / plots[3, k]
        q = _wrapped(plots[1, k] - np.arctan2(y, x)) / plots[4, k]
        chi2 += r * r + q * q
        for i in range(6):
            gradient[i] += row[0, i] * r + row[1, i] * q
            for j in range(i + 1):
                information[i, j] += row[0, i] * row[0, j] + row[1, i] * row[1, j]
    value = chi2
    for i in range(2):
        weighted = prior[i] * p[4 + i]
        value += weighted * weighted
        information[4 + i, 4 + i] += prior[i] * prior[i]
        gradient[4 + i] -= prior[i] * weighted
    for i in range(6):
        for j in range(i):
            information[j, i] = information[i, j]
    if not np.isfinite(value):
        value = np.inf
    return chi2, value


@strict
def _damped(information, gradient, scale, damping, lower, step):
    """Write the step of the damped equations with a unit diagonal; False where rounding leaves none."""
    for i in range(6):
        for j in range(i + 1):
            total = information[i, j] / (scale[i] * scale[j])
            if i == j:
                total += damping
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                lower[i, i] = np.sqrt(total)
            else:
                lower[i, j] = total / lower[j, j]
    for i in range(6):
        total = gradient[i] / scale[i]
        for k in range(i):
            total -= lower[i, k] * step[k]
        step[i] = total / lower[i, i]
    for i in range(5, -1, -1):
        total = step[i]
        for k in range(i + 1, 6):
            total -= lower[k, i] * step[k]
        step[i] = total / lower[i, i]
    return True


@strict
def _descend_one(n, plots, p, prior, information, gradient):
    """Move p (6,) to the minimum and leave the information there; return chi-square and whether it converged."""
    trial, other, change = np.empty(6), np.empty((6, 6)), np.empty(6)
    scale, step, lower = np.empty(6), np.empty(6), np.empty((6, 6))
    _, value = _normal(n, plots, p, prior, information, gradient)
    damping, done = 1e-3, False
    for iteration in range(MOST_ITERATIONS):
        for i in range(6):
            scale[i] = np.sqrt(max(information[i, i], 1e-300))
        if not _damped(information, gradient, scale, damping, lower, step):
            damping *= 10.0
            if damping > MOST_DAMPING:
                done = True
                break
            continue
        size = 0.0
        for i in range(6):
            size += step[i] * step[i]
            trial[i] = p[i] + step[i] / scale[i]
        size = np.sqrt(size)
        _, attempted = _normal(n, plots, trial, prior, other, change)
        better = attempted <= value
        gained = (value - attempted) / max(value, 1e-12)
        done = size < STEP_DONE or (better and gained < DECREASE_DONE and size < STEP_SMALL)
        if iteration >= SLOW_AFTER and better and gained < SLOW_DECREASE and size < SLOW_STEP:
            # In a flat valley every step gains next to nothing: it is a hundredth of an error from the minimum.
            done = True
        if better:
            damping = max(0.1 * damping, 1e-12)
            p[:] = trial
            information[:] = other
            gradient[:] = change
            value = attempted
        else:
            damping *= 10.0
        # Nothing that it could still try is below: the minimum is as exact as the numbers allow.
        done = done or damping > MOST_DAMPING
        if done:
            break
    if p[3] < 0.0:
        # The same motion with a speed that is not negative.
        p[2] += np.pi
        p[3], p[4], p[5] = -p[3], -p[4], -p[5]
    p[2] = _wrapped(p[2])
    chi2, _ = _normal(n, plots, p, prior, information, gradient)
    return chi2, done


@strict
def descend(rho, theta, t, known, sigma_r, sigma_th, p, prior, information, cost, converged):
    """Descend in every window from p, which becomes the minimum.

    Parameters
    ----------
    rho, theta, t, known, sigma_r, sigma_th : (H, W), as in `Window`
    p : (6, W) where to start, and what was found
    prior : (2, W) weights of a and K
    information, cost, converged : (6, 6, W), (W,), (W,) written: with the penalty, without it; a start that is no
        number has an infinite cost and has not converged
    """
    plots = np.empty((5, rho.shape[0]))
    own, own_information, own_prior, gradient = np.empty(6), np.empty((6, 6)), np.empty(2), np.empty(6)
    for w in range(rho.shape[1]):
        n = 0
        for k in range(rho.shape[0]):
            if known[k, w]:
                plots[0, n], plots[1, n], plots[2, n] = rho[k, w], theta[k, w], t[k, w]
                plots[3, n], plots[4, n] = sigma_r[k, w], sigma_th[k, w]
                n += 1
        sound = True
        for i in range(6):
            own[i] = p[i, w]
            sound = sound and np.isfinite(own[i])
        if not sound:
            own[:] = 0.0
        own_prior[0], own_prior[1] = prior[0, w], prior[1, w]
        chi2, done = _descend_one(n, plots, own, own_prior, own_information, gradient)
        p[:, w] = own
        information[:, :, w] = own_information
        cost[w] = chi2 if sound else np.inf
        converged[w] = done and sound
