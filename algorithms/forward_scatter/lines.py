"""Straight lines through the Dopplers of a window: least squares, Huber's, or by consensus.

The line is kept in centred form: mean time t_c, value f_c there, slope c_1 = S_tf / S_tt; it crosses zero at
tau = t_c - f_c / c_1 (8).

* huber: Theil and Sen's median slope, then reweighting with Huber's k = 1.345;
* consensus: every pair of points proposes a line; the one with the least sum of squared residuals, each capped at 16
  sigma^2, and a falling slope wins; least squares on what lies within 4 sigma, selected again twice.

References
----------
scatter2014, eqs. (7), (8); specification 4 (steps 1-3) and 6.5. Differences from the paper: centred form, missing
values, both robust fits.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import strict

PLAIN, HUBER, CONSENSUS = range(3)
ROBUST = ("none", "huber", "consensus")
# Fewer values than these give no line.
FEWEST_PLAIN = 2
FEWEST_ROBUST = 5
HUBER_K = 1.345
HUBER_ROUNDS = 20
CAP_SIGMA2 = 16.0
INLIER_SIGMA = 4.0
RESELECTIONS = 2
# Of a longer window so many points, evenly spread, propose lines.
MOST_PROPOSERS = 40


@strict
def weighted_line(t, f, weight, count, line):
    """Least squares into line = (t_c, f_c, slope, S_tt, n); False where two different instants are lacking."""
    n = 0.0
    tc = 0.0
    fc = 0.0
    for i in range(count):
        n += weight[i]
        tc += weight[i] * t[i]
        fc += weight[i] * f[i]
    if n <= 0.0:
        return False
    tc /= n
    fc /= n
    stt = 0.0
    stf = 0.0
    for i in range(count):
        d = t[i] - tc
        stt += weight[i] * d * d
        stf += weight[i] * d * (f[i] - fc)
    if stt <= 0.0:
        return False
    line[0] = tc
    line[1] = fc
    line[2] = stf / stt
    line[3] = stt
    line[4] = n
    return True


@strict
def _line_by_huber(t, f, count, sigma, weight, line):
    slopes = np.empty(count * (count - 1) // 2)
    m = 0
    step = max(1, (count + MOST_PROPOSERS - 1) // MOST_PROPOSERS)
    for i in range(0, count, step):
        for j in range(i + step, count, step):
            slopes[m] = (f[j] - f[i]) / (t[j] - t[i])
            m += 1
    slope = np.median(slopes[:m])
    rest = np.empty(count)
    for i in range(count):
        rest[i] = f[i] - slope * t[i]
    at_zero = np.median(rest)
    tc = 0.0
    fc = at_zero
    for _ in range(HUBER_ROUNDS):
        for i in range(count):
            r = abs(f[i] - fc - slope * (t[i] - tc)) / sigma
            weight[i] = 1.0 if r <= HUBER_K else HUBER_K / r
        if not weighted_line(t, f, weight, count, line):
            return False
        moved = abs(line[2] - slope) * np.sqrt(line[3] / line[4]) + abs(line[1] - fc - slope * (line[0] - tc))
        tc = line[0]
        fc = line[1]
        slope = line[2]
        if moved < 1e-9 * sigma:
            break
    return True


@strict
def line_by_consensus(t, f, count, sigma, gate, weight, line):
    """Line on which most points agree; `gate` in Hz takes the place of the 4 sigma, weight (n,) becomes 0 or 1."""
    best = np.inf
    at = 0.0
    slope = 0.0
    base = 0.0
    step = max(1, (count + MOST_PROPOSERS - 1) // MOST_PROPOSERS)
    cap = CAP_SIGMA2 * sigma * sigma * (gate / (INLIER_SIGMA * sigma)) ** 2
    for i in range(0, count, step):
        for j in range(i + step, count, step):
            c = (f[j] - f[i]) / (t[j] - t[i])
            if c >= 0.0:
                continue
            score = 0.0
            for m in range(count):
                r = f[m] - f[i] - c * (t[m] - t[i])
                score += min(r * r, cap)
                if score >= best:
                    break
            if score < best:
                best = score
                at = t[i]
                base = f[i]
                slope = c
    if not np.isfinite(best):
        return False
    for _ in range(RESELECTIONS + 1):
        kept = 0
        for i in range(count):
            inside = abs(f[i] - base - slope * (t[i] - at)) <= gate
            weight[i] = 1.0 if inside else 0.0
            kept += 1 if inside else 0
        if kept < 2 or not weighted_line(t, f, weight, count, line):
            return False
        at = line[0]
        base = line[1]
        slope = line[2]
    return True


@strict
def fit_line(t, f, count, sigma, robust, weight, line):
    """Line through the first `count` values; False where there are too few, or where they lie at one instant."""
    if robust == PLAIN:
        if count < FEWEST_PLAIN:
            return False
        for i in range(count):
            weight[i] = 1.0
        return weighted_line(t, f, weight, count, line)
    if count < FEWEST_ROBUST:
        return False
    if robust == HUBER:
        return _line_by_huber(t, f, count, sigma, weight, line)
    return line_by_consensus(t, f, count, sigma, INLIER_SIGMA * sigma, weight, line)
