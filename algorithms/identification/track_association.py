"""Tracks of two radars: which of them are one target?

Each radar filters its own plots; a pair of tracks is compared at the last instant of the one that ends first,
S = d' (P1 + P2 - P12 - P12')^-1 d with d = x1 - x2, four degrees of freedom. Two tracks of one target share its
manoeuvres, so their errors are correlated: `cross_covariance` carries P12 along. With `polar` nothing is converted:
S compares one straight flight fitted to the plots of both radars with two separate ones.

References
----------
barshalom2001, section 8.4; bordonaro2014; specification 7 E.

Differences from the paper
--------------------------
The paper speaks of trajectories and tests single plots; here it is tracks. Beside the threshold, all tracks can be
matched together with probabilities. Where the recording names no targets, plots of a radar are joined to tracks first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.compare import chosen_radars, exactness
from algorithms.identification.diagnosis import diagnosed
from algorithms.identification.filled import Filled, joined_pairs, listed_pairs
from algorithms.identification.measures import measure
from algorithms.identification.outputs import NOT_COMPARED, PLOT_OUTPUTS, SAME_TIME, SHORT_TRACK, UNUSABLE
from algorithms.identification.pairs import points_of
from algorithms.identification.parameters import TrackParameters
from algorithms.identification.plots import Plots, plots_of, refuse_nothing
from algorithms.identification.scoring import targets_of
from algorithms.identification.straight import FEWEST_PLOTS, straight_track
from algorithms.identification.tables import tabulate
from algorithms.identification.track_pairs import (
    DecidedTracks,
    RadarTracks,
    decide_tracks,
    track_statistics,
    tracks_of,
    until,
)
from algorithms.identification.tracks import PLACE, Track
from algorithms.recording import PolarPlots
from algorithms.result import Note, Output, Result, Setting
from algorithms.scores import Sample, Scores, Tally
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.association.track_distance import DOF

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class TrackAssociationParameters(TrackParameters):
    """What the comparison of tracks knows."""


def run(recording: PolarPlots, parameters: TrackAssociationParameters, context: RunContext) -> Result:
    """Filter, compare, and give each plot what became of its track."""
    plots = plots_of(recording, parameters)
    refuse_nothing(plots)
    first, second = chosen_radars(recording, parameters)
    context.check_cancelled()
    a, b = (tracks_of(recording, plots, r, parameters) for r in (first, second))
    context.progress(0.5)
    context.check_cancelled()
    statistic, cost = track_statistics(a, b, parameters, None)
    decided = decide_tracks(statistic, cost, parameters)
    filled = Filled(plots)
    filled.decision[~np.isin(plots.radar, (first, second))] = NOT_COMPARED
    number = np.zeros(len(recording), np.int64)
    for s, of in enumerate((a, b)):
        for i, track in enumerate(of.tracks):
            number[track.rows] = (0 if s == 0 else len(a.tracks)) + i + 1
            _take(recording, filled, plots, of, i, decided, s, (a, b), statistic, parameters)
            short = plots.usable[track.rows].sum(axis=0) < FEWEST_PLOTS
            filled.reason[track.rows] = np.where(
                short & plots.usable[track.rows], SHORT_TRACK, filled.reason[track.rows]
            )
        filled.decision[of.repeated], filled.reason[of.repeated] = UNUSABLE, SAME_TIME
    rows = tuple(np.array([t.rows[-1] for t in of.tracks], np.int64) for of in (a, b))
    total = statistic.shape[0] * statistic.shape[1]
    pairs = listed_pairs(recording, 0, (rows[0], rows[1]), statistic, decided.pairs, decided.pair_decision, total)
    hypotheses, wrong = (
        diagnosed(recording, plots, first, second, _accepted_plots(plots, a, b, decided))
        if plots.lanes == 1
        else ([], [])
    )
    context.progress(1.0)
    arrays: dict[str, Any] = (
        filled.arrays()
        | joined_pairs([pairs], plots.lanes)
        | {
            "row": recording.row,
            "instant_s": recording.time_s,
            "frame": plots.frame,
            "radar": plots.radar,
            "track": number,
            "threshold": np.array([gate_threshold(parameters.alpha, DOF)]),
            "registration": np.array([h.numbers() for h in hypotheses]).reshape(-1, 9),
        }
    )
    settings = plots.settings | {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in type(parameters).model_fields
        if name not in plots.settings and getattr(parameters, name) not in (None, "")
    }
    return Result(arrays, (*plots.notes, *_notes(parameters, filled, (a, b), decided), *wrong), settings)


def _notes(
    p: TrackParameters, filled: Filled, tracks: tuple[RadarTracks, RadarTracks], decided: DecidedTracks
) -> list[Note]:
    out = []
    short = sum(bool((filled.reason[t.rows] == SHORT_TRACK).any()) for of in tracks for t in of.tracks)
    if short:
        out.append(Note("short_tracks", "Tracks of fewer than two plots have no velocity; they stay alone.", short))
    repeated = sum(of.repeated.size for of in tracks)
    if repeated:
        out.append(
            Note(
                "repeated_times",
                "Plots whose track has another plot at the same time are left out; see decisions.",
                repeated,
            )
        )
    return out + exactness(p, decided.split, decided.ranked_groups, decided.truncation)


def _take(
    recording: PolarPlots, filled: Filled, plots: Plots, of: RadarTracks, i: int, decided: DecidedTracks, s: int,
    both: tuple[RadarTracks, RadarTracks], statistic: Floats, p: TrackParameters,
) -> None:  # fmt: skip
    """Put one track in: its plots get its decision, its last plot the fused place."""
    track = of.tracks[i]
    rows = track.rows
    points = points_of(of.sides[i], "mucm")
    filled.position[rows] = np.stack([points.x, points.y], axis=1)
    here = plots.usable[rows]
    filled.decision[rows] = np.where(here, decided.decision[s][i], filled.decision[rows])
    partner = decided.partner[s][i]
    lanes = np.arange(partner.size)
    other = np.maximum(partner, 0)
    if s == 0:
        number = np.full(partner.size, recording.row[rows[-1]])
        best = decided.best[i]
        filled.statistic[rows[-1]] = np.where(best >= 0, _pick(statistic[i], best), np.nan)
        filled.probability[rows[-1]] = np.where(best >= 0, _pick(decided.pairs[i], best), np.nan)
    else:
        theirs = np.array([t.rows[-1] for t in both[0].tracks], np.int64)
        number = recording.row[theirs[other]] if theirs.size else np.zeros(partner.size, np.int64)
    filled.group[rows] = np.where((partner >= 0) & here, number, 0)
    if s == 1:
        return
    for lane in lanes[partner >= 0]:
        mate = both[1].tracks[int(partner[lane])]
        time = float(min(track.steps[-1].time_s, mate.steps[-1].time_s))
        place, covariance = _mean(track, mate, time, p.acceleration_density_m2ps3, int(lane))
        filled.fused[rows[-1], :, lane] = place
        filled.covariance[rows[-1], :, lane] = covariance


def _pick(values: Floats, partner: Ints) -> Floats:
    """(L,) from (m, L)."""
    if not values.shape[0]:
        return np.full(partner.shape, np.nan)
    picked: Floats = values[np.maximum(partner, 0), np.arange(partner.size)]
    return picked


def _mean(one: Track, other: Track, time: float, density: float, lane: int) -> tuple[Floats, list[float]]:
    """Place and its covariance xx yy xy from both tracks, as if their errors were independent."""
    information, right = np.zeros((4, 4)), np.zeros(4)
    for track in (one, other):
        x, p = track.at(time, density)
        inverse = np.linalg.inv(p[:, :, lane])
        information += inverse
        right += inverse @ x[:, lane]
    covariance = np.linalg.inv(information)
    place = (covariance @ right)[list(PLACE)]
    return place, [covariance[0, 0], covariance[2, 2], covariance[0, 2]]


def _accepted_plots(plots: Plots, a: RadarTracks, b: RadarTracks, decided: DecidedTracks) -> Ints:
    """(N, 2) rows of the plots of accepted tracks at common looks."""
    out = []
    for i, track in enumerate(a.tracks):
        j = int(decided.partner[0][i, 0])
        if j < 0:
            continue
        mine = {int(plots.frame[row]): int(row) for row in track.rows if plots.usable[row, 0]}
        theirs = [int(row) for row in b.tracks[j].rows if plots.usable[row, 0]]
        out += [(mine[f], row) for row in theirs if (f := int(plots.frame[row])) in mine]
    return np.array(out, np.int64).reshape(-1, 2)


def score(recording: PolarPlots, parameters: TrackAssociationParameters, context: RunContext) -> Scores:
    """Compare the tracks after each scan, and count correct, wrong and undecided ones."""
    plots = plots_of(recording, parameters)
    first, second = chosen_radars(recording, parameters)
    a, b = (tracks_of(recording, plots, r, parameters) for r in (first, second))
    threshold = gate_threshold(parameters.alpha, DOF)
    targets = targets_of(recording)
    truth = [[int(recording.target[t.rows[0]]) for t in of.tracks] for of in (a, b)]
    parts: dict[str, list[Floats]] = {}
    time: list[float] = []
    target: list[int] = []
    for now in np.unique(recording.time_s):
        context.check_cancelled()
        started = [t for of in (a, b) for t in of.tracks if t.steps[0].time_s < now]
        if len(started) < len(a.tracks) + len(b.tracks):
            continue
        statistic, cost = track_statistics(a, b, parameters, float(now))
        decided = decide_tracks(statistic, cost, parameters)
        for i, t in enumerate(truth[0]):
            if t not in truth[1]:
                continue
            counted = _counted(statistic, decided, i, truth[1].index(t), threshold)
            counted |= _errors(recording, a, i, parameters, float(now), counted["both"])
            for name, values in counted.items():
                parts.setdefault(name, []).append(values)
            time.append(float(now))
            target.append(t)
    empty = np.empty((0, plots.lanes))
    got = {n: np.stack(parts[n]) if n in parts else empty for n in (*_NAMES, "same", "other", "stated", "stated_right")}
    both = got["both"]
    return Scores(
        (
            Tally("probability_correct", "1", got["correct"], both, curve=True, compared=True, share=True),
            Tally("probability_wrong", "1", got["wrong"], both, curve=True, compared=True, share=True),
            Tally("probability_undecided", "1", got["undecided"], both, curve=True, compared=True, share=True),
            Tally("false_rejection", "1", got["rejected"], both, curve=True, compared=True, share=True),
            Tally("assignment_correct", "1", got["assigned"], both, curve=True, compared=True, share=True),
            Tally("nis", "1", got["statistic"], DOF * both, curve=True, chi_square=True),
            Tally("nees", "1", got["nees"], DOF * both, curve=True, chi_square=True),
            Tally("radial_bias_m", "m", got["radial"], both, curve=True),
            Tally("rms_horizontal_m", "m", got["error"], both, root=True, curve=True, compared=True),
        ),
        (
            Sample("statistic_same", "1", got["same"].astype(np.float32)),
            Sample("statistic_other", "1", got["other"].astype(np.float32)),
            Sample("stated_probability", "1", got["stated"].astype(np.float32)),
            Sample("stated_right", "1", got["stated_right"].astype(np.float32)),
        ),
        np.array(time),
        np.array(target, np.int64),
        targets or ("",),
    )


_NAMES = ("both", "correct", "wrong", "undecided", "rejected", "assigned", "statistic", "nees", "radial", "error")


def _errors(
    recording: PolarPlots, of: RadarTracks, i: int, p: TrackParameters, now: float, both: Floats
) -> dict[str, Floats]:
    """Errors (L,) of one radar's track: normalised in place and velocity, along the true line of sight, and squared."""
    track = of.tracks[i]
    x, covariance = track.at(now, p.acceleration_density_m2ps3)
    if p.conversion == "polar":
        x, covariance = straight_track(until(of.times[i], of.sides[i], now), x, now)
    row = track.rows[int(np.searchsorted(of.times[i], now, side="right")) - 1]
    velocity = recording.truth_velocity_mps[row, :2]
    place = recording.truth_m[row, :2] + velocity * (now - recording.time_s[row])
    error = x - np.array([place[0], velocity[0], place[1], velocity[1]])[:, None]
    known = (both > 0) & np.isfinite(error).all(axis=0)
    matrix = np.where(known[:, None, None], np.moveaxis(covariance, 2, 0), np.eye(4))
    d = np.where(known, error, 0.0).T
    solved = np.linalg.solve(matrix, d[:, :, None])[:, :, 0]
    sight = (place - of.sides[i].site) / np.hypot(*(place - of.sides[i].site))
    return {
        "nees": d[:, 0] * solved[:, 0] + d[:, 1] * solved[:, 1] + d[:, 2] * solved[:, 2] + d[:, 3] * solved[:, 3],
        "radial": sight[0] * d[:, 0] + sight[1] * d[:, 2],
        "error": d[:, 0] ** 2 + d[:, 2] ** 2,
    }


def _counted(statistic: Floats, decided: DecidedTracks, i: int, right: int, threshold: float) -> dict[str, Floats]:
    same = statistic[i, right]
    both = np.isfinite(same)
    partner = decided.partner[0][i]
    stated = both & (decided.best[i] >= 0)
    others = np.delete(statistic[i], right, axis=0)
    nearest = np.where(np.isfinite(others), others, np.inf).min(axis=0) if len(others) else np.full(same.shape, np.inf)
    out = {
        "both": both,
        "correct": both & (partner == right),
        "wrong": both & (partner >= 0) & (partner != right),
        "undecided": both & (partner < 0),
        "rejected": both & (same > threshold),
        "assigned": both & (decided.best[i] == right),
        "statistic": np.where(both, same, 0.0),
        "same": same,
        "other": np.where(both & np.isfinite(nearest), nearest, np.nan),
        "stated": np.where(stated, _pick(decided.pairs[i], decided.best[i]), np.nan),
        "stated_right": np.where(stated, decided.best[i] == right, np.nan),
    }
    return {name: np.asarray(values, float) for name, values in out.items()}


ALGORITHM = Algorithm(
    name="track_association",
    title="Association of tracks",
    summary="Each radar filters its own plots; tracks of two radars are compared in place and velocity, with or "
    "without their cross-covariance, or by straight flights fitted to the plots of both.",
    family="identification",
    takes=("polar_plots",),
    parameters=TrackAssociationParameters,
    outputs=(*PLOT_OUTPUTS, Output("track", ("mark",), "", "number of the track of its radar, 0 = none")),
    charts=(
        "plan",
        "pairs_plan",
        "association_matrix",
        "pair_statistic",
        "trials_decisions",
        "trials_probability",
        "trials_scans",
        "trials_radial_bias",
        "trials_placement",
        "trials_statistic",
        "trials_quantiles",
        "trials_roc",
        "trials_tradeoff",
        "trials_reliability",
        "trials_consistency",
    ),
    references=(
        Reference("prosov2008"),
        Reference("barshalom2001", "section 8.4"),
        Reference("bordonaro2014"),
        Reference("more1978"),
    ),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
