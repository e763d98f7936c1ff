"""The likelihood fitted at every epoch of a pass: starts, the switch to an acceleration, false values.

The robust chain (6.5): a line by consensus over the whole record with a gate of 15 sigma, room for the curvature; then
Huber's cost; then what lies beyond 4 sigma is dropped; then plain likelihood.

References
----------
specification 6.1, 6.2, 6.5. Differences from the paper: it has no such estimator.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.forward_scatter.likelihood import (
    LEAST_DISTANCE_M,
    SCALE,
    covariance_of,
    minimise,
    normal_equations,
    scan,
    solve,
)
from algorithms.forward_scatter.lines import CONSENSUS, HUBER, INLIER_SIGMA, PLAIN, line_by_consensus
from algorithms.forward_scatter.motion import UNKNOWNS, model
from algorithms.forward_scatter.profile import interval
from algorithms.toolbox.kernels import strict

# What became of an epoch.
NO_DATA, NO_FALL, NOT_CONVERGED, AT_BOUND, FITTED = range(5)

SWITCH = -1
"""As the number of unknowns: four, and a fifth where it lowers the cost by more than `SWITCH_GAIN`."""
SWITCH_GAIN = 4.0
# The fifth is not even tried where one Gauss step promises less than this.
WORTH_TRYING = 2.0
GATE_SIGMA = 15.0
# All starts are tried again at each of the first pairs, then every so many.
FIRST_PAIRS = 12
RESCAN_EVERY = 4


class Fits(NamedTuple):
    """What comes out: K epochs, C channels, L trials."""

    status: np.ndarray
    theta: np.ndarray
    """(K, 5, L)."""
    covariance: np.ndarray
    """(K, 5, 5, L): of the tangent plane at theta."""
    spread: np.ndarray
    """(K, 5, 5, L): about theta along the curved ridge of the likelihood, of fits that ended."""
    unknowns: np.ndarray
    """(K, L): 3, 4 or 5 that were fitted."""
    chi2: np.ndarray
    dof: np.ndarray
    used: np.ndarray
    """(C, K, L): which Dopplers the last fit used."""
    ends: np.ndarray
    """(K, 2, L) m: 95 % interval of s by the likelihood, of fits that ended."""
    open_variance: np.ndarray
    """(K, L) m2: of s were an acceleration unknown too, where the switch did not take it; of the tangent plane."""


def fits(epochs: int, channels: int, lanes: int) -> Fits:
    """Room for the fits, filled with nothing."""
    return Fits(
        status=np.zeros((epochs, lanes), np.int64),
        theta=np.full((epochs, UNKNOWNS, lanes), np.nan),
        covariance=np.full((epochs, UNKNOWNS, UNKNOWNS, lanes), np.nan),
        spread=np.full((epochs, UNKNOWNS, UNKNOWNS, lanes), np.nan),
        unknowns=np.zeros((epochs, lanes), np.int64),
        chi2=np.full((epochs, lanes), np.nan),
        dof=np.zeros((epochs, lanes), np.int64),
        used=np.zeros((channels, epochs, lanes), np.bool_),
        ends=np.full((epochs, 2, lanes), np.nan),
        open_variance=np.full((epochs, lanes), np.nan),
    )


@strict
def _best_start(f, weight, epochs, p, unknowns, huber, warm, theta, info, gradient):
    """Minimise from the last answer (where `warm`) and from the scan; the lower cost wins."""
    cost = np.inf
    ended = False
    if warm:
        cost, ended = minimise(f, weight, epochs, p, theta, unknowns, huber, info, gradient)
        if epochs > FIRST_PAIRS and epochs % RESCAN_EVERY != 0:
            return cost, ended, True
    other = np.empty(UNKNOWNS)
    if not scan(f, weight, epochs, p, other):
        return cost, ended, warm
    other_info = np.empty((UNKNOWNS, UNKNOWNS))
    other_gradient = np.empty(UNKNOWNS)
    lowered, other_ended = minimise(f, weight, epochs, p, other, unknowns, huber, other_info, other_gradient)
    if not lowered >= cost:
        theta[:] = other
        info[:] = other_info
        gradient[:] = other_gradient
        return lowered, other_ended, True
    return cost, ended, warm


@strict
def _try_acceleration(f, weight, epochs, p, huber, cost, theta, info, gradient, work, lower):
    """Fit a_y as well where it pays; return the cost and whether theta now has it."""
    accelerated = theta.copy()
    accelerated[4] = 0.0
    now = normal_equations(f, weight, epochs, p, accelerated, 5, huber, work, gradient)
    step = np.empty(UNKNOWNS)
    if not solve(work, gradient, 0.0, 5, lower, step):
        return cost, False
    promised = 0.0
    for i in range(UNKNOWNS):
        promised += 0.5 * step[i] * gradient[i]
    if promised < WORTH_TRYING:
        return cost, False
    lowered, ended = minimise(f, weight, epochs, p, accelerated, 5, huber, work, gradient)
    if ended and lowered < now - SWITCH_GAIN:
        theta[:] = accelerated
        info[:] = work
        return lowered, True
    return cost, False


@strict
def _agreeing(f, weight, epochs, p, gate, t, v, w, index, line):
    """Give weight 0 to what lies off the line on which most of a channel agree."""
    for c in range(f.shape[0]):
        count = 0
        for k in range(epochs):
            if weight[c, k] > 0.0:
                t[count] = p.time[k]
                v[count] = f[c, k]
                index[count] = k
                count += 1
        if count >= 3 and line_by_consensus(t, v, count, p.sigma, gate, w, line):
            for i in range(count):
                weight[c, index[i]] = w[i]


@strict
def fit_pass(f, p, begin, stop, unknowns, robust, carried, out):
    """Fit the epochs begin <= k < stop of a pass; f (C, K, L); `carried` (L, 6) is the last answer and whether any."""
    channels, total, lanes = f.shape
    own = np.empty((channels, total))
    weight = np.empty((channels, total))
    theta = np.empty(UNKNOWNS)
    start = np.empty(UNKNOWNS)
    begin_at = np.empty(UNKNOWNS)
    info = np.empty((UNKNOWNS, UNKNOWNS))
    work = np.empty((UNKNOWNS, UNKNOWNS))
    lower = np.empty((UNKNOWNS, UNKNOWNS))
    covariance = np.empty((UNKNOWNS, UNKNOWNS))
    spread = np.empty((UNKNOWNS, UNKNOWNS))
    gradient = np.empty(UNKNOWNS)
    t = np.empty(total)
    v = np.empty(total)
    w = np.empty(total)
    index = np.empty(total, np.int64)
    line = np.empty(5)
    ends = np.empty(2)
    least = 4 if unknowns == SWITCH else unknowns
    for lane in range(lanes):
        for c in range(channels):
            for k in range(total):
                own[c, k] = f[c, k, lane]
        for k in range(begin, stop):
            epochs = k + 1
            measured = 0
            for c in range(channels):
                for i in range(epochs):
                    there = np.isfinite(own[c, i])
                    weight[c, i] = 1.0 if there else 0.0
                    measured += 1 if there else 0
            if measured < least:
                continue
            for i in range(UNKNOWNS):
                theta[i] = carried[lane, i]
            if unknowns < 5:
                theta[4] = 0.0
            if unknowns == 3:
                theta[3] = 0.0
            warm = carried[lane, 5] > 0.0
            if robust != PLAIN and measured > least + 2:
                if robust == CONSENSUS:
                    _agreeing(own, weight, epochs, p, GATE_SIGMA * p.sigma, t, v, w, index, line)
                _, _, found = _best_start(own, weight, epochs, p, least, True, warm, theta, info, gradient)
                if found and robust == HUBER:
                    cost, ended = minimise(own, weight, epochs, p, theta, least, True, info, gradient)
                elif found:
                    for c in range(channels):
                        for i in range(epochs):
                            r = own[c, i] - model(p.time[i], theta, p.altitude, p.feet[c], p.wavelength)
                            weight[c, i] = 1.0 if abs(r) <= INLIER_SIGMA * p.sigma else 0.0
                    cost, ended = minimise(own, weight, epochs, p, theta, least, False, info, gradient)
            else:
                cost, ended, found = _best_start(own, weight, epochs, p, least, False, warm, theta, info, gradient)
            if not found:
                out.status[k, lane] = NO_FALL
                continue
            fitted = least
            huber = robust == HUBER
            # The next epoch starts from what four unknowns gave: an acceleration is believed anew each time.
            start[:] = theta
            if unknowns == SWITCH:
                cost, switched = _try_acceleration(
                    own, weight, epochs, p, huber, cost, theta, info, gradient, work, lower
                )
                fitted = 5 if switched else 4
                if not switched and covariance_of(work, 5, covariance):
                    out.open_variance[k, lane] = covariance[1, 1]
            for i in range(UNKNOWNS):
                carried[lane, i] = start[i]
            carried[lane, 5] = 1.0
            chi2 = 0.0
            used = 0
            for c in range(channels):
                for i in range(epochs):
                    if weight[c, i] > 0.0:
                        r = own[c, i] - model(p.time[i], theta, p.altitude, p.feet[c], p.wavelength)
                        chi2 += (r / p.sigma) ** 2
                        used += 1
            for i in range(UNKNOWNS):
                out.theta[k, i, lane] = theta[i]
            out.unknowns[k, lane] = fitted
            out.chi2[k, lane] = chi2
            out.dof[k, lane] = max(used - fitted, 0)
            at_bound = theta[1] <= LEAST_DISTANCE_M or theta[1] >= p.a - LEAST_DISTANCE_M
            known = used >= fitted and covariance_of(info, fitted, covariance)
            if not ended or not known:
                out.status[k, lane] = NOT_CONVERGED
            else:
                out.status[k, lane] = AT_BOUND if at_bound else FITTED
            if known:
                begin_at[:] = theta
                if (at_bound or not ended) and scan(own, weight, epochs, p, begin_at) and fitted == 5:
                    begin_at[4] = theta[4]
                interval(own, weight, epochs, p, theta, begin_at, covariance, fitted, huber, ends, spread)
                out.ends[k, 0, lane] = ends[0]
                out.ends[k, 1, lane] = ends[1]
                for i in range(UNKNOWNS):
                    for j in range(UNKNOWNS):
                        out.spread[k, i, j, lane] = spread[i, j]
                        out.covariance[k, i, j, lane] = covariance[i, j]
            if k == stop - 1:
                for c in range(channels):
                    for i in range(epochs):
                        out.used[c, i, lane] = weight[c, i] > 0.0


assert len(SCALE) == UNKNOWNS
