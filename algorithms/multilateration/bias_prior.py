"""What is thought of the altitude's bias before any data: mostly small, now and then several times as large.

A normal prior as wide as a rare bias asks for (300 m) costs accuracy where there is none; one that costs little lets a
rare bias through. The prior here is a mixture of two normals,

    b ~ 6/7 N(0, sigma_b^2 / 2) + 1/7 N(0, 4 sigma_b^2),

whose variance is sigma_b^2, so the filter itself runs with N(0, sigma_b^2) and what is shown is taken over to the
mixture exactly. With b and v the filter's bias and its variance, c its covariance with the state, and one component
s_j^2 in place of sigma_b^2 (a measurement of zero whose variance may be negative):

    1 / R_j = 1 / s_j^2 - 1 / sigma_b^2,   g_j = 1 / (v + R_j)
    x_j = x - c g_j b,   P_j = P - c c' g_j,   v_j = v - v^2 g_j
    weight_j ~ pi_j (sigma_b / s_j) sqrt(v_j / v) exp(-g_j b^2 / 2)

and both are merged by their moments. Exact for a constant bias; one that drifts keeps the prior at every instant.

Reference: barshalom2001, sec. 11.4 (mixtures). Differs from the specification (6.5), whose bias is one normal.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import LANES, strict

# Share of the prior's variance of each component, and its weight: together they have the variance one.
SMALL_SHARE = 0.5
LARGE_SHARE = 4.0
LARGE_WEIGHT = (1.0 - SMALL_SHARE) / (LARGE_SHARE - SMALL_SHARE)


@strict
def weigh_biases(bias_variance, bank, x, p):
    """Take the merged tracks x (9, LANES), p (45, LANES) and their biases over to the mixture.

    To be called after `merge_bank`, once, before anything is shown; what the models remember stays as it is.
    """
    c = np.empty((9, LANES))
    w1 = bank.weight[1]
    for i in range(9):
        for lane in range(LANES):
            apart = (bank.x[1, i, lane] - bank.x[0, i, lane]) * (bank.x[1, 9, lane] - bank.x[0, 9, lane])
            low = bank.p[0, 45 + i, lane]
            c[i, lane] = low + w1[lane] * (bank.p[1, 45 + i, lane] - low) + w1[lane] * (1.0 - w1[lane]) * apart
    shift = np.zeros(LANES)
    more = np.zeros(LANES)
    for lane in range(LANES):
        if bank.on[lane] == 0:
            continue
        b = bank.bias[0, lane]
        # Merging may add the models' distance to what a prior allows.
        v = min(bank.bias[1, lane], bias_variance)
        g0 = 1.0 / (v + bias_variance * SMALL_SHARE / (1.0 - SMALL_SHARE))
        g1 = 1.0 / (v + bias_variance * LARGE_SHARE / (1.0 - LARGE_SHARE))
        odds = (
            LARGE_WEIGHT / (1.0 - LARGE_WEIGHT) * np.sqrt(SMALL_SHARE / LARGE_SHARE * (1.0 - v * g1) / (1.0 - v * g0))
        )
        odds *= np.exp(min(0.5 * (g0 - g1) * b * b, 600.0))
        large = odds / (1.0 + odds)
        mean = g0 + large * (g1 - g0)
        spread = large * (1.0 - large) * (g1 - g0) * (g1 - g0)
        shift[lane] = mean * b
        more[lane] = b * b * spread - mean
        bank.bias[0, lane] -= v * shift[lane]
        bank.bias[1, lane] += v * v * more[lane]
    for i in range(9):
        for j in range(i + 1):
            k = i * (i + 1) // 2 + j
            for lane in range(LANES):
                p[k, lane] += c[i, lane] * c[j, lane] * more[lane]
        for lane in range(LANES):
            x[i, lane] -= c[i, lane] * shift[lane]
