"""Do the radars agree as a whole, and if not, what is wrong with which of them, and by how much?

Small errors are seen in the pairs that were accepted. Where they are an alarm, pairs are found anew with the error
undone, because those that were accepted are the ones that it did not take out of the gate. Where nothing fits at all,
the error is searched for first (`suspicion`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.plots import Plots
from algorithms.identification.registration import Hypothesis, hypotheses_of, notes_of
from algorithms.identification.registration_pairs import (
    differences,
    lone_pairs,
    moved,
    undone,
    velocities_of_pairs,
    velocities_of_plots,
)
from algorithms.identification.suspicion import SUSPICIOUS_MEDIAN, Moving, Start, median_statistic, starts, suspected
from algorithms.recording import PolarPlots
from algorithms.result import Note
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Pairs found with an error undone lie within this gate.
PAIR_TAIL = 1e-4
ROUNDS = 2
STEPS = 8
# A step of so small a part of the standard deviation is the last.
SETTLED = 0.1
# Differences left over are at most so many times what the accuracies say, else the pairing is looked at again.
UNFINISHED = 3.0
# Chance takes a pair or two out of the gate where a small error is undone.
AS_MANY = 0.97
Diagnosis = tuple[list[Hypothesis], list[Note]]


def diagnosed(recording: PolarPlots, plots: Plots, first: int, second: int, accepted: Ints) -> Diagnosis:
    """Judge two radars by the pairs (N, 2) of rows that were accepted; hypotheses with the best first, and notes."""
    radars = (first, second)

    @cache
    def velocity() -> Floats:
        return velocities_of_plots(recording, plots, second)

    moving = Moving(velocity, _period_s(recording, plots))
    doubt = suspected(plots, first, second, moving)
    if doubt is not None:
        if doubt.start is None:
            # Pairs are accidents here, and say nothing.
            return [], doubt.notes
        found = _from_start(recording, plots, radars, doubt.start, velocity())
        return found, [*doubt.notes, *notes_of(found, plots.names)]
    rows = _enough(plots, radars, accepted)
    found = _tested(recording, plots, radars, rows, plots)
    if found and found[0].alarm:
        found = _refined(recording, plots, radars, found, velocity(), len(rows))
        if found and found[0].left > UNFINISHED:
            # A wrong way of pairing can be the nearest one; another start may leave less.
            for start in starts(plots, first, second, moving):
                other = _from_start(recording, plots, radars, start, velocity())
                found = other if other and other[0].left < found[0].left else found
    return found, notes_of(found, plots.names)


def _from_start(
    recording: PolarPlots, plots: Plots, radars: tuple[int, int], start: Start, velocity: Floats
) -> list[Hypothesis]:
    """Test the pairs that an assumed error makes."""
    without = moved(plots, start.radar, start.kind, start.value, velocity)
    rows = lone_pairs(without, radars, SUSPICIOUS_MEDIAN)
    return _refined(recording, plots, radars, _tested(recording, plots, radars, rows, without, start), velocity)


def _enough(plots: Plots, radars: tuple[int, int], accepted: Ints) -> Ints:
    """The accepted pairs; where most plots that have a near partner were not accepted, those that are near instead."""
    fewer = min(int(plots.usable[plots.radar == r, 0].sum()) for r in radars)
    if 2 * len(accepted) >= fewer:
        return accepted
    near = lone_pairs(plots, radars, SUSPICIOUS_MEDIAN)
    return near if 2 * len(accepted) < len(near) else accepted


def _period_s(recording: PolarPlots, plots: Plots) -> float:
    """Usual time between two looks; 0 = there is one only."""
    begin = [float(recording.time_s[plots.frame == look.number].min()) for look in plots.looks[:100]]
    return float(np.median(np.diff(begin))) if len(begin) > 1 else 0.0


def _tested(
    recording: PolarPlots, plots: Plots, radars: tuple[int, int], rows: Ints, without: Plots, start: Start | None = None
) -> list[Hypothesis]:
    """Test pairs as they are; velocities come from where they are `without` the error that is assumed."""
    velocity = velocities_of_pairs(recording, without, rows)
    found = hypotheses_of(differences(recording, plots, rows, velocity), *radars)
    if found and (start is not None or found[0].alarm):
        found = [_polished(recording, plots, rows, radars, _begun(h, start), velocity) for h in found]
    return sorted(found, key=lambda h: h.rest)


def _begun(h: Hypothesis, start: Start | None) -> Hypothesis:
    """Begin from an assumed error where it is of that kind: one step from nothing may go astray."""
    return h if start is None or (h.kind, h.radar) != (start.kind, start.radar) else replace(h, value=start.value)


def _polished(
    recording: PolarPlots, plots: Plots, rows: Ints, radars: tuple[int, int], h: Hypothesis, velocity: Floats
) -> Hypothesis:
    """Find by how much step by step, each with the error so far undone: plots move on arcs, and the axes with them."""
    of_plots = np.full((plots.radar.size, 2), np.nan)
    of_plots[rows[:, 1]] = velocity
    value = h.value
    for _ in range(STEPS):
        without = moved(plots, h.radar, h.kind, value, of_plots)
        found = hypotheses_of(differences(recording, without, rows, velocity), *radars)
        left = next((one for one in found if (one.kind, one.radar) == (h.kind, h.radar)), None)
        if left is None:
            break
        value = value + left.value
        if (np.abs(left.value) < SETTLED * left.sd).all():
            return h.polished(value, left, len(rows))
    return h


def _refined(
    recording: PolarPlots,
    plots: Plots,
    radars: tuple[int, int],
    hypotheses: list[Hypothesis],
    moving: Floats,
    accepted: int = 0,
) -> list[Hypothesis]:
    """Find the pairs anew with the best hypothesis undone, and test all hypotheses on them.

    An error that is none takes true pairs apart when it is undone: where fewer plots agree than before, accidental
    pairs made the alarm, and nothing is left of it. Where plots are so dense that hardly any pair is alone, those that
    were accepted say more.
    """
    gate = gate_threshold(PAIR_TAIL, 2)
    before = len(lone_pairs(plots, radars, gate))
    for _ in range(ROUNDS):
        if not hypotheses or not hypotheses[0].alarm:
            return hypotheses
        without = undone(plots, hypotheses[0], radars[1], moving)
        rows = lone_pairs(without, radars, gate)
        if len(rows) < AS_MANY * before:
            return []
        if 2 * len(rows) < accepted:
            return hypotheses
        best = hypotheses[0]
        hypotheses = _tested(recording, plots, radars, rows, without, Start(best.radar, best.kind, best.value))
    return hypotheses


def suspected_among(recording: PolarPlots, plots: Plots) -> Diagnosis | None:
    """Judge three radars and more where one disagrees with others beyond all reason; None where none does."""
    count = len(plots.names)
    bad = np.zeros((count, count))
    for a, b in combinations(range(count), 2):
        bad[a, b] = bad[b, a] = median_statistic(plots, a, b) > SUSPICIOUS_MEDIAN
    if not bad.any():
        return None
    # Whoever disagrees with most is wrong; whoever agrees with most is what it is held against.
    culprit = int(bad.sum(axis=1).argmax())
    against = int(np.where(bad[culprit] > 0, bad.sum(axis=1), np.inf).argmin())
    return diagnosed(recording, plots, against, culprit, np.empty((0, 2), np.int64))
