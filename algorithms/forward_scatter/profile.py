"""The 95 % interval of s by its profile likelihood: how far s can be moved, the other unknowns following, before chi2
rises by 3.84.

The covariance is that of the tangent plane at the estimate. The error of s grows with its distance from both ends of
the base line, so an estimate that came out too near to one claims too little: at ten times the paper's noise its
s +- 1.96 sd covers 87 to 90 %. The likelihood itself knows of the curvature. Near the estimate both agree, and where
the error is small only the covariance is computed.

References
----------
specification 6.1, 8.3; Wilks, S. S. The large-sample distribution of the likelihood ratio for testing composite
hypotheses. Annals of Mathematical Statistics, 1938, vol. 9, pp. 60-62. Differences from the paper: it has no interval.
"""

from __future__ import annotations

import numpy as np

from algorithms.forward_scatter.likelihood import LEAST_DISTANCE_M, SCALE, cost_at, normal_equations, solve
from algorithms.forward_scatter.motion import UNKNOWNS
from algorithms.toolbox.kernels import strict

NORMAL_95 = 1.959964
# Share of the distance to the nearer end of the base line above which the error of s is seen to be curved.
CURVED = 0.05
MOST_ROUNDS = 20
MOST_PLACES = 8
ENOUGH = 0.01
FARTHEST_STEP = 3.0
# Cost by which a further round would change the end of the interval by less than a hundredth of itself.
SMALL_GAIN = 1e-3


@strict
def cost_with_s_held(f, weight, epochs, p, theta, unknowns, huber):
    """Go downhill in all unknowns but s, in place; return the cost."""
    info = np.empty((UNKNOWNS, UNKNOWNS))
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
def interval(f, weight, epochs, p, best, covariance, unknowns, huber, ends):
    """Put both ends of the 95 % interval of s into `ends` (2,); `covariance` is that of the estimate `best` (5,)."""
    least = cost_at(f, weight, epochs, p, best, unknowns, huber)
    sd = np.sqrt(covariance[1, 1])
    theta = best.copy()
    for side in range(2):
        limit = LEAST_DISTANCE_M if side == 0 else p.a - LEAST_DISTANCE_M
        away = -NORMAL_95 * sd if side == 0 else NORMAL_95 * sd
        theta[:] = best
        near, near_root = best[1], 0.0
        far, far_root = np.nan, np.nan
        s = best[1] + away
        for _ in range(MOST_PLACES):
            s = max(s, limit) if side == 0 else min(s, limit)
            # The others begin where the ridge of the likelihood leads them.
            moved = (s - theta[1]) / covariance[1, 1]
            for i in range(unknowns):
                if i != 1:
                    theta[i] += covariance[i, 1] * moved
            theta[1] = s
            cost = cost_with_s_held(f, weight, epochs, p, theta, unknowns, huber)
            root = np.sqrt(max(2.0 * (cost - least), 0.0))
            if abs(root - NORMAL_95) < ENOUGH:
                break
            if root < NORMAL_95:
                if s == limit:
                    break
                near, near_root = s, root
            else:
                far, far_root = s, root
            if np.isfinite(far):
                s = near + (far - near) * (NORMAL_95 - near_root) / (far_root - near_root)
            else:
                s = best[1] + (s - best[1]) * min(NORMAL_95 / max(root, 0.1), FARTHEST_STEP)
        ends[side] = s
