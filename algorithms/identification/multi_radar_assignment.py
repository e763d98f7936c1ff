"""Plots of two radars and more, put together into targets.

Sets of plots, one or none of each radar, compete for the plots; the best choice is an integer program, solved exactly.
Where there are more sets than `most_candidates`, the radars are taken one after another, which a note tells.

References
----------
barshalom2001, section 1.4; crouse2016; specification 7 D.

Differences from the paper
--------------------------
The paper has two radars. Where plots are so dense that not all choices can be summed over, the stated probability of a
set compares the best choice with the best one that lacks it; as further ones are left out, it is an upper bound.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.compare import doubts, side_of, unusable_plots
from algorithms.identification.filled import DOF, Filled, Pairs, joined_pairs, listed_pairs
from algorithms.identification.instants import brought_together
from algorithms.identification.measures import measure
from algorithms.identification.outputs import ACCEPTED, ONE_LINE, PLOT_OUTPUTS, TIED, UNDECIDED
from algorithms.identification.pairs import Points, pair_statistics, points_of
from algorithms.identification.parameters import ManyRadarParameters
from algorithms.identification.plots import Look, Plots, plots_of, refuse_nothing
from algorithms.identification.registration_sets import AcceptedSets, diagnosed_sets, joined_sets
from algorithms.identification.scenario import CLUTTER
from algorithms.identification.set_pairs import SetPairs, all_on_one_line
from algorithms.identification.tables import tabulate
from algorithms.identification.truth import score_groups
from algorithms.identification.tuples import Densities, Looked, Packed, pack
from algorithms.recording import PolarPlots
from algorithms.result import Note, Result, Setting
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


TIE = 1e-12
"""Probabilities nearer to each other than this are a tie."""


class MultiRadarParameters(ManyRadarParameters):
    """What the assignment of many radars knows."""


def _densities(seen: list[int], p: ManyRadarParameters) -> Densities:
    """From the parameters, and where they do not say it the number of targets from the mean number of plots."""
    count = p.target_count
    if count is None:
        count = max((float(np.mean(seen)) - p.clutter_per_radar) / p.detection_probability, 1.0)
    return Densities(
        p.detection_probability, count / p.region_area_m2, p.clutter_per_radar / p.region_area_m2, len(seen)
    )


def _looked(
    points: list[Points], usable: list[NDArray[np.bool_]], lane: int, p: ManyRadarParameters
) -> tuple[Looked, list[Ints]]:
    """One look of one trial, and which of each radar's plots are there."""
    there = [np.flatnonzero(u[:, lane]) for u in usable]
    cut = [Points(*(a[rows, lane] for a in one)) for one, rows in zip(points, there, strict=True)]
    return Looked(cut, _densities([rows.size for rows in there], p), gate_threshold(p.gate_tail, DOF)), there


def _solved(
    plots: Plots, look: Look, p: ManyRadarParameters, lane: int, points: list[Points], *, bounds: bool
) -> tuple[Packed, Ints, list[Ints]]:
    """The best sets of one trial, their plots as positions in the recording, (T, K), -1 = none, and what was there."""
    looked, there = _looked(points, [plots.usable[rows] for rows in look.rows], lane, p)
    packed = pack(looked, limit=p.most_candidates, probabilities=True, bounds=bounds)
    marks = np.full(packed.tuples.shape, -1)
    for k, rows in enumerate(look.rows):
        has = packed.tuples[:, k] >= 0
        marks[has, k] = rows[there[k][packed.tuples[has, k]]]
    return packed, marks, there


def _points(plots: Plots, look: Look, p: ManyRadarParameters) -> list[Points]:
    return [points_of(side_of(plots, k, rows), p.conversion) for k, rows in enumerate(look.rows)]


def _accepted(packed: Packed, p: ManyRadarParameters) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether each set is accepted, and whether another one of its plots is exactly as probable."""
    own, listed = packed.probability, packed.listed_probability
    tied = np.zeros(own.size, np.bool_)
    for t in np.flatnonzero((own > TIE) & ~packed.bounded):
        rivals = ((packed.listed == packed.tuples[t]) & (packed.listed >= 0)).any(axis=1)
        tied[t] = (np.abs(listed[rivals] - own[t]) < TIE).sum() > 1
    if p.decision == "most_likely":
        return np.ones(own.size, np.bool_), tied
    return ~(own < p.p_min) & ~tied, tied


def run(recording: PolarPlots, parameters: MultiRadarParameters, context: RunContext) -> Result:
    """Put the plots of all radars together, look by look and trial by trial."""
    plots = plots_of(recording, parameters)
    refuse_nothing(plots)
    radars = tuple(range(len(plots.names)))
    together = brought_together(recording, plots, radars, extrapolate=parameters.extrapolate)
    plots = together.plots
    filled = Filled(plots)
    threshold = gate_threshold(parameters.alpha, DOF)
    total = sum(a.size * b.size for look in plots.looks for a, b in combinations(look.rows, 2))
    pairs: list[Pairs] = []
    sequential = bounded = 0
    sets: list[AcceptedSets] = []
    for number, look in enumerate(plots.looks):
        points = _points(plots, look, parameters)
        for rows, one in zip(look.rows, points, strict=True):
            filled.position[rows] = np.stack([one.x, one.y], axis=1) - _gone_on(plots, rows)
        found = SetPairs(look, plots.lanes)
        for lane in range(plots.lanes):
            context.check_cancelled()
            packed, marks, there = _solved(plots, look, parameters, lane, points, bounds=True)
            sequential += not packed.exact
            bounded += bool(packed.bounded.any())
            kept, tied = _accepted(packed, parameters)
            found.take(lane, packed, there, kept)
            for rows, alone, here in zip(look.rows, found.alone, there, strict=True):
                filled.alone[rows[here], lane] = filled.probability[rows[here], lane] = alone[here, lane]
            _take(recording, plots, filled, packed, marks, lane, (kept, tied))
            if plots.lanes == 1:
                sets.append(AcceptedSets(marks[kept], packed.place[kept], packed.covariance[kept]))
        pairs += _pairs(recording, plots, look, parameters, found, total)
        context.progress((number + 1) / len(plots.looks))
    if not plots.looks:
        context.check_cancelled()
        context.progress(1.0)
    made = joined_sets(sets, len(radars))
    hypotheses, wrong = diagnosed_sets(*together.at_instants, made) if plots.lanes == 1 else ([], [])
    notes = [*plots.notes, *unusable_plots(plots), *together.notes, *doubts(filled), *wrong]
    if sequential:
        notes.append(
            Note(
                "radar_by_radar",
                "Looks with more sets of plots than most_candidates were put together radar by radar, which need not "
                "be the best choice, and without probabilities.",
                sequential,
            )
        )
    if bounded:
        notes.append(
            Note(
                "sets_bounded",
                "Looks are so dense that the probabilities of some sets of plots are no sums over all choices: each "
                "compares the best choice with the best one that lacks the set, which is an upper bound.",
                bounded,
            )
        )
    arrays = (
        filled.arrays()
        | joined_pairs(pairs, plots.lanes)
        | {
            "row": recording.row,
            "instant_s": together.instant_s,
            "frame": plots.frame,
            "radar": plots.radar,
            "threshold": np.array([threshold]),
            "registration": np.array([h.numbers() for h in hypotheses]).reshape(-1, 9),
        }
    )
    settings = plots.settings | {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in type(parameters).model_fields
        if name not in plots.settings and getattr(parameters, name) is not None
    }
    return Result(arrays, tuple(notes), settings)


def _gone_on(plots: Plots, rows: Ints) -> Floats:
    """(n, 2, 1) m by how much the targets of plots went on to the instant of the look."""
    gone: Floats = np.zeros((rows.size, 2, 1)) if plots.ahead is None else plots.ahead[rows, :2, None]
    return gone


def _take(
    recording: PolarPlots,
    plots: Plots,
    filled: Filled,
    packed: Packed,
    marks: Ints,
    lane: int,
    said: tuple[NDArray[np.bool_], NDArray[np.bool_]],
) -> None:
    accepted, tied = said
    for t, members in enumerate(marks):
        own = members[members >= 0]
        filled.decision[own, lane] = ACCEPTED if accepted[t] else UNDECIDED
        filled.probability[own, lane] = packed.probability[t]
        filled.statistic[own, lane] = packed.statistic[t]
        if accepted[t]:
            filled.group[own, lane] = recording.row[own[0]]
            filled.fused[own, :, lane] = packed.place[t]
            filled.covariance[own, :, lane] = packed.covariance[t]
        elif tied[t]:
            filled.reason[own, lane] = TIED
        elif all_on_one_line(plots, own, lane):
            filled.reason[own, lane] = ONE_LINE


def _pairs(
    recording: PolarPlots, plots: Plots, look: Look, p: ManyRadarParameters, sets: SetPairs, total: int
) -> list[Pairs]:
    """All pairs of radars: a pair has the decision of the set that both plots are in."""
    out = []
    for a, b in combinations(range(len(plots.names)), 2):
        rows = (look.rows[a], look.rows[b])
        found = pair_statistics(side_of(plots, a, rows[0]), side_of(plots, b, rows[1]), p.conversion)
        said = (sets.probability[a, b], sets.decision[a, b])
        out.append(listed_pairs(recording, look.number, rows, found.statistic, *said, total))
    return out


def score(recording: PolarPlots, parameters: MultiRadarParameters, context: RunContext) -> Scores:
    """Count pairs and whole targets that are put together rightly."""
    plots = plots_of(recording, parameters)
    groups = np.full(plots.range_m.shape, -1)
    place, covariance = (
        np.full((len(recording), 2, plots.lanes), np.nan),
        np.full((len(recording), 3, plots.lanes), np.nan),
    )
    statistic, dof = np.full(groups.shape, np.nan), np.zeros(groups.shape)
    stated, whole = np.full(groups.shape, np.nan), np.zeros(groups.shape)
    bounds = parameters.decision == "posterior"
    for look in plots.looks:
        points = _points(plots, look, parameters)
        for lane in range(plots.lanes):
            context.check_cancelled()
            packed, marks, _ = _solved(plots, look, parameters, lane, points, bounds=bounds)
            accepted, _ = _accepted(packed, parameters)
            _state(recording, plots, packed, marks, lane, (stated, whole))
            for t in np.flatnonzero(accepted):
                own = marks[t][marks[t] >= 0]
                groups[own, lane] = own[0]
                place[own, :, lane], covariance[own, :, lane] = packed.place[t], packed.covariance[t]
                statistic[own, lane], dof[own, lane] = packed.statistic[t], DOF * (own.size - 1)
    return score_groups(recording, plots, groups, place, covariance, statistic, dof, (stated, whole))


def _state(
    recording: PolarPlots, plots: Plots, packed: Packed, marks: Ints, lane: int, told: tuple[Floats, Floats]
) -> None:
    """Note at the first plot of each set, whatever was decided, its probability and whether it is one whole target."""
    stated, whole = told
    for t, members in enumerate(marks):
        own = members[members >= 0]
        one = recording.target[own[0]]
        seen = (recording.target == one) & (plots.frame == plots.frame[own[0]]) & plots.usable[:, lane]
        stated[own[0], lane] = packed.probability[t]
        real = recording.targets[one] != CLUTTER
        whole[own[0], lane] = real and (recording.target[own] == one).all() and own.size == seen.sum()


ALGORITHM = Algorithm(
    name="multi_radar_assignment",
    title="Matching of many radars",
    summary="Plots of two radars and more are put together into targets: the best choice of disjoint sets of plots, "
    "found exactly, with missed detections and false plots.",
    family="identification",
    takes=("polar_plots",),
    parameters=MultiRadarParameters,
    outputs=PLOT_OUTPUTS,
    charts=(
        "plan",
        "pairs_plan",
        "pair_closeup",
        "association_matrix",
        "pair_statistic",
        "trials_decisions",
        "trials_probability",
        "trials_base",
        "trials_sweep",
        "trials_placement",
        "trials_tradeoff",
        "trials_reliability",
    ),
    references=(Reference("prosov2008"), Reference("barshalom2001", "section 1.4"), Reference("crouse2016")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
