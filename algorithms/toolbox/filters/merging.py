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
from algorithms.toolbox.kernels.flat import flat
from algorithms.toolbox.kernels.hypothesis import (
    add_9,
    merge_2_6,
    merge_2_9,
    merge_3_6,
    merge_3_9,
    merge_4_6,
    merge_4_9,
)

RULES = ("moment", "max", "combined", "modified", "combined_sum", "modified_pair")
"""Names of the rules; a kernel takes the position in this tuple."""
MOMENT, MAX, COMBINED, MODIFIED, COMBINED_SUM, MODIFIED_PAIR = range(6)
# Below this a logarithm stands for zero; likelihoods never come near it.
NOTHING = 0.5 * LN_ZERO


@bare
def exponents(logs, weight, top, sums):
    """Of logarithms (K, LANES) write the largest into `top`, exp(l - top) into `weight` and their sum into `sums`."""
    k = logs.shape[0]
    for lane in range(LANES):
        top[lane] = logs[0, lane]
        sums[lane] = 0.0
    for i in range(1, k):
        row = logs[i]
        for lane in range(LANES):
            top[lane] = max(top[lane], row[lane])
    for i in range(k):
        row, out = logs[i], weight[i]
        for lane in range(LANES):
            out[lane] = exponential(row[lane] - top[lane])
        for lane in range(LANES):
            sums[lane] += out[lane]


@bare
def merge_weights(logs, main, rule, weight, total, spare):
    """Choose weights (K, LANES) and write the merged logarithm (LANES,).

    `main` < 0 = there is no main one; `spare` (2, LANES) is room to work in.
    """
    k = logs.shape[0]
    sums, top = spare[0], spare[1]
    exponents(logs, weight, top, sums)
    choose_weights(main, rule, weight, sums, total)
    nothing = 0
    for lane in range(LANES):
        total[lane] += top[lane]
        nothing += 1 if top[lane] < NOTHING else 0
    if nothing == 0:
        return
    for lane in range(LANES):
        if top[lane] < NOTHING:
            for i in range(k):
                weight[i, lane] = 1.0 if i == max(main, 0) else 0.0
            total[lane] = LN_ZERO


@bare
def choose_weights(main, rule, weight, sums, total):
    """Turn probabilities (K, LANES) of any scale, and their sum, into weights; write the merged one's logarithm."""
    k = weight.shape[0]
    for lane in range(LANES):
        total[lane] = logarithm(sums[lane])
    if k == 1:
        for lane in range(LANES):
            weight[0, lane] = 1.0
    elif rule == MOMENT:
        for lane in range(LANES):
            sums[lane] = 1.0 / sums[lane]
        for i in range(k):
            row = weight[i]
            for lane in range(LANES):
                row[lane] *= sums[lane]
    elif rule in (COMBINED, COMBINED_SUM):
        _choose_main(max(main, 0), rule, weight, sums)
    else:
        for lane in range(LANES):
            _choose(max(main, 0), rule, weight, total, lane)


@bare
def stands_alone(main, weight):
    """Whether the main hypothesis has all the weight in every lane, so that merging would change nothing."""
    others = 0
    for i in range(weight.shape[0]):
        row = weight[i]
        if i != main:
            for lane in range(LANES):
                others += 1 if row[lane] != 0.0 else 0
    return others == 0


@bare
def _choose_main(m, rule, weight, sums):
    """Weights where main may stand alone and all others are merged."""
    k = weight.shape[0]
    own = weight[m]
    for lane in range(LANES):
        rival = sums[lane] - own[lane]
        if rule == COMBINED:
            rival = 0.0
            for i in range(k):
                if i != m:
                    rival = max(rival, weight[i, lane])
        # Below zero where main stands alone.
        scale = 1.0 / sums[lane]
        sums[lane] = -scale if own[lane] > rival else scale
    for i in range(k):
        row = weight[i]
        alone = 1.0 if i == m else 0.0
        for lane in range(LANES):
            row[lane] = row[lane] * sums[lane] if sums[lane] > 0.0 else alone


@bare
def _choose(m, rule, weight, total, lane):
    """Weights of one lane by the rules that leave hypotheses out."""
    k = weight.shape[0]
    best = -1
    for i in range(k):
        if (rule == MAX or i != m) and (best < 0 or weight[i, lane] > weight[best, lane]):
            best = i
    if rule == MAX:
        for i in range(k):
            weight[i, lane] = 1.0 if i == best else 0.0
        return
    pair = weight[m, lane] + weight[best, lane]
    if rule == MODIFIED_PAIR:
        total[lane] = np.log(pair)
    alone = weight[m, lane] > weight[best, lane]
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
def merge_positions_and_velocities(s, weight, out):
    """The same for a model that does not look at accelerations, whose rows of `out` mean nothing afterwards."""
    k = s.shape[0]
    if k == 4:
        merge_4_6(s, weight, out)
    elif k == 3:
        merge_3_6(s, weight, out)
    elif k == 2:
        merge_2_6(s, weight, out)
    else:
        merge_moments(s, weight, out)


@bare
def copy_hypothesis(source, target):
    """Copy all lanes of one hypothesis (54, LANES)."""
    a, b = flat(source), flat(target)
    for i in range(54 * LANES):
        b[i] = a[i]
