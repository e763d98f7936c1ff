"""Tracks of two radars and all their pairs: statistics, probabilities, decisions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.compare import pair_decisions, partners_both_ways, side_of
from algorithms.identification.linking import linked
from algorithms.identification.outputs import ACCEPTED, ALONE, SEVERAL, UNDECIDED
from algorithms.identification.pairs import Side, points_of
from algorithms.identification.parameters import TrackParameters
from algorithms.identification.plots import Plots
from algorithms.identification.scenario import CLUTTER
from algorithms.identification.straight import Flight, likelihood_ratio
from algorithms.identification.tracks import Track, cross_covariance, filtered
from algorithms.recording import PolarPlots
from algorithms.toolbox.association.assignment import most_likely_matching
from algorithms.toolbox.association.exact import EXACT_COLUMNS, exact_probabilities
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.association.only_partner import SEVERAL as SEVERAL_INSIDE
from algorithms.toolbox.association.only_partner import only_partners
from algorithms.toolbox.association.probabilities import association_probabilities

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DOF = 4
WIDE_TAIL = 1e-6
# Ln of how much less likely two tracks without a partner are than a pair: as many pairs as the gate allows are made.
PAIR_BONUS = 150.0


@dataclass(frozen=True)
class RadarTracks:
    """Tracks of one radar with their plots and instants."""

    radar: int
    tracks: list[Track]
    sides: list[Side]
    times: list[Floats]
    doubles: Ints
    """Plots that were left out because their track has another one at the same instant."""


def tracks_of(recording: PolarPlots, plots: Plots, radar: int, p: TrackParameters) -> RadarTracks:
    """Filter each target's plots; without names, the plots are joined first."""
    named = [i for i, name in enumerate(recording.targets) if name not in ("", CLUTTER)]
    mine = plots.radar == radar
    if named:
        rows = [np.flatnonzero(mine & (recording.target == t)) for t in named]
    else:
        points = points_of(side_of(plots, radar, np.arange(len(recording))), "mucm")
        place = np.stack([points.x[:, 0], points.y[:, 0]], axis=1)
        covariance = np.stack([points.xx[:, 0], points.yy[:, 0], points.xy[:, 0]], axis=1)
        looks = [look.rows[radar] for look in plots.looks]
        rows = linked(looks, recording.time_s, place, covariance, p.max_speed_mps)
    parted = [_once_each(recording, r) for r in rows if r.size]
    rows = [once for once, _ in parted]
    doubles = np.concatenate([again for _, again in parted]) if parted else np.empty(0, np.int64)
    sides = [side_of(plots, radar, r) for r in rows]
    times = [recording.time_s[r] for r in rows]
    made = [
        filtered(r, t, s, p.conversion, p.acceleration_density_m2ps3)
        for r, t, s in zip(rows, times, sides, strict=True)
    ]
    return RadarTracks(radar, made, sides, times, doubles)


def _once_each(recording: PolarPlots, rows: Ints) -> tuple[Ints, Ints]:
    """Part plots into the first of each instant and the others: a track moves between its plots."""
    time = recording.time_s[rows]
    keep = np.concatenate([[True], np.diff(time) > 0])
    return rows[keep], rows[~keep]


def track_statistics(
    a: RadarTracks, b: RadarTracks, p: TrackParameters, until_s: float | None
) -> tuple[Floats, Floats]:
    """(n, m, L) statistics and costs of all pairs of tracks, at `until_s` or where the first of the two ends."""
    lanes = a.sides[0].range_m.shape[1] if a.sides else b.sides[0].range_m.shape[1] if b.sides else 0
    statistic = np.full((len(a.tracks), len(b.tracks), lanes), np.nan)
    cost = np.full(statistic.shape, np.nan)
    for i, one in enumerate(a.tracks):
        for j, other in enumerate(b.tracks):
            time = until_s if until_s is not None else min(one.steps[-1].time_s, other.steps[-1].time_s)
            if time < max(one.steps[0].time_s, other.steps[0].time_s):
                continue
            statistic[i, j], cost[i, j] = _compared(
                (one, other), (a.sides[i], b.sides[j]), (a.times[i], b.times[j]), p, time
            )
    return statistic, cost


def _compared(
    tracks: tuple[Track, Track], sides: tuple[Side, Side], times: tuple[Floats, Floats], p: TrackParameters, time: float
) -> tuple[Floats, Floats]:
    """(L,) statistic and cost of one pair."""
    density = p.acceleration_density_m2ps3
    (x1, p1), (x2, p2) = (t.at(time, density) for t in tracks)
    c = p1 + p2
    if p.cross_covariance:
        p12 = cross_covariance(tracks[0], tracks[1], time, density)
        c = c - p12 - np.swapaxes(p12, 0, 1)
    known = np.isfinite(x1[0]) & np.isfinite(x2[0])
    matrix = np.where(known[:, None, None], np.moveaxis(c, 2, 0), np.eye(4))
    d = np.where(known, x1 - x2, 0.0).T
    solved = np.linalg.solve(matrix, d[:, :, None])[:, :, 0]
    s = d[:, 0] * solved[:, 0] + d[:, 1] * solved[:, 1] + d[:, 2] * solved[:, 2] + d[:, 3] * solved[:, 3]
    _, log_det = np.linalg.slogdet(matrix)
    if p.conversion == "polar":
        flights = tuple(_until(t, side, time) for t, side in zip(times, sides, strict=True))
        s = likelihood_ratio(flights[0], flights[1], (x1, x2), time)
    cost = s / 2 + log_det / 2 + 2 * np.log(2 * np.pi)
    return np.where(known, s, np.nan), np.where(known, cost, np.nan)


def _until(times: Floats, side: Side, time: float) -> Flight:
    n = int(np.searchsorted(times, time, side="right"))
    return Flight(times[:n], side._replace(range_m=side.range_m[:n], angle_rad=side.angle_rad[:n]))


@dataclass(frozen=True)
class DecidedTracks:
    """As `filled.Decided`, for n and m tracks; `best` and `several` of the first radar's tracks."""

    partner: tuple[Ints, Ints]
    decision: tuple[Ints, Ints]
    pair_decision: Ints
    pairs: Floats
    best: Ints
    several: NDArray[np.bool_]


def decide_tracks(statistic: Floats, cost: Floats, p: TrackParameters) -> DecidedTracks:
    """Decide by the threshold or by the most likely matching, from statistics and costs (n, m, L)."""
    n, m, lanes = statistic.shape
    score = np.where(statistic <= gate_threshold(WIDE_TAIL, DOF), PAIR_BONUS - cost, -np.inf)
    if min(n, m) <= EXACT_COLUMNS:
        pairs, _ = exact_probabilities(score)
    else:
        pairs = np.stack([association_probabilities(score[:, :, k]).pairs for k in range(lanes)], axis=2)
    best = np.full((n, lanes), -1)
    for lane in range(lanes):
        best[:, lane] = most_likely_matching(score[:, :, lane])
    several = np.zeros((n, lanes), np.bool_)
    if p.decision == "threshold":
        own = only_partners(statistic, gate_threshold(p.alpha, DOF))
        word = np.where(own >= 0, ACCEPTED, np.where(own == SEVERAL_INSIDE, SEVERAL, ALONE))
        several = own == SEVERAL_INSIDE
        partner = np.where(own >= 0, own, -1)
        listed = partner
    else:
        sure = _of(pairs, best) >= p.p_min if p.decision == "posterior" else best >= 0
        word = np.where(best < 0, ALONE, np.where(sure, ACCEPTED, UNDECIDED))
        several = word == UNDECIDED
        partner = np.where(word == ACCEPTED, best, -1)
        listed = best
    others = partners_both_ways(listed, m)
    reply = np.full((m, lanes), ALONE)
    for j in range(m if n else 0):
        reply[j] = np.where(others[j] >= 0, word[np.maximum(others[j], 0), np.arange(lanes)], ALONE)
    back = np.where(reply == ACCEPTED, others, -1)
    decision = pair_decisions(statistic.shape, listed, word)
    return DecidedTracks((partner, back), (word, reply), decision, pairs, best, several)


def _of(values: Floats, partner: Ints) -> Floats:
    if not values.shape[1]:
        return np.full(partner.shape, np.nan)
    taken: Floats = np.take_along_axis(values, np.maximum(partner, 0)[:, None], axis=1)[:, 0]
    return np.where(partner >= 0, taken, np.nan)
