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
from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.exponential import exponential, logarithm
from algorithms.toolbox.kernels.hypothesis import add_9, merge_2_9, merge_3_9, merge_4_9

RULES = ("moment", "max", "combined", "modified", "combined_sum", "modified_pair")
"""Names of the rules; a kernel takes the position in this tuple."""
MOMENT, MAX, COMBINED, MODIFIED, COMBINED_SUM, MODIFIED_PAIR = range(6)
# Below this a logarithm stands for zero; likelihoods never come near it.
NOTHING = 0.5 * LN_ZERO


@bare
def log_sum(logs, total, spare):
    """Write ln sum exp of (K, LANES) over K into `total`, (LANES,); `spare` (2, LANES) is room to work in."""
    sums = spare[0]
    _exponents(logs, logs, total, sums, 0)
    for lane in range(LANES):
        total[lane] += logarithm(sums[lane])


@bare
def _exponents(logs, weight, top, sums, keep):
    """Largest logarithm and the sum of exp(l - top) of each lane; these terms into `weight` where `keep` is 1."""
    k = logs.shape[0]
    for lane in range(LANES):
        top[lane] = logs[0, lane]
        sums[lane] = 0.0
    for i in range(1, k):
        for lane in range(LANES):
            top[lane] = max(top[lane], logs[i, lane])
    for i in range(k):
        row = logs[i]
        if keep == 1:
            out = weight[i]
            for lane in range(LANES):
                out[lane] = exponential(row[lane] - top[lane])
            for lane in range(LANES):
                sums[lane] += out[lane]
        else:
            for lane in range(LANES):
                sums[lane] += exponential(row[lane] - top[lane])


@bare
def merge_weights(logs, main, rule, weight, total, spare):
    """Choose weights (K, LANES) and write the merged logarithm (LANES,).

    `main` < 0 = there is no main one; `spare` (2, LANES) is room to work in.
    """
    k = logs.shape[0]
    if k == 1:
        for lane in range(LANES):
            weight[0, lane] = 1.0
            total[lane] = logs[0, lane]
        return
    m = max(main, 0)
    sums, top = spare[0], spare[1]
    _exponents(logs, weight, top, sums, 1)
    for lane in range(LANES):
        total[lane] = top[lane] + logarithm(sums[lane])
    if rule == MOMENT:
        for lane in range(LANES):
            sums[lane] = 1.0 / sums[lane]
        for i in range(k):
            for lane in range(LANES):
                weight[i, lane] *= sums[lane]
    elif rule in (COMBINED, COMBINED_SUM):
        _choose_main(m, rule, weight, sums)
    else:
        for lane in range(LANES):
            _choose(logs, m, rule, weight, total, lane, top[lane])
    nothing = 0
    for lane in range(LANES):
        nothing += 1 if top[lane] < NOTHING else 0
    if nothing == 0:
        return
    for lane in range(LANES):
        if top[lane] < NOTHING:
            for i in range(k):
                weight[i, lane] = 1.0 if i == m else 0.0
            total[lane] = LN_ZERO


@bare
def _choose_main(m, rule, weight, sums):
    """Weights where main may stand alone and all others are merged; `weight` holds exp(l - top), 1 for the largest."""
    k = weight.shape[0]
    for lane in range(LANES):
        own = weight[m, lane]
        rival = sums[lane] - own
        if rule == COMBINED:
            rival = 0.0
            for i in range(k):
                if i != m:
                    rival = max(rival, weight[i, lane])
        # What is as probable as the largest has exactly 1 here, so a tie is one to the bit.
        scale = 1.0 / sums[lane]
        alone = own > rival
        for i in range(k):
            weight[i, lane] = (1.0 if i == m else 0.0) if alone else weight[i, lane] * scale


@bare
def _choose(logs, m, rule, weight, total, lane, top):
    """Weights of one lane by the rules that leave hypotheses out; `weight` holds exp(l - top)."""
    k = logs.shape[0]
    best = -1
    for i in range(k):
        if (rule == MAX or i != m) and (best < 0 or logs[i, lane] > logs[best, lane]):
            best = i
    if rule == MAX:
        for i in range(k):
            weight[i, lane] = 1.0 if i == best else 0.0
        return
    pair = weight[m, lane] + weight[best, lane]
    if rule == MODIFIED_PAIR:
        total[lane] = top + np.log(pair)
    alone = logs[m, lane] > logs[best, lane]
    for i in range(k):
        if alone:
            weight[i, lane] = 1.0 if i == m else 0.0
        else:
            weight[i, lane] = weight[i, lane] / pair if i in (m, best) else 0.0


@bare
def merge_moments(s, weight, out):
    """Merge hypotheses s (K, 54, LANES) with weights (K, LANES) into one (54, LANES)."""
    k = s.shape[0]
    if k == 4:
        merge_4_9(s, weight, out)
        return
    if k == 3:
        merge_3_9(s, weight, out)
        return
    if k == 2:
        merge_2_9(s, weight, out)
        return
    if k == 1:
        copy_hypothesis(s[0], out)
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


@bare
def copy_hypothesis(source, target):
    """Copy all lanes of one hypothesis (54, LANES)."""
    a, b = source.reshape(54 * LANES), target.reshape(54 * LANES)
    for i in range(54 * LANES):
        b[i] = a[i]
