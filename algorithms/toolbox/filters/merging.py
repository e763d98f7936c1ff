"""Merge hypotheses about one target: six rules that choose weights, and the moments that these weights give.

A rule sees K hypotheses with logarithms l of their probabilities, not normalised, and the number m of the *main* one
(the model did not change):

* `moment`        all, weights proportional to exp(l): the textbook's rule;
* `max`           the most probable alone (of equals the first);
* `combined`      main alone where it is more probable than each other one, else as `moment`;
* `modified`      main alone likewise, else main and the most probable other one, in proportion;
* `combined_sum`  as `combined`, but main must be more probable than all others together;
* `modified_pair` as `modified`, but the merged probability is that of the pair only.

Then mean = sum w x, covariance = sum w (P + (x - mean)(x - mean)^T). The merged probability is the sum of all K except
in `modified_pair`. Hypotheses of probability zero get no weight; where all have none, main stays, with probability 0.

References
----------
trudymai2023, eqs. (4)-(7); blom1988.

Differences from the paper
--------------------------
Its (4) prints the inner product of the deviations where the outer one must stand. Ties and "exceeds the others" are
settled as above; the last two rules are the other possible readings.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.filters.transition import LN_ZERO
from algorithms.toolbox.kernels import LANES, inlined, kernel
from algorithms.toolbox.kernels.exponential import exp_row, log_row
from algorithms.toolbox.kernels.hypothesis import add_9, merge_2_9, merge_3_9

RULES = ("moment", "max", "combined", "modified", "combined_sum", "modified_pair")
"""Names of the rules; a kernel takes the position in this tuple."""
MOMENT, MAX, COMBINED, MODIFIED, COMBINED_SUM, MODIFIED_PAIR = range(6)
# Below this a logarithm stands for zero; likelihoods never come near it.
NOTHING = 0.5 * LN_ZERO


@kernel
def log_sum(logs, total):
    """Write ln sum exp of (K, LANES) over K into `total`, (LANES,)."""
    k = logs.shape[0]
    top, part, sums = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    for lane in range(LANES):
        top[lane] = logs[0, lane]
        sums[lane] = 0.0
    for i in range(1, k):
        for lane in range(LANES):
            top[lane] = max(top[lane], logs[i, lane])
    for i in range(k):
        for lane in range(LANES):
            part[lane] = logs[i, lane] - top[lane]
        exp_row(part, part)
        for lane in range(LANES):
            sums[lane] += part[lane]
    log_row(sums, sums)
    for lane in range(LANES):
        total[lane] = top[lane] + sums[lane]


@kernel
def merge_weights(logs, main, rule, weight, total):
    """Choose weights (K, LANES) and write the merged logarithm (LANES,); `main` < 0 = there is no main one."""
    k = logs.shape[0]
    if k == 1:
        for lane in range(LANES):
            weight[0, lane] = 1.0
            total[lane] = logs[0, lane]
        return
    m = max(main, 0)
    top, sums = np.empty(LANES), np.empty(LANES)
    for lane in range(LANES):
        top[lane] = logs[0, lane]
        sums[lane] = 0.0
    for i in range(1, k):
        for lane in range(LANES):
            top[lane] = max(top[lane], logs[i, lane])
    for i in range(k):
        for lane in range(LANES):
            weight[i, lane] = logs[i, lane] - top[lane]
        exp_row(weight[i], weight[i])
        for lane in range(LANES):
            sums[lane] += weight[i, lane]
    log_row(sums, total)
    for lane in range(LANES):
        total[lane] += top[lane]
    if rule == MOMENT:
        for lane in range(LANES):
            sums[lane] = 1.0 / sums[lane]
        for i in range(k):
            for lane in range(LANES):
                weight[i, lane] *= sums[lane]
    else:
        for lane in range(LANES):
            _choose(logs, m, rule, weight, total, lane, top[lane], sums[lane])
    for lane in range(LANES):
        if top[lane] < NOTHING:
            for i in range(k):
                weight[i, lane] = 1.0 if i == m else 0.0
            total[lane] = LN_ZERO


@inlined
def _choose(logs, m, rule, weight, total, lane, top, sum_):
    """Weights of one lane by the rules that may leave hypotheses out; `weight` holds exp(l - top)."""
    k = logs.shape[0]
    best = -1
    for i in range(k):
        if (rule == MAX or i != m) and (best < 0 or logs[i, lane] > logs[best, lane]):
            best = i
    if rule == MAX:
        for i in range(k):
            weight[i, lane] = 1.0 if i == best else 0.0
        return
    if rule == COMBINED_SUM:
        alone = weight[m, lane] > sum_ - weight[m, lane]
    else:
        alone = logs[m, lane] > logs[best, lane]
    pair = weight[m, lane] + weight[best, lane]
    if rule == MODIFIED_PAIR:
        total[lane] = top + np.log(pair)
    if alone:
        for i in range(k):
            weight[i, lane] = 1.0 if i == m else 0.0
    elif rule in (COMBINED, COMBINED_SUM):
        for i in range(k):
            weight[i, lane] /= sum_
    else:
        for i in range(k):
            weight[i, lane] = weight[i, lane] / pair if i in (m, best) else 0.0


@kernel
def merge_moments(s, weight, out):
    """Merge hypotheses s (K, 54, LANES) with weights (K, LANES) into one (54, LANES)."""
    k = s.shape[0]
    if k == 3:
        merge_3_9(s, weight, out)
        return
    if k == 2:
        merge_2_9(s, weight, out)
        return
    if k == 1:
        out[:] = s[0]
        return
    for i in range(54):
        for lane in range(LANES):
            out[i, lane] = 0.0
    for n in range(k):
        for i in range(9):
            for lane in range(LANES):
                out[i, lane] += weight[n, lane] * s[n, i, lane]
    for n in range(k):
        add_9(s[n], weight[n], out)
