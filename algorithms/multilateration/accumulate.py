"""A start from several marks where none of them is enough: what is kept, when it is tried, what is accepted.

A lane without a track keeps its last marks (specification 5, step 3). Fitting them takes a millisecond, so it is not
done at every mark: again after half as many more; once the pile is full, after half a pile, then after twice as many
each time; at once where a station joins that was not heard before.

The fit is accepted only if

- more than two stations are heard: one hyperbola tells no place along it;
- its cost passes the chi-square test, otherwise the flight was not straight, or a reception is wrong: the older half
  of the marks goes;
- the claimed horizontal error is below 20 % of the range, and the valley of the cost is no longer than claimed;
- no other minimum has a cost within 9.

References
----------
Specification 5, step 3.
"""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.lanes import (
    CLAIM_SHARE_OF_RANGE,
    R_NO_SOLUTION,
    R_NONE,
    R_NOT_STRAIGHT,
    R_POOR,
    R_SAME_PAIR,
    R_SEVERAL,
    R_TOO_FEW,
    RIVAL_COST_GAP,
    START_VELOCITY_SD_MPS,
    STRAIGHT_ACCELERATION_SD_MPS2,
)
from algorithms.multilateration.straight_flight import (
    STARTS,
    Pile,
    inverse,
    normal_equations,
    search,
    valley_is_short,
)
from algorithms.toolbox.kernels import strict
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

# Fewer marks or range differences than these leave nothing to test the fit with: four numbers are unknown.
FEWEST_MARKS = 5
FEWEST_ROWS = 6
# After a failure half as many marks again are awaited.
GROWTH = 2
MOST_DOUBLINGS = 4
NEVER = 1 << 40
# Climb or descent that is expected where no altitude tells.
CLIMB_SD_MPS = 7.0
# Two minima are one where they are nearer than this, or within three claimed sigma.
SAME_MINIMUM_M = 30.0
SAME_MINIMUM_SIGMA2 = 9.0
# Normal quantile of probability 0.999.
Z_999 = 3.0902


@strict
def forget(lane, track):
    """Empty a lane's pile."""
    g = track.gathered
    g.kept[lane] = 0
    g.error[lane] = np.nan


@strict
def _keep_from(lane, begin, g):
    """Drop the oldest `begin` marks of a pile."""
    for m in range(begin, g.kept[lane]):
        g.gate[lane, m - begin] = g.gate[lane, m]
        g.altitude[lane, m - begin] = g.altitude[lane, m]
        for s in range(g.toa.shape[2]):
            g.toa[lane, m - begin, s] = g.toa[lane, m, s]
    g.kept[lane] -= begin


@strict
def remember(lane, gate, setup, track, now):
    """Put the mark at hand on the lane's pile; what is too old or too much leaves it."""
    g = track.gathered
    begin = 0
    while begin < g.kept[lane] and gate - g.gate[lane, begin] > setup.gather_time_s:
        begin += 1
    if g.kept[lane] - begin == g.gate.shape[1]:
        begin += 1
    if begin > 0:
        _keep_from(lane, begin, g)
    m = g.kept[lane]
    if m == 0:
        g.due[lane] = 0
        g.failures[lane] = 0
        g.heard[lane] = 0
        g.why[lane] = R_TOO_FEW
        g.error[lane] = np.nan
    g.gate[lane, m] = gate
    # What stands in for a decoded altitude is no better than what the fit believes anyway.
    decoded = now.has_altitude[lane] > 0.0 and now.altitude_extra[lane] == 0.0
    g.altitude[lane, m] = now.altitude[lane] if decoded else np.nan
    for s in range(g.toa.shape[2]):
        g.toa[lane, m, s] = now.toa[s, lane] if now.used[s, lane] > 0.0 else np.nan
    g.kept[lane] = m + 1
    g.due[lane] -= 1


@strict
def try_together(lane, setup, track, theta, covariance):
    """Fit the lane's pile where that is due: R_NONE with theta (8,) and covariance (36,) filled, or why not."""
    g = track.gathered
    count = g.kept[lane]
    receptions = 0
    heard = 0
    for s in range(g.toa.shape[2]):
        before = receptions
        for m in range(count):
            receptions += 1 if np.isfinite(g.toa[lane, m, s]) else 0
        heard += 1 if receptions > before else 0
    if count < FEWEST_MARKS or receptions - count < FEWEST_ROWS:
        return g.why[lane]
    if g.due[lane] > 0 and heard <= g.heard[lane]:
        return g.why[lane]
    why = _fit(_pile_of(lane, receptions, setup, g), heard, setup, theta, covariance, g, lane)
    g.why[lane] = why
    g.heard[lane] = max(heard, g.heard[lane])
    full = g.gate.shape[1]
    if why == R_NOT_STRAIGHT:
        _keep_from(lane, count // 2, g)
        g.due[lane] = max(2, g.kept[lane] // GROWTH)
    elif count < full:
        g.due[lane] = full - count if why == R_SAME_PAIR else max(2, count // GROWTH)
    elif why == R_SAME_PAIR:
        g.due[lane] = NEVER
    else:
        g.due[lane] = max(2, full // 2) << min(g.failures[lane], MOST_DOUBLINGS)
        g.failures[lane] += 1
    return why


@strict
def _pile_of(lane, receptions, setup, g):
    """Copy a lane's marks close together."""
    count = g.kept[lane]
    tau = np.empty(count)
    first = np.zeros(count + 1, np.int64)
    station = np.empty(receptions, np.int64)
    arrival = np.empty(receptions)
    filled = 0
    for m in range(count):
        mean = 0.0
        for s in range(g.toa.shape[2]):
            value = g.toa[lane, m, s]
            if np.isfinite(value):
                station[filled] = s
                arrival[filled] = value
                mean += value
                filled += 1
        begin = first[m]
        mean /= filled - begin
        reference = arrival[begin]
        for j in range(begin, filled):
            arrival[j] -= reference
        first[m + 1] = filled
        tau[m] = g.gate[lane, m] - g.gate[lane, count - 1] + mean / SPEED_OF_LIGHT_MPS
    last = tau[count - 1]
    n = 0
    mean_tau = 0.0
    mean_altitude = 0.0
    for m in range(count):
        tau[m] -= last
        if np.isfinite(g.altitude[lane, m]):
            n += 1
            mean_tau += tau[m]
            mean_altitude += g.altitude[lane, m]
    altitude = setup.gather_altitude
    variance = setup.gather_altitude_variance
    climb = 0.0
    climb_variance = CLIMB_SD_MPS * CLIMB_SD_MPS
    if n > 0:
        mean_tau /= n
        mean_altitude /= n
        cross = 0.0
        square = setup.altitude_variance / climb_variance
        for m in range(count):
            if np.isfinite(g.altitude[lane, m]):
                cross += (tau[m] - mean_tau) * (g.altitude[lane, m] - mean_altitude)
                square += (tau[m] - mean_tau) ** 2
        climb = cross / square
        climb_variance = setup.altitude_variance / square
        # An altitude's error is common to all marks (pressure, geoid), so many of them are worth no more than one.
        altitude = mean_altitude - climb * mean_tau
        variance = setup.altitude_variance
    weight = np.empty(setup.stations.shape[0])
    for s in range(weight.shape[0]):
        weight[s] = 1.0 / setup.variance[s]
    belief = np.zeros(8)
    belief_weight = np.zeros(8)
    for a in range(2):
        belief_weight[3 * a + 1] = 1.0 / START_VELOCITY_SD_MPS**2
        belief_weight[3 * a + 2] = 1.0 / STRAIGHT_ACCELERATION_SD_MPS2**2
    belief[6] = altitude
    belief_weight[6] = 1.0 / variance
    belief[7] = climb
    belief_weight[7] = 1.0 / climb_variance
    return Pile(
        tau,
        first,
        station,
        arrival,
        setup.stations,
        weight,
        belief,
        belief_weight,
        -setup.earth_centre[2],
        setup.earth_radius,
        np.zeros(4),
        np.zeros((3, 3)),
        np.zeros(3),
    )


@strict
def _fit(pile, heard, setup, theta, covariance, g, lane):
    """Search the minima and judge the lowest; its claimed error into the pile."""
    thetas = np.empty((STARTS, 8))
    costs = np.empty(STARTS)
    g.error[lane] = np.nan
    cost = search(pile, thetas, costs)
    if not np.isfinite(cost):
        return R_NO_SOLUTION
    best = np.argmin(costs)
    info = np.empty(36)
    grad = np.empty(8)
    for i in range(8):
        theta[i] = thetas[best, i]
    normal_equations(theta, pile, info, grad)
    if not inverse(info, covariance):
        return R_NO_SOLUTION
    drms2 = covariance[0] + covariance[9]
    g.error[lane] = np.sqrt(drms2)
    if heard < 3:
        return R_SAME_PAIR
    rows = pile.station.shape[0] - pile.tau.shape[0]
    dof = max(rows - 4, 1)
    spread = 2.0 / (9.0 * dof)
    if cost > dof * (1.0 - spread + Z_999 * np.sqrt(spread)) ** 3:  # Wilson and Hilferty's quantile
        g.error[lane] = np.nan
        return R_NOT_STRAIGHT
    far2 = setup.radius_of_site**2
    far2 = max(far2, (theta[0] - setup.middle[0]) ** 2 + (theta[3] - setup.middle[1]) ** 2)
    if not drms2 < CLAIM_SHARE_OF_RANGE**2 * far2:
        return R_POOR
    determinant = covariance[0] * covariance[9] - covariance[6] * covariance[6]
    for i in range(STARTS):
        if costs[i] - cost > RIVAL_COST_GAP:
            continue
        dx = thetas[i, 0] - theta[0]
        dy = thetas[i, 3] - theta[3]
        d2 = (covariance[9] * dx * dx - 2.0 * covariance[6] * dx * dy + covariance[0] * dy * dy) / determinant
        if d2 > SAME_MINIMUM_SIGMA2 and dx * dx + dy * dy > SAME_MINIMUM_M * SAME_MINIMUM_M:
            return R_SEVERAL
    if not valley_is_short(theta, cost, covariance, pile):
        return R_POOR
    return R_NONE
