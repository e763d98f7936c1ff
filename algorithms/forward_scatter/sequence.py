"""The paper's algorithm, epoch by epoch: a line for each receiver, crossing times, angular velocity, position.

One trial after another, each by itself, so that its bytes depend on nothing else. The window is the last N epochs of
the pass; missing values in it are skipped.

References
----------
scatter2014, eqs. (3)-(19); specification 4. Differences from the paper: lines in centred form, rules of freezing,
confirmation, robust lines, predicted errors (also between a kept crossing and windows that share values with its
own), formulas (18), (19) and the curvature correction by choice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.forward_scatter.closed_form import distance, errors_of_answer
from algorithms.forward_scatter.freeze import (
    CONFIRMED,
    FROZEN,
    HAS,
    KEPT_VARIANCE,
    MEMORY,
    NEVER,
    RULE_C,
    crossing,
    forget,
)
from algorithms.forward_scatter.lines import FEWEST_PLAIN, FEWEST_ROBUST, INLIER_SIGMA, PLAIN, fit_line
from algorithms.toolbox.kernels import strict

# What became of an epoch.
NO_DATA, NO_LINE, NO_CROSSING, INVALID, EXTRAPOLATED, CROSSED = range(6)

LINES, MEAN_DIFFERENCE, MEAN_OF_ALL = range(3)
# (omega (t_c - tau))^2 is not believed beyond this in the curvature correction.
LARGEST_CURVATURE = 0.25
CURVATURE_ROUNDS = 3


class Options(NamedTuple):
    """What the closed form is told, in SI units."""

    window: int
    rule: int
    delay: int
    confirm: int
    formula: int
    omega: int
    robust: int
    curvature: bool
    from_start: bool
    """Whether (17) counts its times from the pass's first instant, as printed, not from the window's centre."""
    sigma: float
    sigma_rate: float
    """Of a measured frequency rate, Hz/s; 0 = it takes the slope's place."""
    a: float
    b: float
    wavelength: float


class Answers(NamedTuple):
    """What comes out: K epochs, two receivers (lower, upper), L trials. NaN = none."""

    status: np.ndarray
    line: np.ndarray
    """(K, 2, 6, L): t_c s, f_c Hz, slope Hz/s, S_tt s2, values used, zero s."""
    tau: np.ndarray
    """(K, 2, L) s: the crossing times that were used."""
    frozen: np.ndarray
    omega: np.ndarray
    """(K, L) rad/s."""
    difference: np.ndarray
    """(K, L) Hz: f1 - f2."""
    theta: np.ndarray
    """(K, 3, L): tau, s, v_y; s and v_y also where the status is invalid."""
    covariance: np.ndarray
    """(K, 3, 3, L) of them."""
    agrees: np.ndarray
    """(K, 2, L): whether the epoch's own value lies on its line; always where lines are not robust."""


def answers(epochs: int, lanes: int) -> Answers:
    """Room for the answers, filled with nothing."""
    nan = np.nan
    return Answers(
        status=np.zeros((epochs, lanes), np.int64),
        line=np.full((epochs, 2, 6, lanes), nan),
        tau=np.full((epochs, 2, lanes), nan),
        frozen=np.zeros((epochs, 2, lanes), np.bool_),
        omega=np.full((epochs, lanes), nan),
        difference=np.full((epochs, lanes), nan),
        theta=np.full((epochs, 3, lanes), nan),
        covariance=np.full((epochs, 3, 3, lanes), nan),
        agrees=np.ones((epochs, 2, lanes), np.bool_),
    )


@strict
def mean_rate(rate, k, j, lane, window):
    """Mean of the measured rates in the window and their number."""
    total = 0.0
    n = 0
    for i in range(max(0, k - window + 1), k + 1):
        if np.isfinite(rate[i, j, lane]):
            total += rate[i, j, lane]
            n += 1
    return total / max(n, 1), n


@strict
def slope_with_rate(slope, stt, rate, n, sigma, sigma_rate):
    """Slope and its variance where rates were measured as well: weighted, or the rate alone where sigma_rate is 0."""
    variance = sigma * sigma / stt
    if n == 0:
        return slope, variance
    if sigma_rate <= 0.0:
        return rate, variance
    of_rate = sigma_rate * sigma_rate / n
    weight = variance / (variance + of_rate)
    return slope + weight * (rate - slope), variance * of_rate / (variance + of_rate)


@strict
def add_pair(t, difference, together):
    """Add a pair to `together` = (pairs, their times, their differences); one that lacks a half adds nothing."""
    if np.isfinite(difference):
        together[0] += 1.0
        together[1] += t
        together[2] += difference


@strict
def shared_errors(time, f, j, lane, now, then, o, lines, pairs, shared):
    """Covariances of what receiver j's line was made of `then` and is `now`, because windows share values.

    Into `shared` (4,): mean with mean, mean with slope, slope with mean, slope with slope; then before now. The mean
    now is that of the difference of the Dopplers, of `pairs` values.
    """
    variance = o.sigma * o.sigma
    shared[:] = 0.0
    tc, n = lines[then, j, 0, lane], lines[then, j, 4, lane]
    for i in range(max(0, now - o.window + 1), then + 1):
        if np.isfinite(f[i, j, lane]):
            before = time[i] - tc
            after = time[i] - lines[now, j, 0, lane]
            shared[0] += variance / (n * pairs)
            shared[1] += variance * after / (n * lines[now, j, 3, lane])
            shared[2] += variance * before / (lines[then, j, 3, lane] * pairs)
            shared[3] += variance * before * after / (lines[then, j, 3, lane] * lines[now, j, 3, lane])
    if o.omega == MEAN_OF_ALL:
        # All of the values then are among those now, and their slope is nothing to their mean.
        shared[0] = variance / pairs
        shared[2] = 0.0


@strict
def follow(time, f, rate, o, out):
    """Go through a pass: time (K,) s, f and rate (K, 2, L) of the lower and the upper receiver."""
    epochs, _, lanes = f.shape
    memory = np.empty((2, MEMORY))
    t = np.empty(o.window)
    v = np.empty(o.window)
    weight = np.empty(o.window)
    line = np.empty(5)
    raw = np.empty(2)
    variance = np.empty(2)
    fresh = np.empty(2, np.bool_)
    slope = np.empty(2)
    slope_variance = np.empty(2)
    covariance = np.empty((5, 5))
    value = np.empty(5)
    shared = np.empty(4)
    kept_at = np.zeros(2, np.int64)
    held = np.zeros(2, np.bool_)
    answer = np.empty((3, 3))
    found = np.empty(2)
    together = np.empty(3)
    fewest = FEWEST_PLAIN if o.robust == PLAIN else FEWEST_ROBUST
    for lane in range(lanes):
        forget(memory)
        raw[:] = np.nan
        variance[:] = np.nan
        together[:] = 0.0
        held[:] = False
        for k in range(epochs):
            have = True
            enough = True
            if o.omega == MEAN_OF_ALL:
                add_pair(time[k], f[k, 0, lane] - f[k, 1, lane], together)
            for j in range(2):
                count = 0
                for i in range(max(0, k - o.window + 1), k + 1):
                    if np.isfinite(f[i, j, lane]):
                        t[count] = time[i]
                        v[count] = f[i, j, lane]
                        count += 1
                fresh[j] = False
                enough = enough and count >= fewest
                if not fit_line(t, v, count, o.sigma, o.robust, weight, line):
                    have = False
                    continue
                if np.isfinite(f[k, j, lane]) and o.robust != PLAIN:
                    rest = f[k, j, lane] - line[1] - line[2] * (time[k] - line[0])
                    out.agrees[k, j, lane] = abs(rest) <= INLIER_SIGMA * o.sigma
                for i in range(5):
                    out.line[k, j, i, lane] = line[i]
                measured, n = mean_rate(rate, k, j, lane, o.window)
                slope[j], slope_variance[j] = slope_with_rate(line[2], line[3], measured, n, o.sigma, o.sigma_rate)
                if line[2] < 0.0:
                    fresh[j] = True
                    raw[j] = line[0] - line[1] / line[2]
                    out.line[k, j, 5, lane] = raw[j]
            if have:
                mean_slope = 0.5 * (out.line[k, 0, 2, lane] + out.line[k, 1, 2, lane])
                for j in range(2):
                    if fresh[j]:
                        back = raw[j] - out.line[k, j, 0, lane]
                        per = 1.0 / out.line[k, j, 4, lane] + back * back / out.line[k, j, 3, lane]
                        variance[j] = (o.sigma / mean_slope) ** 2 * per
            both = fresh[0] and fresh[1] and raw[0] <= time[k] and raw[1] <= time[k]
            for j in range(2):
                crossed = both if o.rule == RULE_C else raw[j] <= time[k]
                kept = crossing(memory, j, raw[j], variance[j], fresh[j], crossed, o.rule, o.delay, o.confirm)
                out.tau[k, j, lane] = kept
                out.frozen[k, j, lane] = memory[j, FROZEN] > 0.0
                if memory[j, HAS] == 0.0 or not held[j]:
                    kept_at[j] = k
                held[j] = memory[j, HAS] > 0.0
            if not have:
                out.status[k, lane] = NO_LINE if enough or k > 0 else NO_DATA
                continue
            tau1 = out.tau[k, 0, lane]
            tau2 = out.tau[k, 1, lane]
            centre = 0.5 * (out.line[k, 0, 0, lane] + out.line[k, 1, 0, lane])
            middle = centre
            pairs = 0.5 * (out.line[k, 0, 4, lane] + out.line[k, 1, 4, lane])
            df = 0.0
            if o.omega == LINES:
                for j in range(2):
                    sign = 1.0 if j == 0 else -1.0
                    at = centre - out.line[k, j, 0, lane]
                    df += sign * (out.line[k, j, 1, lane] + out.line[k, j, 2, lane] * at)
            else:
                if o.omega == MEAN_DIFFERENCE:
                    together[:] = 0.0
                    for i in range(max(0, k - o.window + 1), k + 1):
                        add_pair(time[i], f[i, 0, lane] - f[i, 1, lane], together)
                # The difference is that at the pairs' own mean time; the curvature correction must know it.
                pairs = max(together[0], 1.0)
                df = together[2] / together[0] if together[0] > 0.0 else np.nan
                middle = together[1] / pairs
            out.difference[k, lane] = df
            omega = -(o.wavelength / o.b) * df
            tau = 0.5 * (tau1 + tau2)
            if o.curvature:
                plain = omega
                for _ in range(CURVATURE_ROUNDS):
                    omega = plain * (1.0 + min((omega * (middle - tau)) ** 2, LARGEST_CURVATURE)) ** 1.5
            if not np.isfinite(tau) or not np.isfinite(omega):
                out.omega[k, lane] = omega
                out.status[k, lane] = NO_CROSSING
                continue
            origin = time[0] if o.from_start else centre
            distance(o.formula, tau1, tau2, omega, slope[0], slope[1], origin, o.a, o.b, o.wavelength, found)
            s = found[0]
            out.omega[k, lane] = found[1]
            out.theta[k, 0, lane] = tau
            out.theta[k, 1, lane] = s
            out.theta[k, 2, lane] = found[1] * s
            if not (s > 0.0 and s < o.a):
                out.status[k, lane] = INVALID
                continue
            seen = True
            for j in range(2):
                seen = seen and (memory[j, CONFIRMED] > 0.0 if o.rule != NEVER else tau1 <= time[k] and tau2 <= time[k])
            out.status[k, lane] = CROSSED if seen else EXTRAPOLATED
            # Errors of tau_1, tau_2, omega and both slopes.
            gamma = 0.5 * (slope[0] + slope[1])
            per_omega = -o.wavelength / o.b
            covariance[:] = 0.0
            for j in range(2):
                covariance[j, j] = memory[j, KEPT_VARIANCE] if memory[j, FROZEN] > 0.0 else variance[j]
                covariance[3 + j, 3 + j] = slope_variance[j]
                if gamma < 0.0:
                    kept = kept_at[j] if memory[j, HAS] > 0.0 else k
                    shared_errors(time, f, j, lane, k, kept, o, out.line, pairs, shared)
                    share = slope_variance[j] * out.line[k, j, 3, lane] / (o.sigma * o.sigma)
                    back = out.tau[k, j, lane] - out.line[kept, j, 0, lane]
                    sign = 1.0 if j == 0 else -1.0
                    covariance[j, 2] = -sign * per_omega * (shared[0] + back * shared[2]) / gamma
                    covariance[j, 3 + j] = -share * (shared[1] + back * shared[3]) / gamma
                    covariance[2, j] = covariance[j, 2]
                    covariance[3 + j, j] = covariance[j, 3 + j]
            covariance[2, 2] = 2.0 * per_omega * per_omega * o.sigma * o.sigma / pairs
            value[0] = tau1
            value[1] = tau2
            value[2] = omega
            value[3] = slope[0]
            value[4] = slope[1]
            errors_of_answer(o.formula, value, covariance, origin, o.a, o.b, o.wavelength, answer)
            for p in range(3):
                for q in range(3):
                    out.covariance[k, p, q, lane] = answer[p, q]
