"""Maximum likelihood of theta = (tau, s, v_y, v_x, a_y) from all Dopplers so far: Levenberg and Marquardt's steps.

Minimised is the cost = chi2 / 2 = sum rho(r / sigma) + v_x^2 / (2 sd_x^2) + a_y^2 / (2 sd_a^2), r the residual against
the exact Doppler; rho is r^2 / 2, or Huber's with k = 2. Scales are 1 s, 1 km, 10 m/s, 10 m/s, 1 m/s2; s stays at least
50 m from both ends.

The start is a scan: a line for each channel gives tau and the mean slope; for s on 39 places the slope gives |v_y|;
both signs are tried, because a wrong sign of v_y is never left again.

References
----------
specification 6.1, 6.2. Differences from the paper: it has no such estimator; v_x is unknown here, because a wrong
course that is taken for known gives a precise and wrong answer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.forward_scatter.lines import weighted_line
from algorithms.forward_scatter.motion import UNKNOWNS, model, model_gradient
from algorithms.toolbox.kernels import strict

SCALE = (1.0, 1000.0, 10.0, 10.0, 1.0)
LEAST_DISTANCE_M = 50.0
PLACES = 39
CAP_HZ2 = 25.0
MOST_ROUNDS = 400
SMALL_STEP = 1e-9
# Shares of the promised gain above which the damping falls, and below which it rises.
MOST_KEPT = 0.75
LEAST_KEPT = 0.25
HUBER_K = 2.0
# Free parameters that the data do not pull are held by this much information, in scaled units: it keeps the matrix
# regular and is worth nothing against a single Doppler.
HOLD = 1e-12


class Problem(NamedTuple):
    """What is measured and what is known, SI units."""

    time: np.ndarray
    """(K,) s."""
    feet: np.ndarray
    """(C, 2, 3) m: transmitter and receiver of each channel."""
    wavelength: float
    sigma: float
    altitude: float
    a: float
    prior_x: float
    """Information of the prior of v_x, (s/m)^2; 0 = none."""
    prior_a: float
    """The same of a_y, (s2/m)^2."""


@strict
def scan(f, weight, epochs, p, theta):
    """Put the best start into theta (5,), a_y = 0; False where the lines do not fall."""
    channels = f.shape[0]
    line = np.empty(5)
    t = np.empty(epochs)
    v = np.empty(epochs)
    w = np.empty(epochs)
    tau = 0.0
    slope = 0.0
    lines = 0
    for c in range(channels):
        count = 0
        for k in range(epochs):
            if weight[c, k] > 0.0:
                t[count] = p.time[k]
                v[count] = f[c, k]
                w[count] = 1.0
                count += 1
        if count < 2 or not weighted_line(t, v, w, count, line) or line[2] >= 0.0:
            continue
        tau += line[0] - line[1] / line[2]
        slope += line[2]
        lines += 1
    if lines == 0:
        return False
    tau /= lines
    slope /= lines
    best = np.inf
    tried = np.zeros(UNKNOWNS)
    tried[0] = tau
    for i in range(PLACES):
        tried[1] = (i + 1) / (PLACES + 1) * p.a
        speed = np.sqrt(-slope * p.wavelength * tried[1] * (p.a - tried[1]) / p.a)
        for sign in range(2):
            tried[2] = speed if sign == 0 else -speed
            score = 0.0
            for c in range(channels):
                for k in range(epochs):
                    if weight[c, k] > 0.0:
                        r = f[c, k] - model(p.time[k], tried, p.altitude, p.feet[c], p.wavelength)
                        score += min(r * r, CAP_HZ2)
                if score >= best:
                    break
            if score < best:
                best = score
                theta[:] = tried
    return True


@strict
def normal_equations(f, weight, epochs, p, theta, unknowns, huber, info, gradient):
    """Cost at theta, and its information (5, 5) and downhill direction (5,) in scaled units."""
    work = np.empty(6)
    row = np.empty(UNKNOWNS)
    for i in range(unknowns):
        gradient[i] = 0.0
        for j in range(unknowns):
            info[i, j] = 0.0
    cost = 0.0
    per = 1.0 / p.sigma
    for c in range(f.shape[0]):
        for k in range(epochs):
            if weight[c, k] <= 0.0:
                continue
            value = model_gradient(p.time[k], theta, p.altitude, p.feet[c], p.wavelength, work, row)
            r = (f[c, k] - value) * per
            w = 1.0
            if huber and abs(r) > HUBER_K:
                cost += HUBER_K * (abs(r) - 0.5 * HUBER_K)
                w = HUBER_K / abs(r)
            else:
                cost += 0.5 * r * r
            for i in range(unknowns):
                row[i] *= per * SCALE[i]
                gradient[i] += w * row[i] * r
                for j in range(i + 1):
                    info[i, j] += w * row[i] * row[j]
    if unknowns > 3:
        cost += 0.5 * p.prior_x * theta[3] ** 2
        info[3, 3] += p.prior_x * SCALE[3] ** 2
        gradient[3] -= p.prior_x * theta[3] * SCALE[3]
    if unknowns > 4:
        cost += 0.5 * p.prior_a * theta[4] ** 2
        info[4, 4] += p.prior_a * SCALE[4] ** 2
        gradient[4] -= p.prior_a * theta[4] * SCALE[4]
    for i in range(unknowns):
        info[i, i] += HOLD
        for j in range(i):
            info[j, i] = info[i, j]
    return cost


@strict
def cost_at(f, weight, epochs, p, theta, unknowns, huber):
    """Cost at theta alone."""
    cost = 0.0
    for c in range(f.shape[0]):
        for k in range(epochs):
            if weight[c, k] > 0.0:
                r = abs(f[c, k] - model(p.time[k], theta, p.altitude, p.feet[c], p.wavelength)) / p.sigma
                cost += HUBER_K * (r - 0.5 * HUBER_K) if huber and r > HUBER_K else 0.5 * r * r
    if unknowns > 3:
        cost += 0.5 * p.prior_x * theta[3] ** 2
    if unknowns > 4:
        cost += 0.5 * p.prior_a * theta[4] ** 2
    return cost


@strict
def solve(info, right, damping, n, lower, step):
    """Solve (info + damping diag(info)) step = right by Cholesky; False where it is not positive definite."""
    for i in range(n):
        for j in range(i + 1):
            total = info[i, j]
            if i == j:
                total += damping * info[i, i]
            for m in range(j):
                total -= lower[i, m] * lower[j, m]
            if i == j:
                if not total > 0.0:
                    return False
                lower[i, i] = np.sqrt(total)
            else:
                lower[i, j] = total / lower[j, j]
    for i in range(n):
        total = right[i]
        for m in range(i):
            total -= lower[i, m] * step[m]
        step[i] = total / lower[i, i]
    for i in range(n - 1, -1, -1):
        total = step[i]
        for m in range(i + 1, n):
            total -= lower[m, i] * step[m]
        step[i] = total / lower[i, i]
    return True


@strict
def along_ridge(theta, ds, dv, a):
    """v_y after a step (ds, dv) of (s, v_y): of v_y / sqrt(s (a - s)), which the slope tells, the step is straight."""
    here = theta[1] * (a - theta[1])
    there = (theta[1] + ds) * (a - theta[1] - ds)
    tangent = theta[2] * (a - 2.0 * theta[1]) * ds / (2.0 * here)
    return (theta[2] + dv - tangent) * np.sqrt(there / here)


@strict
def minimise(f, weight, epochs, p, theta, unknowns, huber, info, gradient):
    """Go downhill from theta, in place; return the cost and whether it ended, with information and gradient there."""
    lower = np.empty((UNKNOWNS, UNKNOWNS))
    step = np.empty(UNKNOWNS)
    tried = theta.copy()
    cost = normal_equations(f, weight, epochs, p, theta, unknowns, huber, info, gradient)
    damping = 1e-3
    for _ in range(MOST_ROUNDS):
        low = theta[1] <= LEAST_DISTANCE_M and gradient[1] < 0.0
        if low or (theta[1] >= p.a - LEAST_DISTANCE_M and gradient[1] > 0.0):
            # Held at an end of the base line, s must not push the others about.
            gradient[1] = 0.0
            for i in range(unknowns):
                if i != 1:
                    info[1, i] = 0.0
                    info[i, 1] = 0.0
        # One that has ended must not be left by a step that only rounding makes look downhill.
        if not solve(info, gradient, damping, unknowns, lower, step):
            damping = max(10.0 * damping, 1e-6)
            continue
        size = 0.0
        promised = 0.0
        for i in range(unknowns):
            tried[i] = theta[i] + SCALE[i] * step[i]
            size = max(size, abs(step[i]))
            promised += 0.5 * step[i] * (gradient[i] + damping * info[i, i] * step[i])
        tried[1] = min(max(tried[1], LEAST_DISTANCE_M), p.a - LEAST_DISTANCE_M)
        # Near the crossing what Dopplers allow is curved; far from it, it is not.
        straight = tried[2]
        lowered = cost_at(f, weight, epochs, p, tried, unknowns, huber)
        tried[2] = along_ridge(theta, tried[1] - theta[1], straight - theta[2], p.a)
        curved = cost_at(f, weight, epochs, p, tried, unknowns, huber)
        if curved < lowered:
            lowered = curved
        else:
            tried[2] = straight
        if lowered < cost:
            gain = cost - lowered
            for i in range(unknowns):
                theta[i] = tried[i]
            cost = normal_equations(f, weight, epochs, p, theta, unknowns, huber, info, gradient)
            # Along a curved ridge full steps overshoot, from one side to the other: they gain less than they promise.
            if gain > MOST_KEPT * promised:
                damping = max(damping * 0.1, 1e-12)
            elif gain < LEAST_KEPT * promised:
                damping *= 5.0
            if gain < 1e-10 * (1.0 + cost) or size < SMALL_STEP:
                return cost, True
        else:
            if size < 1e-6 or damping > 1e10:
                return cost, True
            damping *= 10.0
    return cost, False


@strict
def covariance_of(info, unknowns, out):
    """Inverse of the information in the units of theta into `out` (5, 5); False where it has none."""
    lower = np.empty((UNKNOWNS, UNKNOWNS))
    right = np.zeros(UNKNOWNS)
    column = np.empty(UNKNOWNS)
    scaled = np.empty((UNKNOWNS, UNKNOWNS))
    out[:] = 0.0
    for i in range(unknowns):
        for j in range(unknowns):
            scaled[i, j] = info[i, j] / np.sqrt(info[i, i] * info[j, j])
    for i in range(unknowns):
        right[:] = 0.0
        right[i] = 1.0
        if not solve(scaled, right, 0.0, unknowns, lower, column):
            return False
        for j in range(i + 1):
            value = SCALE[i] * SCALE[j] * column[j] / np.sqrt(info[i, i] * info[j, j])
            out[i, j] = value
            out[j, i] = value
    return True
