"""When a receiver's crossing is taken for final (specification 4, step 4; the paper does not say it).

Before the crossing is seen, tau_j is an extrapolation and follows the window. Rule A keeps the first value tau_j <= t_k
of each receiver; rule B the last value before that; rule C keeps both at the first instant at which both have crossed;
`none` never keeps any. `delay` epochs are waited before the value is taken. A crossing counts only where it is seen in
`confirm` windows in a row: the first of them gives the value; a run that breaks cancels it.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import strict

NEVER, RULE_A, RULE_B, RULE_C = range(4)
RULES = ("none", "a", "b", "c")

# Columns of a receiver's memory.
RUN, AGE, HAS, HELD, CONFIRMED, FROZEN, BEFORE, KEPT_VARIANCE = range(8)
MEMORY = 8


@strict
def forget(memory):
    """Begin a pass: nothing seen, nothing kept."""
    memory[:] = 0.0
    memory[:, BEFORE] = np.nan
    memory[:, HELD] = np.nan


@strict
def crossing(memory, j, raw, variance, fresh, crossed, rule, delay, confirm):
    """Return the crossing time of receiver j to be used now, and keep what is to be kept.

    `raw` is the zero of the current line with its variance, `fresh` whether there is one, `crossed` whether it counts
    as crossed under the rule.
    """
    m = memory[j]
    if rule == NEVER or not fresh:
        return m[HELD] if m[FROZEN] > 0.0 else raw
    if m[FROZEN] > 0.0:
        return m[HELD]
    if m[RUN] > 0.0 or m[CONFIRMED] > 0.0:
        m[AGE] += 1.0
    if m[CONFIRMED] == 0.0:
        if crossed:
            m[RUN] += 1.0
            if m[RUN] == 1.0:
                m[AGE] = 0.0
        else:
            m[RUN] = 0.0
            m[HAS] = 0.0
            m[BEFORE] = raw
        if m[RUN] >= confirm:
            m[CONFIRMED] = 1.0
    if m[RUN] > 0.0 and m[HAS] == 0.0 and (m[AGE] >= delay or rule == RULE_B):
        m[HELD] = m[BEFORE] if rule == RULE_B and np.isfinite(m[BEFORE]) else raw
        m[KEPT_VARIANCE] = variance
        m[HAS] = 1.0
    if m[HAS] > 0.0:
        m[FROZEN] = m[CONFIRMED]
        return m[HELD]
    return raw
