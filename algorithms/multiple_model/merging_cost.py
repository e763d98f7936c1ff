"""How many arithmetic operations the merging of hypotheses takes at each mark, where code branches.

A rule that lets the unchanged model stand alone merges nothing there; what it saves depends on how often that is
(specification 7). A merge of K hypotheses of nine states in packed symmetric storage costs 216 K - 54 operations, one
of a single hypothesis none. Counted from the probabilities that the filter reports: joint = P(dt) diag(p), p of the
mark before.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.tracker import ModelSet
from algorithms.toolbox.filters.transition import transition_over

Floats = NDArray[np.float64]

ALONE = ("combined", "modified", "combined_sum", "modified_pair")


def merging_operations(recording: Plots, chosen: ModelSet, probability: Floats) -> Floats | None:
    """(M, L) operations before each mark, NaN at the first one; None where the structure merges elsewhere.

    probability : (M, N, L) after each mark
    """
    n = len(chosen.models)
    if chosen.structure != "imm" or n < 2:
        return None
    out = np.full((probability.shape[0], probability.shape[2]), np.nan)
    columns = np.array(chosen.transition, float).T
    known: dict[float, Floats] = {}
    for target in range(len(recording.targets)):
        rows = recording.rows_of(target)
        steps = np.round(np.diff(recording.time_s[rows]) / chosen.step_s, 9)
        for step in np.unique(steps[steps > 0]):
            if step not in known:
                known[step] = transition_over(columns, float(step))[0]
            after = np.flatnonzero(steps == step)
            out[rows[after + 1]] = _operations(known[step], probability[rows[after]], chosen.merging)
    return out


def _operations(transition: Floats, before: Floats, rule: str) -> Floats:
    """(M, L) operations of one interval; `before` is (M, N, L)."""
    total = np.zeros((before.shape[0], before.shape[2]))
    for model, row in enumerate(transition):
        joint = row[None, :, None] * before
        merged = (joint > 0).sum(axis=1)
        if rule == "max":
            merged = np.minimum(merged, 1)
        elif rule in ALONE:
            others = np.delete(joint, model, axis=1)
            rival = others.sum(axis=1) if rule == "combined_sum" else others.max(axis=1)
            if rule.startswith("modified"):
                merged = np.minimum(merged, 2)
            merged = np.where(joint[:, model] > rival, 1, merged)
        total += np.where(merged > 1, 216 * merged - 54, 0)
    return np.where(np.isfinite(before).all(axis=1), total, np.nan)
