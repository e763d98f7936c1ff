"""The 95 % interval of s by its profile likelihood, and a covariance that knows of its curvature.

The covariance of a fit is that of the tangent plane at the estimate. But Dopplers tell the slope v_y^2 / (s (a - s))
far better than s: what they allow is a long curved ridge. An estimate that came out too near to an end of the base
line claims too little (at ten times the paper's noise s +- 1.96 sd covers 84 to 90 %), and an ellipse along the
tangent misses the ridge (it covers 55 % there, 91 % at the paper's noise). So the ridge is followed: s
is moved, the other unknowns following, until chi2 has risen by 3.84. The signed root r of the rise is nearly normal
whatever the coordinates, so these places are the ends of the interval, and with the estimate they are three nodes of a
quadrature over r ~ N(0, 1): the covariance about the estimate is the weighted mean of (theta(r) - best)
(theta(r) - best)^T plus that of the other unknowns with s held. Where the ridge is straight both are those of the
tangent plane.

The search goes in ln(s / (a - s)), which never leaves the base line, with the slope kept.

References
----------
specification 6.1, 6.4, 8.3; Wilks, S. S. The large-sample distribution of the likelihood ratio for testing composite
hypotheses. Annals of Mathematical Statistics, 1938, vol. 9, pp. 60-62. Differences from the paper: it has no interval.
"""

from __future__ import annotations

import numpy as np

from algorithms.forward_scatter.likelihood import (
    LEAST_DISTANCE_M,
    SCALE,
    cost_at,
    covariance_of,
    normal_equations,
    solve,
)
from algorithms.forward_scatter.motion import UNKNOWNS
from algorithms.toolbox.kernels import strict

NORMAL_95 = 1.959964
MOST_ROUNDS = 20
MOST_PLACES = 12
ENOUGH = 0.01
# Of ln(s / (a - s)) at once, and of one step over the one before.
LARGEST_MOVE = 3.0
FARTHEST_STEP = 3.0
# Share of a bracket that a new place keeps from both its ends.
LEAST_SHARE = 0.1
# Rise of the cost at which one start is not believed: 1.96 is a rise of 1.92, and places are guessed better than this.
DOUBTED = 2.6
# Cost by which a further round would change the end of the interval by less than a hundredth of itself.
SMALL_GAIN = 1e-3


@strict
def cost_with_s_held(f, weight, epochs, p, theta, unknowns, huber, info):
    """Go downhill in all unknowns but s, in place; return the cost. `info` (5, 5) is left as it was near the end."""
    gradient = np.empty(UNKNOWNS)
    lower = np.empty((UNKNOWNS, UNKNOWNS))
    step = np.empty(UNKNOWNS)
    tried = theta.copy()
    damping = 1e-6
    cost = normal_equations(f, weight, epochs, p, theta, unknowns, huber, info, gradient)
    for _ in range(MOST_ROUNDS):
        gradient[1] = 0.0
        for i in range(unknowns):
            if i != 1:
                info[1, i] = 0.0
                info[i, 1] = 0.0
        if not solve(info, gradient, damping, unknowns, lower, step):
            damping = max(10.0 * damping, 1e-6)
            continue
        for i in range(unknowns):
            tried[i] = theta[i] + SCALE[i] * step[i]
        lowered = cost_at(f, weight, epochs, p, tried, unknowns, huber)
        if lowered < cost:
            gain = cost - lowered
            for i in range(unknowns):
                theta[i] = tried[i]
            if gain < SMALL_GAIN:
                return lowered
            cost = normal_equations(f, weight, epochs, p, theta, unknowns, huber, info, gradient)
            damping = max(0.1 * damping, 1e-12)
        elif lowered - cost < SMALL_GAIN or damping > 1e6:
            return cost
        else:
            damping *= 10.0
    return cost


@strict
def _from_elsewhere(f, weight, epochs, p, theta, last, cost, unknowns, huber, info):
    """Try again from the last place within the interval, and with no velocity along; the lowest goes into theta."""
    other = np.empty(UNKNOWNS)
    other_info = np.empty((UNKNOWNS, UNKNOWNS))
    for start in range(2):
        other[:] = last
        other[1] = theta[1]
        other[2] *= np.sqrt(other[1] * (p.a - other[1]) / (last[1] * (p.a - last[1])))
        if start == 1:
            if unknowns < 4:
                break
            other[3] = 0.0
        lowered = cost_with_s_held(f, weight, epochs, p, other, unknowns, huber, other_info)
        if lowered < cost - SMALL_GAIN:
            cost = lowered
            theta[:] = other
            info[:] = other_info
    return cost


@strict
def interval(f, weight, epochs, p, best, begin, covariance, unknowns, huber, ends, spread):
    """Put both ends of the 95 % interval of s into `ends` (2,), and the covariance about `best` (5,) into `spread`.

    `covariance` (5, 5) is that of the tangent plane at the estimate, which may stand at an end of the base line; then
    that end is an end of the interval. `begin` (5,) is where the other unknowns are looked for: the estimate, or a
    start of the scan where the estimate lies on a ridge that leads nowhere.
    """
    least = cost_at(f, weight, epochs, p, best, unknowns, huber)
    info = np.empty((UNKNOWNS, UNKNOWNS))
    nodes = np.empty((2, UNKNOWNS))
    held = np.empty((2, UNKNOWNS, UNKNOWNS))
    roots = np.empty(2)
    theta = best.copy()
    last = best.copy()
    middle = np.log(best[1] / (p.a - best[1]))
    # What one standard deviation is in the logarithm.
    unit = np.sqrt(covariance[1, 1]) * p.a / (best[1] * (p.a - best[1]))
    for side in range(2):
        limit = LEAST_DISTANCE_M if side == 0 else p.a - LEAST_DISTANCE_M
        sign = -1.0 if side == 0 else 1.0
        most = abs(np.log(limit / (p.a - limit)) - middle)
        theta[:] = begin
        last[:] = begin
        near, near_root = 0.0, 0.0
        far, far_root = np.inf, np.inf
        move = min(NORMAL_95 * unit, LARGEST_MOVE)
        root = 0.0
        for place in range(MOST_PLACES):
            move = min(move, most)
            s = limit if move == most else p.a / (1.0 + np.exp(-(middle + sign * move)))
            theta[2] *= np.sqrt(s * (p.a - s) / (theta[1] * (p.a - theta[1])))
            if place == 0 and begin[1] == best[1]:
                for i in range(unknowns):
                    if i == 0 or i > 2:
                        theta[i] += covariance[i, 1] * (s - best[1]) / covariance[1, 1]
            theta[1] = s
            cost = cost_with_s_held(f, weight, epochs, p, theta, unknowns, huber, info)
            if cost - least > DOUBTED:
                cost = _from_elsewhere(f, weight, epochs, p, theta, last, cost, unknowns, huber, info)
            root = np.sqrt(max(2.0 * (cost - least), 0.0))
            if abs(root - NORMAL_95) < ENOUGH or (root < NORMAL_95 and move == most):
                break
            if root < NORMAL_95:
                near, near_root = move, root
                last[:] = theta
            else:
                far, far_root = move, root
            if np.isfinite(far):
                share = (NORMAL_95 - near_root) / (far_root - near_root)
                move = near + (far - near) * min(max(share, LEAST_SHARE), 1.0 - LEAST_SHARE)
            else:
                move *= min(NORMAL_95 / max(root, 0.1), FARTHEST_STEP)
        ends[side] = theta[1]
        nodes[side] = theta
        roots[side] = root
        if not covariance_of(info, unknowns, held[side]):
            # What the tangent plane says of them is better than to claim that they are certain.
            for i in range(unknowns):
                for j in range(unknowns):
                    held[side, i, j] = covariance[i, j] - covariance[i, 1] * covariance[1, j] / covariance[1, 1]
    _about_the_estimate(best, covariance, unknowns, nodes, held, roots, spread)


@strict
def _about_the_estimate(best, covariance, unknowns, nodes, held, roots, spread):
    """Covariance by three nodes of r ~ N(0, 1): at `roots` (2,) below and above the estimate, and 0."""
    # Nodes at -p, 0 and q have mean 0 and variance 1 with these weights; nearer ones, at an end of the base line, not.
    p = max(roots[0], 1.0)
    q = max(roots[1], 1.0)
    weights = (1.0 / (p * (p + q)), 1.0 / (q * (p + q)))
    middle = 1.0 - weights[0] - weights[1]
    for i in range(UNKNOWNS):
        for j in range(UNKNOWNS):
            spread[i, j] = 0.0
    for i in range(unknowns):
        for j in range(unknowns):
            total = middle * (covariance[i, j] - covariance[i, 1] * covariance[1, j] / covariance[1, 1])
            for side in range(2):
                conditional = held[side, i, j] if i != 1 and j != 1 else 0.0
                apart = (nodes[side, i] - best[i]) * (nodes[side, j] - best[j])
                total += weights[side] * (conditional + apart)
            spread[i, j] = total
