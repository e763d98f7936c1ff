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

from algorithms.identification.compare import chosen_radars
from algorithms.identification.filled import Filled, joined_pairs, listed_pairs
from algorithms.identification.measures import measure
from algorithms.identification.outputs import NOT_COMPARED, PLOT_OUTPUTS
from algorithms.identification.pairs import points_of
from algorithms.identification.parameters import TrackParameters
from algorithms.identification.plots import Plots, plots_of
from algorithms.identification.registration import Accepted, hypotheses_of, notes_of
from algorithms.identification.scoring import targets_of
from algorithms.identification.tables import tabulate
from algorithms.identification.track_pairs import (
    DOF,
    DecidedTracks,
    RadarTracks,
    decide_tracks,
    track_statistics,
    tracks_of,
)
from algorithms.identification.tracks import PLACE, Track
from algorithms.recording import PolarPlots
from algorithms.result import Note, Output, Result, Setting
from algorithms.scores import Sample, Scores, Tally
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FEWEST_PLOTS = 2
# Rows that a note names one by one.
NAMED_ROWS = 20


class TrackAssociationParameters(TrackParameters):
    """What the comparison of tracks knows."""


def run(recording: PolarPlots, parameters: TrackAssociationParameters, context: RunContext) -> Result:
    """Filter, compare, and give each plot what became of its track."""
    plots = plots_of(recording, parameters)
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
    rows = tuple(np.array([t.rows[-1] for t in of.tracks], np.int64) for of in (a, b))
    total = statistic.shape[0] * statistic.shape[1]
    pairs = listed_pairs(recording, 0, (rows[0], rows[1]), statistic, decided.pairs, decided.pair_decision, total)
    hypotheses = hypotheses_of(_differences(recording, plots, a, b, decided), first, second) if plots.lanes == 1 else []
    context.progress(1.0)
    arrays: dict[str, Any] = (
        filled.arrays()
        | joined_pairs([pairs], plots.lanes)
        | {
            "row": recording.row,
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
    return Result(arrays, (*plots.notes, *_doubles(recording, a, b), *notes_of(hypotheses, plots.names)), settings)


def _doubles(recording: PolarPlots, a: RadarTracks, b: RadarTracks) -> tuple[Note, ...]:
    """Say which plots no track could take."""
    rows = np.sort(recording.row[np.concatenate([a.doubles, b.doubles])])
    if not rows.size:
        return ()
    named = ", ".join(str(row) for row in rows[:NAMED_ROWS]) + (", ..." if rows.size > NAMED_ROWS else "")
    words = f"A track has one plot at an instant; further ones of the same radar were left out: rows {named}."
    return (Note("same_instant", words, rows.size),)


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


def _differences(
    recording: PolarPlots, plots: Plots, a: RadarTracks, b: RadarTracks, decided: DecidedTracks
) -> Accepted:
    """Differences of the plots of accepted tracks at common looks, with the velocity of the first radar's track."""
    out = Accepted.nothing()
    for i, track in enumerate(a.tracks):
        j = int(decided.partner[0][i, 0])
        if j < 0:
            continue
        mine = {int(plots.frame[row]): k for k, row in enumerate(track.rows)}
        for k2, row in enumerate(b.tracks[j].rows):
            k1 = mine.get(int(plots.frame[row]))
            if k1 is None or k1 < FEWEST_PLOTS:
                continue
            p1, p2 = points_of(a.sides[i], "mucm"), points_of(b.sides[j], "mucm")
            z1, z2 = (np.array([p.x[k, 0], p.y[k, 0]]) for p, k in ((p1, k1), (p2, k2)))
            if not np.isfinite(z1 + z2).all():
                continue
            # The last state, because it knows the velocity best.
            velocity = track.steps[-1].state[[1, 3], 0]
            z2 = z2 + velocity * (recording.time_s[track.rows[k1]] - recording.time_s[row])
            spread = [sum(getattr(p, n)[k, 0] for p, k in ((p1, k1), (p2, k2))) for n in ("xx", "yy", "xy")]
            sites = (a.sides[i].site, b.sides[j].site)
            out = out.joined(
                Accepted((z1 - z2)[None], np.array([spread]), (z1 - sites[0])[None], (z2 - sites[1])[None],
                         velocity[None])
            )  # fmt: skip
    return out


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
            for name, values in _counted(statistic, decided, i, truth[1].index(t), threshold).items():
                parts.setdefault(name, []).append(values)
            time.append(float(now))
            target.append(t)
    empty = np.empty((0, plots.lanes))
    got = {n: np.stack(parts[n]) if n in parts else empty for n in (*_NAMES, "same", "other")}
    both = got["both"]
    return Scores(
        (
            Tally("probability_correct", "1", got["correct"], both, curve=True, compared=True, share=True),
            Tally("probability_wrong", "1", got["wrong"], both, curve=True, compared=True, share=True),
            Tally("probability_undecided", "1", got["undecided"], both, curve=True, compared=True, share=True),
            Tally("false_rejection", "1", got["rejected"], both, curve=True, compared=True, share=True),
            Tally("assignment_correct", "1", got["assigned"], both, curve=True, compared=True, share=True),
            Tally("nis", "1", got["statistic"], DOF * both, curve=True, chi_square=True),
        ),
        (
            Sample("statistic_same", "1", got["same"].astype(np.float32)),
            Sample("statistic_other", "1", got["other"].astype(np.float32)),
        ),
        np.array(time),
        np.array(target, np.int64),
        targets or ("",),
    )


_NAMES = ("both", "correct", "wrong", "undecided", "rejected", "assigned", "statistic")


def _counted(statistic: Floats, decided: DecidedTracks, i: int, right: int, threshold: float) -> dict[str, Floats]:
    same = statistic[i, right]
    both = np.isfinite(same)
    partner = decided.partner[0][i]
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
        "trials_base",
        "trials_placement",
        "trials_statistic",
        "trials_quantiles",
        "trials_tradeoff",
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
