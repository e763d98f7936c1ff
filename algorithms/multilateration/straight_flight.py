"""Several marks solved together for one nearly straight flight.

Unknown are theta = (x, vx, ax, y, vy, ay, h, c) at the instant of the last mark: place, velocity and acceleration in
the plane, altitude and climb. The emitter of a mark tau seconds later (tau <= 0) was at

    X = x + vx tau + ax tau^2 / 2,  Y = y + vy tau + ay tau^2 / 2,  z = sqrt((R + h + c tau)^2 - X^2 - Y^2) - R.

The cost is the sum of the squared, whitened range differences of all marks, plus (h - h0)^2 / sigma_h^2,
(c - c0)^2 / sigma_c^2, |v|^2 / (300 m/s)^2 and |acceleration|^2 / (0.5 m/s^2)^2. It has several minima:
Levenberg-Marquardt starts from twelve azimuths and five ranges.

Differences from the specification: acceleration and climb are unknown too, held near zero; without them the fit of
real, never quite straight flights is many claimed sigma wrong without a sign of it in the cost. The sphere of the
site's local radius stands for the ellipsoid (below 43 m of height at 400 km, less than sigma_h). The emission is timed
by the mean time of arrival, whose delay of range / c is common to all marks but for 0.1 m of flight.

References
----------
more1978; specification 5, step 3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.multilateration.fix import HIGHEST_ALTITUDE_M, LOWEST_ALTITUDE_M
from algorithms.multilateration.lanes import Floats, Ints
from algorithms.toolbox.kernels import strict
from algorithms.toolbox.sensors.time_of_arrival import AT_STATION_M

AZIMUTHS = 12
START_RANGES_M = (10e3, 25e3, 50e3, 100e3, 160e3)
STARTS = AZIMUTHS * len(START_RANGES_M)
# Steps of the first pass over all starts; in the second those go on that are within `HOPE` of the best.
FIRST_ITERATIONS = 50
MAX_ITERATIONS = 240
HOPE = 100.0
# An iteration that gains less than this share of 1 + cost has arrived.
ARRIVED_SHARE = 1e-6
# Nobody is farther from the stations than this.
FARTHEST_M = 1e6
# Where the valley is walked, in claimed standard deviations; what share of the parabola's rise is enough at the first;
# how stiffly a place is held, in units of the claim.
VALLEY_SIGMAS = (3.0, 6.0, 12.0)
VALLEY_SHARE = 0.5
PIN_STIFFNESS = 1e4


class Pile(NamedTuple):
    """Marks of one emitter, oldest first, and what is known beforehand; N receptions in all, S stations."""

    tau: Floats
    """(M,) s, emission relative to that of the last mark"""
    first: Ints
    """(M + 1,), where each mark's receptions begin"""
    station: Ints
    """(N,)"""
    arrival: Floats
    """(N,) m, c times the time of arrival, relative to the mark's first reception"""
    stations: Floats
    """(S, 3) m"""
    weight: Floats
    """(S,) 1 / m^2"""
    belief: Floats
    belief_weight: Floats
    """(8,): what is known of theta beforehand, and 1 / variance"""
    earth_m: float
    """m, from the centre of the Earth to the frame's origin"""
    radius_m: float
    """m, from the centre of the Earth to altitude 0"""
    pin: Floats
    """(4,): direction in the plane, place along it in m, weight in 1 / m^2; weight 0 while nothing is held"""
    spread: Floats
    pull: Floats
    """(3, 3) and (3,): room for one mark's share"""


@strict
def normal_equations(theta, pile, info, grad):
    """Fill the packed information (36,) and the gradient (8,) of minus half the cost; return the cost or inf."""
    for k in range(36):
        info[k] = 0.0
    for i in range(8):
        grad[i] = 0.0
    spread = pile.spread
    pull = pile.pull
    cost = 0.0
    stations = pile.stations
    for m in range(pile.tau.shape[0]):
        tau = pile.tau[m]
        half = 0.5 * tau * tau
        px = theta[0] + theta[1] * tau + theta[2] * half
        py = theta[3] + theta[4] * tau + theta[5] * half
        big = pile.radius_m + theta[6] + theta[7] * tau
        inside = big * big - px * px - py * py
        if not (inside > 0.0 and px * px + py * py < FARTHEST_M * FARTHEST_M):
            return np.inf
        root = np.sqrt(inside)
        pz = root - pile.earth_m
        zx = -px / root
        zy = -py / root
        zh = big / root
        # Everything relative to the mark's first reception: sums of small numbers keep their digits.
        f0 = 0.0
        f1 = 0.0
        f2 = 0.0
        fr = 0.0
        sw = 0.0
        se = 0.0
        see = 0.0
        s0 = 0.0
        s1 = 0.0
        s2 = 0.0
        g0 = 0.0
        g1 = 0.0
        g2 = 0.0
        s00 = 0.0
        s10 = 0.0
        s11 = 0.0
        s20 = 0.0
        s21 = 0.0
        s22 = 0.0
        begin = pile.first[m]
        for j in range(begin, pile.first[m + 1]):
            s = pile.station[j]
            dx = px - stations[s, 0]
            dy = py - stations[s, 1]
            dz = pz - stations[s, 2]
            r = np.sqrt(dx * dx + dy * dy + dz * dz)
            per = 1.0 / max(r, AT_STATION_M)
            a0 = (dx + dz * zx) * per
            a1 = (dy + dz * zy) * per
            a2 = dz * zh * per
            w = pile.weight[s]
            sw += w
            if j == begin:
                f0 = a0
                f1 = a1
                f2 = a2
                fr = r
                continue
            e = pile.arrival[j] - (r - fr)
            a0 -= f0
            a1 -= f1
            a2 -= f2
            se += w * e
            see += w * e * e
            s0 += w * a0
            s1 += w * a1
            s2 += w * a2
            g0 += w * e * a0
            g1 += w * e * a1
            g2 += w * e * a2
            s00 += w * a0 * a0
            s10 += w * a1 * a0
            s11 += w * a1 * a1
            s20 += w * a2 * a0
            s21 += w * a2 * a1
            s22 += w * a2 * a2
        mean = se / sw
        cost += see - se * mean
        spread[0, 0] = s00 - s0 * s0 / sw
        spread[1, 0] = s10 - s1 * s0 / sw
        spread[1, 1] = s11 - s1 * s1 / sw
        spread[2, 0] = s20 - s2 * s0 / sw
        spread[2, 1] = s21 - s2 * s1 / sw
        spread[2, 2] = s22 - s2 * s2 / sw
        pull[0] = g0 - s0 * mean
        pull[1] = g1 - s1 * mean
        pull[2] = g2 - s2 * mean
        # theta moves the mark's x, y and h by 1, tau and tau^2 / 2.
        k = 0
        for i in range(8):
            fi = 1.0 if i % 3 == 0 else (tau if i % 3 == 1 else half)
            grad[i] += fi * pull[i // 3]
            for j in range(i + 1):
                fj = 1.0 if j % 3 == 0 else (tau if j % 3 == 1 else half)
                info[k] += fi * fj * spread[i // 3, j // 3]
                k += 1
    for i in range(8):
        w = pile.belief_weight[i]
        off = pile.belief[i] - theta[i]
        info[i * (i + 1) // 2 + i] += w
        grad[i] += w * off
        cost += w * off * off
    ex = pile.pin[0]
    ey = pile.pin[1]
    w = pile.pin[3]
    away = pile.pin[2] - ex * theta[0] - ey * theta[3]
    info[0] += w * ex * ex
    info[6] += w * ex * ey
    info[9] += w * ey * ey
    grad[0] += w * away * ex
    grad[3] += w * away * ey
    return cost + w * away * away


@strict
def _factor(a, out):
    """Cholesky factor of a packed 8 x 8 matrix; False where it is not positive definite."""
    for i in range(8):
        for j in range(i + 1):
            total = a[i * (i + 1) // 2 + j]
            for k in range(j):
                total -= out[i * (i + 1) // 2 + k] * out[j * (j + 1) // 2 + k]
            if i == j:
                if not total > 0.0:
                    return False
                out[i * (i + 1) // 2 + i] = np.sqrt(total)
            else:
                out[i * (i + 1) // 2 + j] = total / out[j * (j + 1) // 2 + j]
    return True


@strict
def _solve(factor, b, out):
    """Solve L L' x = b."""
    for i in range(8):
        total = b[i]
        for k in range(i):
            total -= factor[i * (i + 1) // 2 + k] * out[k]
        out[i] = total / factor[i * (i + 1) // 2 + i]
    for r in range(8):
        i = 7 - r
        total = out[i]
        for k in range(i + 1, 8):
            total -= factor[k * (k + 1) // 2 + i] * out[k]
        out[i] = total / factor[i * (i + 1) // 2 + i]


@strict
def inverse(info, out):
    """Covariance (36,) packed of a packed 8 x 8 information; False where there is none."""
    factor = np.empty(36)
    unit = np.empty(8)
    column = np.empty(8)
    if not _factor(info, factor):
        return False
    for j in range(8):
        for i in range(8):
            unit[i] = 1.0 if i == j else 0.0
        _solve(factor, unit, column)
        for i in range(j, 8):
            out[i * (i + 1) // 2 + j] = column[i]
    return True


@strict
def descend(theta, pile, iterations, room):
    """Levenberg-Marquardt from theta (changed in place), with room (8, 36) to work in; return the cost or inf."""
    info = room[0, :36]
    trial_info = room[1, :36]
    damped = room[2, :36]
    factor = room[3, :36]
    grad = room[4, :8]
    trial_grad = room[5, :8]
    step = room[6, :8]
    trial = room[7, :8]
    cost = normal_equations(theta, pile, info, grad)
    if not np.isfinite(cost):
        return np.inf
    damping = 1e-3
    for _ in range(iterations):
        for k in range(36):
            damped[k] = info[k]
        for i in range(8):
            damped[i * (i + 1) // 2 + i] += damping * info[i * (i + 1) // 2 + i]
        value = np.inf
        if _factor(damped, factor):
            _solve(factor, grad, step)
            for i in range(8):
                trial[i] = theta[i] + step[i]
            value = normal_equations(trial, pile, trial_info, trial_grad)
        if value <= cost:
            gained = cost - value
            cost = value
            for i in range(8):
                theta[i] = trial[i]
                grad[i] = trial_grad[i]
            for k in range(36):
                info[k] = trial_info[k]
            damping = max(damping * 0.1, 1e-9)
            if gained <= ARRIVED_SHARE * (1.0 + cost):
                break
        else:
            damping *= 10.0
            if damping > 1e9:
                break
    return cost


@strict
def search(pile, thetas, costs):
    """Descend from every start; fill thetas (STARTS, 8) and costs (STARTS,), inf where nothing can be flying.

    Return the lowest cost. What does not arrive keeps the cost it has come down to, so it may count as a rival.
    """
    n = pile.station.shape[0]
    cx = 0.0
    cy = 0.0
    for j in range(n):
        cx += pile.stations[pile.station[j], 0] / n
        cy += pile.stations[pile.station[j], 1] / n
    room = np.empty((8, 36))
    i = 0
    for distance in START_RANGES_M:
        for a in range(AZIMUTHS):
            azimuth = 2.0 * np.pi * a / AZIMUTHS
            for k in range(8):
                thetas[i, k] = pile.belief[k]
            thetas[i, 0] = cx + distance * np.sin(azimuth)
            thetas[i, 3] = cy + distance * np.cos(azimuth)
            costs[i] = descend(thetas[i], pile, FIRST_ITERATIONS, room)
            i += 1
    hopeful = np.min(costs) + HOPE
    best = np.inf
    for i in range(STARTS):
        if costs[i] <= hopeful:
            costs[i] = descend(thetas[i], pile, MAX_ITERATIONS, room)
        if not LOWEST_ALTITUDE_M <= thetas[i, 6] <= HIGHEST_ALTITUDE_M:
            costs[i] = np.inf
        best = min(best, costs[i])
    return best


@strict
def valley_is_short(theta, cost, covariance, pile):
    """Whether the cost rises along the longest axis of the claim as the claim says.

    A curved valley can be many times longer than its curvature at the minimum tells. The position is held at 3, 6 and
    12 claimed standard deviations to either side while the rest is fitted; the cost must have risen by 9 or, at 3,
    where a parabola would have risen by 9, by `VALLEY_SHARE` of it.
    """
    xx = covariance[0]
    xy = covariance[6]
    yy = covariance[9]
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    ex = np.cos(angle)
    ey = np.sin(angle)
    sd = np.sqrt(max(ex * ex * xx + 2.0 * ex * ey * xy + ey * ey * yy, 1e-12))
    here = ex * theta[0] + ey * theta[3]
    room = np.empty((8, 36))
    walker = np.empty(8)
    pile.pin[0] = ex
    pile.pin[1] = ey
    pile.pin[3] = PIN_STIFFNESS / (sd * sd)
    short = True
    for side in (-1.0, 1.0):
        for i in range(8):
            walker[i] = theta[i]
        for k in VALLEY_SIGMAS:
            pile.pin[2] = here + side * k * sd
            value = descend(walker, pile, MAX_ITERATIONS, room)
            need = VALLEY_SHARE * k * k if k == VALLEY_SIGMAS[0] else 9.0
            if not value - cost >= need:
                short = False
    pile.pin[3] = 0.0
    return short
