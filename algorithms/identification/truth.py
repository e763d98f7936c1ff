"""Score sets of plots of many radars against the truth, look by look and target by target.

A target counts where two radars and more detected it. It is *correct* where its plots are in one set with nothing else,
*wrong* where one of them is in a set with a plot that is not its own, else *undecided*. Recall and precision are
counted in pairs of plots.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.plots import Plots
from algorithms.identification.scenario import CLUTTER
from algorithms.identification.scoring import targets_of
from algorithms.recording import PolarPlots
from algorithms.scores import Sample, Scores, Tally

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
DOF = 2


def _choose_two(n: Floats) -> Floats:
    return n * (n - 1) / 2


def score_groups(
    recording: PolarPlots,
    plots: Plots,
    groups: Ints,
    place: Floats,
    covariance: Floats,
    statistic: Floats,
    dof: Floats,
    told: tuple[Floats, Floats],
) -> Scores:
    """Score groups (M, L), -1 = none, with fused places (M, 2, L), covariances (M, 3, L) and statistics (M, L).

    `told`: (M, L) at the first plot of each set its probability and whether it is one whole target, else NaN and 0.
    A target at a look has room for one set. Which sets take it must not depend on what they are: those that begin with
    a false plot are wrong, and what is stated of the others would come true too often.
    """
    lanes = plots.lanes
    known = [i for i, name in enumerate(recording.targets) if name not in ("", CLUTTER)]
    rows_of = {
        (look.number, t): np.flatnonzero((plots.frame == look.number) & (recording.target == t))
        for look in plots.looks
        for t in known
    }
    stated, whole_set = told
    names = (
        "stated",
        "stated_right",
        "both",
        "correct",
        "wrong",
        "right",
        "exist",
        "error",
        "claim",
        "nees",
        "fused",
        "statistic",
        "dof",
    )
    count = len(rows_of)
    got = {name: np.zeros((count, lanes)) for name in names}
    time, target = np.empty(count), np.empty(count, np.int64)
    right_pairs = np.zeros(lanes)
    for q, ((_, t), rows) in enumerate(rows_of.items()):
        seen = plots.usable[rows]
        n = seen.sum(axis=0).astype(float)
        both = n >= 2
        own = np.where(seen, groups[rows], -1)
        # Pairs of the target's plots in the same group.
        right = sum(
            ((own[i] == own[j]) & (own[i] >= 0)).astype(float)
            for i in range(len(rows))
            for j in range(i + 1, len(rows))
        ) + np.zeros(lanes)
        size = np.zeros((len(rows), lanes))
        for i, row in enumerate(rows):
            frame = plots.frame == plots.frame[row]
            size[i] = np.where(own[i] >= 0, (groups[frame] == groups[row]).sum(axis=0), 0)
        mine = np.zeros((len(rows), lanes))
        for i in range(len(rows)):
            mine[i] = np.where(own[i] >= 0, (own == own[i]).sum(axis=0), 0)
        wrong = both & (size > mine).any(axis=0)
        whole = both & (right == _choose_two(n)) & ~wrong
        first = rows[0]
        anchor = np.argmax(seen, axis=0)
        take = (rows[anchor], np.arange(lanes))
        error = np.stack([place[take[0], a, take[1]] - recording.truth_m[first, a] for a in (0, 1)])
        xx, yy, xy = (covariance[take[0], k, take[1]] for k in range(3))
        fused = whole & np.isfinite(error[0])
        nees = (yy * error[0] ** 2 - 2 * xy * error[0] * error[1] + xx * error[1] ** 2) / (xx * yy - xy * xy)
        values = {
            "both": both, "correct": whole, "wrong": wrong, "right": right, "exist": _choose_two(n),
            "error": np.where(fused, error[0] ** 2 + error[1] ** 2, 0.0), "claim": np.where(fused, xx + yy, 0.0),
            "nees": np.where(fused, nees, 0.0), "fused": fused,
            "statistic": np.where(fused, statistic[take], 0.0), "dof": np.where(fused, dof[take], 0.0),
        }  # fmt: skip
        for name, value in values.items():
            got[name][q] = value
        time[q], target[q] = recording.time_s[first], known.index(t)
        right_pairs += right
    slots_of: dict[int, list[int]] = {}
    for q, (number, _) in enumerate(rows_of):
        slots_of.setdefault(number, []).append(q)
    for number, slots in slots_of.items():
        sets = _mixed(np.flatnonzero(plots.frame == number))
        first_ones = np.argsort(~np.isfinite(stated[sets]), axis=0, kind="stable")[: len(slots)]
        room = slots[: len(first_ones)]
        got["stated"][slots] = np.nan
        got["stated"][room] = np.take_along_axis(stated[sets], first_ones, axis=0)
        got["stated_right"][room] = np.take_along_axis(whole_set[sets], first_ones, axis=0)
    made = np.zeros(lanes)
    for look in plots.looks:
        frame = groups[plots.frame == look.number]
        # Each plot of a set of n has n - 1 partners, and each pair is met twice.
        for row in frame:
            made += np.where(row >= 0, (frame == row).sum(axis=0) - 1, 0) / 2
    undecided = got["both"] - got["correct"] - got["wrong"]
    tallies = (
        Tally("probability_correct", "1", got["correct"], got["both"], curve=True, compared=True, share=True),
        Tally("probability_wrong", "1", got["wrong"], got["both"], curve=True, compared=True, share=True),
        Tally("probability_undecided", "1", undecided, got["both"], curve=True, compared=True, share=True),
        Tally("recall", "1", got["right"], got["exist"], compared=True, share=True),
        Tally("precision", "1", right_pairs, made, share=True),
        Tally("nis", "1", got["statistic"], got["dof"], curve=True, chi_square=True),
        Tally("rms_horizontal_m", "m", got["error"], got["fused"], root=True, compared=True),
        Tally("claimed_horizontal_m", "m", got["claim"], got["fused"], root=True),
        Tally("nees", "1", got["nees"], DOF * got["fused"], chi_square=True),
    )
    known_sets = np.isfinite(got["stated"])
    samples = (
        Sample("stated_probability", "1", got["stated"].astype(np.float32)),
        Sample("stated_right", "1", np.where(known_sets, got["stated_right"], np.nan).astype(np.float32)),
    )
    return Scores(tallies, samples, time, target, targets_of(recording) or ("",))


def _mixed(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rows in an order that has nothing to do with radars and targets, and is always the same (Knuth's hash)."""
    mixed: NDArray[np.int64] = rows[np.argsort((rows + 1) * 2654435761 % 2**32, kind="stable")]
    return mixed
