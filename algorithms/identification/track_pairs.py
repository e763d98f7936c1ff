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
from algorithms.toolbox.association.exact import exact_probabilities
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.association.only_partner import SEVERAL as SEVERAL_INSIDE
from algorithms.toolbox.association.only_partner import only_partners
from algorithms.toolbox.association.probabilities import association_probabilities
from algorithms.toolbox.association.track_distance import DOF, track_distances

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WIDE_TAIL = 1e-6
# n m 2^m of tracks up to which all trials are summed side by side; beyond, trial by trial and group by group.
SIDE_BY_SIDE = 4_000_000
# Ln of how much less likely two tracks without a partner are than a pair: as many pairs as the gate allows are made.
PAIR_BONUS = 150.0


@dataclass(frozen=True)
class RadarTracks:
    """Tracks of one radar with their plots and instants, and the rows left out because their track has that instant."""

    radar: int
    tracks: list[Track]
    sides: list[Side]
    times: list[Floats]
    repeated: Ints


def tracks_of(recording: PolarPlots, plots: Plots, radar: int, p: TrackParameters) -> RadarTracks:
    """Filter each target's plots; those without a name are joined first."""
    mine = plots.radar == radar
    unnamed = np.array([name == "" for name in recording.targets])[recording.target] & mine
    rows = [
        np.flatnonzero(mine & (recording.target == t))
        for t, name in enumerate(recording.targets)
        if name not in ("", CLUTTER)
    ]
    if unnamed.any():
        points = points_of(side_of(plots, radar, np.arange(len(recording))), "mucm")
        place = np.stack([points.x[:, 0], points.y[:, 0]], axis=1)
        covariance = np.stack([points.xx[:, 0], points.yy[:, 0], points.xy[:, 0]], axis=1)
        looks = [look.rows[radar][unnamed[look.rows[radar]]] for look in plots.looks]
        rows += linked(looks, recording.time_s, place, covariance, p.max_speed_mps)
    usable = np.asarray(plots.usable.any(axis=1))
    all_rows = [r for r in rows if r.size]
    rows = [_once_each(recording.time_s, usable, r) for r in all_rows]
    kept = np.zeros(len(recording), np.bool_)
    for r in rows:
        kept[r] = True
    repeated = np.array([row for r in all_rows for row in r if not kept[row]], np.int64)
    sides = [side_of(plots, radar, r) for r in rows]
    times = [recording.time_s[r] for r in rows]
    made = [
        filtered(r, t, s, p.conversion, p.acceleration_density_m2ps3)
        for r, t, s in zip(rows, times, sides, strict=True)
    ]
    return RadarTracks(radar, made, sides, times, repeated)


def _once_each(time_s: Floats, usable: NDArray[np.bool_], rows: Ints) -> Ints:
    """Plots at rising instants: of several at one instant the first usable one, because a track is at one place."""
    order = np.lexsort((rows, ~usable[rows], time_s[rows]))
    sorted_rows = rows[order]
    keep = np.concatenate([[True], np.diff(time_s[sorted_rows]) > 0])
    once: Ints = sorted_rows[keep]
    return once


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
    s, log_det = track_distances(d, matrix)
    if p.conversion == "polar":
        flights = tuple(until(t, side, time) for t, side in zip(times, sides, strict=True))
        s = likelihood_ratio(flights[0], flights[1], (x1, x2), time)
    cost = s / 2 + log_det / 2 + 2 * np.log(2 * np.pi)
    return np.where(known, s, np.nan), np.where(known, cost, np.nan)


def until(times: Floats, side: Side, time: float) -> Flight:
    """Return the plots up to an instant."""
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
    ranked_groups: int = 0
    truncation: float = 0.0
    split: bool = False


def decide_tracks(statistic: Floats, cost: Floats, p: TrackParameters) -> DecidedTracks:
    """Decide by the threshold or by the most likely matching, from statistics and costs (n, m, L)."""
    n, m, lanes = statistic.shape
    score = np.where(statistic <= gate_threshold(WIDE_TAIL, DOF), PAIR_BONUS - cost, -np.inf)
    split = min(n, m) > p.exact_plots
    ranked, truncation = 0, 0.0
    if not split and n * m * 2 ** min(n, m) <= SIDE_BY_SIDE:
        pairs, _ = exact_probabilities(score)
    else:
        found = [association_probabilities(score[:, :, k], exact_columns=p.exact_plots) for k in range(lanes)]
        pairs = np.stack([one.pairs for one in found], axis=2)
        ranked, truncation = sum(one.ranked_groups for one in found), max(one.truncation for one in found)
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
    return DecidedTracks((partner, back), (word, reply), decision, pairs, best, several, ranked, truncation, split)


def _of(values: Floats, partner: Ints) -> Floats:
    if not values.shape[1]:
        return np.full(partner.shape, np.nan)
    taken: Floats = np.take_along_axis(values, np.maximum(partner, 0)[:, None], axis=1)[:, 0]
    return np.where(partner >= 0, taken, np.nan)
