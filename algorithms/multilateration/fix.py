"""One mark solved for a position: closed-form starts, Levenberg-Marquardt, distinct minima.

The cost is the sum of the squared, whitened rows (Helmert contrasts of the receptions, and the altitude where there
is one); it has up to two distinct minima for three receptions with altitude. A solution carries its covariance (the
inverse information), its cost and the root mean square of its range residuals.

References
----------
more1978; specification 5, steps 1 and 2.
"""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.closed_form import MAX_CANDIDATES, closed_form_candidates
from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import kernel
from algorithms.toolbox.kernels.symmetric import invert3, solve3
from algorithms.toolbox.sensors.time_of_arrival import AT_STATION_M

MAX_ITERATIONS = 60
# Two minima nearer than this are one.
SAME_SOLUTION_M = 30.0
# A second minimum whose cost is this much higher than the first is not a rival (specification 5, step 3 (a)).
RIVAL_COST_GAP = 9.0
# An aircraft is not below the ground and not in space: solutions outside are the mirror images of the hyperboloids.
# Without an altitude, noise can push the only solution of a low target below the ground; it is then kept, as far as its
# own error allows.
LOWEST_ALTITUDE_M = -1_000.0
HIGHEST_ALTITUDE_M = 40_000.0
HEIGHT_SIGMAS = 3.0
# Standard deviation of the height that is assumed where the receptions say nothing about it.
VAGUE_HEIGHT_SD_M = 20_000.0
# A fix whose claimed horizontal error exceeds this many kilometres has no geometry behind it.
UNOBSERVABLE_DRMS_M = 1e6


@kernel
def _normal_equations(p, toa_m, used, stations, variance, altitude, altitude_variance, earth, info, grad):
    """Fill the packed information matrix and the gradient at p; return the cost."""
    for k in range(6):
        info[k] = 0.0
    grad[0] = 0.0
    grad[1] = 0.0
    grad[2] = 0.0
    cost = 0.0
    weight = 0.0
    mz = 0.0
    mr = 0.0
    m0 = 0.0
    m1 = 0.0
    m2 = 0.0
    for s in range(stations.shape[0]):
        if not used[s] > 0.0:
            continue
        dx = p[0] - stations[s, 0]
        dy = p[1] - stations[s, 1]
        dz = p[2] - stations[s, 2]
        r = np.sqrt(dx * dx + dy * dy + dz * dz)
        if not r > AT_STATION_M:
            continue
        dx /= r
        dy /= r
        dz /= r
        v = variance[s]
        if weight > 0.0:
            h0 = dx - m0
            h1 = dy - m1
            h2 = dz - m2
            nu = (toa_m[s] - mz) - (r - mr)
            w = 1.0 / (v + 1.0 / weight)
            cost += w * nu * nu
            _add_row(h0, h1, h2, nu, w, info, grad)
        gain = 1.0 / (v * weight + 1.0)
        weight += 1.0 / v
        mz += gain * (toa_m[s] - mz)
        mr += gain * (r - mr)
        m0 += gain * (dx - m0)
        m1 += gain * (dy - m1)
        m2 += gain * (dz - m2)
    if altitude == altitude:
        h, gx, gy, gz = height_and_up(p[0], p[1], p[2], earth)
        nu = altitude - h
        w = 1.0 / altitude_variance
        cost += w * nu * nu
        _add_row(gx, gy, gz, nu, w, info, grad)
    return cost


@kernel
def _add_row(h0, h1, h2, nu, w, info, grad):
    info[0] += w * h0 * h0
    info[1] += w * h1 * h0
    info[2] += w * h1 * h1
    info[3] += w * h2 * h0
    info[4] += w * h2 * h1
    info[5] += w * h2 * h2
    grad[0] += w * h0 * nu
    grad[1] += w * h1 * nu
    grad[2] += w * h2 * nu


@kernel
def minimise(p, toa_m, used, stations, variance, altitude, altitude_variance, earth, cov):
    """Levenberg-Marquardt from p (changed in place); the packed covariance into cov; return the cost or NaN."""
    info = np.empty(6)
    grad = np.empty(3)
    trial_info = np.empty(6)
    trial_grad = np.empty(3)
    step = np.empty(3)
    damped = np.empty(6)
    q = np.empty(3)
    cost = _normal_equations(p, toa_m, used, stations, variance, altitude, altitude_variance, earth, info, grad)
    damping = 1e-6
    for _ in range(MAX_ITERATIONS):
        for k in range(6):
            damped[k] = info[k]
        floor = 1e-9 * (info[0] + info[2] + info[5])
        damped[0] += damping * info[0] + floor * damping
        damped[2] += damping * info[2] + floor * damping
        damped[5] += damping * info[5] + floor * damping
        if not solve3(damped, grad, step):
            damping = max(damping * 10.0, 1e-9)
            if damping > 1e9:
                break
            continue
        for a in range(3):
            q[a] = p[a] + step[a]
        trial = _normal_equations(
            q, toa_m, used, stations, variance, altitude, altitude_variance, earth, trial_info, trial_grad
        )
        if trial <= cost:
            moved = abs(step[0]) + abs(step[1]) + abs(step[2])
            gained = cost - trial
            for a in range(3):
                p[a] = q[a]
                grad[a] = trial_grad[a]
            for k in range(6):
                info[k] = trial_info[k]
            cost = trial
            damping = max(damping * 0.1, 1e-12)
            if moved < 1e-5 or (gained < 1e-12 * (1.0 + cost) and moved < 1e-2):
                break
        else:
            damping *= 10.0
            if damping > 1e9:
                break
    if not (np.isfinite(cost) and np.isfinite(p[0] + p[1] + p[2])):
        return np.nan
    if not invert3(info, cov) or cov[5] > VAGUE_HEIGHT_SD_M * VAGUE_HEIGHT_SD_M:
        # The height is not observable (the solution lies in the stations' plane, say): hold it vaguely.
        info[5] += 1.0 / (VAGUE_HEIGHT_SD_M * VAGUE_HEIGHT_SD_M)
        if not invert3(info, cov):
            return np.nan
    if not cov[0] + cov[2] < UNOBSERVABLE_DRMS_M * UNOBSERVABLE_DRMS_M:
        return np.nan
    return cost


@kernel
def residual_rms(p, toa_m, used, stations, residual):
    """Range residuals of each reception about their mean, m (NaN where not received); return their rms."""
    n = 0
    mean = 0.0
    for s in range(stations.shape[0]):
        residual[s] = np.nan
        if used[s] > 0.0:
            dx = p[0] - stations[s, 0]
            dy = p[1] - stations[s, 1]
            dz = p[2] - stations[s, 2]
            residual[s] = toa_m[s] - np.sqrt(dx * dx + dy * dy + dz * dz)
            mean += residual[s]
            n += 1
    if n == 0:
        return np.nan
    mean /= n
    total = 0.0
    for s in range(stations.shape[0]):
        if used[s] > 0.0:
            residual[s] -= mean
            total += residual[s] * residual[s]
    return np.sqrt(total / n)


@kernel
def solve_mark(
    toa_m,
    used,
    stations,
    variance,
    altitude,
    altitude_variance,
    earth,
    centre,
    radius,
    position,
    covariance,
    cost,
):
    """Solve one mark; return the number of solutions (0, 1 or 2), the best first; -1 where all lie at a height that
    nothing flies at.

    Three receptions with altitude, or four and more, are solvable; fewer are not.

    Parameters
    ----------
    toa_m, used : (S,) float, m and 0/1
    stations : (S, 3) float, m; variance : (S,) float, m^2
    altitude : float, m, or NaN; altitude_variance : float, m^2
    earth, centre, radius : the Earth (see frames.earth) and the sphere that stands for it in the closed form
    position : (2, 3), covariance : (2, 6) packed, cost : (2,)
        Filled.
    """
    count = 0
    for s in range(stations.shape[0]):
        if used[s] > 0.0:
            count += 1
    if count < 3 or (count == 3 and altitude != altitude):
        return 0
    starts = np.empty((MAX_CANDIDATES, 3))
    n_starts = closed_form_candidates(toa_m, used, stations, altitude, centre, radius, starts)
    p = np.empty(3)
    cov = np.empty(6)
    found = 0
    admissible = 0
    outside = 0
    for i in range(n_starts):
        for a in range(3):
            p[a] = starts[i, a]
        value = minimise(p, toa_m, used, stations, variance, altitude, altitude_variance, earth, cov)
        if value != value:
            continue
        h, _, _, _ = height_and_up(p[0], p[1], p[2], earth)
        sound = LOWEST_ALTITUDE_M <= h <= HIGHEST_ALTITUDE_M
        if not sound and (altitude == altitude or admissible > 0):
            continue
        # A height that is hardly known may come out anywhere; one that is known, nowhere else.
        spread = HEIGHT_SIGMAS * np.sqrt(max(cov[5], 0.0))
        if not LOWEST_ALTITUDE_M - spread <= h <= HIGHEST_ALTITUDE_M + spread:
            outside = 1
            continue
        if sound and admissible == 0:
            found = 0  # what was kept so far lies underground or in space: only good for want of anything better
        admissible += 1 if sound else 0
        near = -1
        for j in range(found):
            gap = 0.0
            for a in range(3):
                gap += (p[a] - position[j, a]) ** 2
            if gap < SAME_SOLUTION_M * SAME_SOLUTION_M:
                near = j
        if near >= 0:
            continue
        slot = found
        if found == 2:
            worse = 1 if cost[1] >= cost[0] else 0
            if value >= cost[worse]:
                continue
            slot = worse
        else:
            found += 1
        for a in range(3):
            position[slot, a] = p[a]
        for k in range(6):
            covariance[slot, k] = cov[k]
        cost[slot] = value
    if found == 2:
        _order(position, covariance, cost, centre, stations, used)
        if cost[1] - cost[0] > RIVAL_COST_GAP:
            found = 1
    return -1 if found == 0 and outside == 1 else found


@kernel
def _order(position, covariance, cost, centre, stations, used):
    """Put the better solution first; of two that fit equally well, the one nearer to the stations that heard it."""
    swap = cost[1] < cost[0]
    if abs(cost[1] - cost[0]) < 1e-3:
        middle = np.zeros(3)
        n = 0
        for s in range(stations.shape[0]):
            if used[s] > 0.0:
                n += 1
                for a in range(3):
                    middle[a] += stations[s, a]
        first = 0.0
        second = 0.0
        for a in range(3):
            first += (position[0, a] - middle[a] / n) ** 2
            second += (position[1, a] - middle[a] / n) ** 2
        swap = second < first
    if swap:
        for a in range(3):
            keep = position[0, a]
            position[0, a] = position[1, a]
            position[1, a] = keep
        for k in range(6):
            keep = covariance[0, k]
            covariance[0, k] = covariance[1, k]
            covariance[1, k] = keep
        keep = cost[0]
        cost[0] = cost[1]
        cost[1] = keep
