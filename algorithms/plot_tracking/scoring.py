"""What is counted of tracks against the truth, scan by scan and target by target (specification 8).

Continuity, set distances and what depends on a settled track count from ten periods after a target's appearance on.
A confirmed track is *false* where it belongs to a target for less than 30 % of its life. A *switch* is a target's track
with another number than its track before. A manoeuvre begins where the true velocity changes by more than 0.5 m/s2, and
is detected where the tracker calls one before 30 s after its end. Of several radars each counts by itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.calibration import INNER, MIDDLE_ONE, NO_CLASS, OUTER, gate_classes
from algorithms.plot_tracking.outputs import MANOEUVRE, MIDDLE, UPDATED
from algorithms.plot_tracking.purity import purity_counts
from algorithms.plot_tracking.truth import Matched, matched
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.scores import Sample, Scores, Tally
from algorithms.toolbox.motion.curvature import wrapped

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SETTLED_SCANS = 10
FALSE_BELOW = 0.3
MANOEUVRE_MPS2 = 0.5
DETECTED_WITHIN_S = 30.0


def settled(m: Matched) -> NDArray[np.bool_]:
    """(S, K) whether a target is there, and has been for ten scans of the radar."""
    there = np.isfinite(m.truth.position_m[:, :, 0])
    out = np.zeros(there.shape, np.bool_)
    for scans in m.radars():
        out[scans] = there[scans] & (np.cumsum(there[scans], axis=0) > SETTLED_SCANS)
    return out


def switches(m: Matched, number: Ints) -> Ints:
    """(S, K, L) 1 where a target's track has another number than the last one it had."""
    scans, targets, lanes = m.estimate.shape
    out = np.zeros(m.estimate.shape, np.int64)
    last = np.zeros((targets, lanes), np.int64)
    for s in range(scans):
        if s and m.radar[s] != m.radar[s - 1]:
            last[:] = 0
        has = m.estimate[s] >= 0
        now = np.where(has, number[np.maximum(m.estimate[s], 0)] if number.size else 0, 0)
        out[s] = has & (last > 0) & (now != last)
        last = np.where(has, now, last)
    return out


def track_shares(m: Matched, arrays: dict[str, Any]) -> tuple[Ints, Ints, Ints, Floats]:
    """Trial and number of each confirmed track, its target of most scans (-1 = none), and its matched share."""
    key = np.stack([arrays["estimate_trial"], arrays["estimate_track"]])
    tracks, index = np.unique(key, axis=1, return_inverse=True)
    index = index.ravel()
    life = np.bincount(index, minlength=tracks.shape[1]).astype(float)
    targets = len(m.truth.names)
    own = np.zeros((tracks.shape[1], targets))
    has = m.owner >= 0
    np.add.at(own, (index[has], m.owner[has]), 1)
    best = own.argmax(axis=1) if targets else np.zeros(tracks.shape[1], np.int64)
    share = own.sum(axis=1) / np.maximum(life, 1)
    return tracks[0], tracks[1], np.where(own.sum(axis=1) > 0, best, -1), share


def manoeuvres(m: Matched, time_s: Floats) -> list[tuple[int, int, int]]:
    """Target, and the scans between which it manoeuvres: the first with the old velocity, the last with a change."""
    out = []
    for scans in m.radars():
        dt = np.diff(time_s[scans])[:, None]
        changes = np.linalg.norm(np.diff(m.truth.velocity_mps[scans], axis=0), axis=2) / np.maximum(dt, 1e-9)
        for k in range(changes.shape[1]):
            at = np.flatnonzero(changes[:, k] > MANOEUVRE_MPS2)
            parts = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size else []
            out += [(k, int(scans[part[0]]), int(scans[part[-1] + 1])) for part in parts]
    return out


def score_result(recording: PolarPlots, result: Result) -> Scores:
    """Count everything; one instant for each scan and target."""
    a: dict[str, Any] = dict(result.arrays)
    lanes = a["decision"].shape[1]
    time = a["scan_time_s"]
    m = matched(recording, a, lanes)
    if m is None:
        return Scores(tuple(_without_truth(a, lanes, time.size)))
    scan, target = instants(m)
    e = m.estimate[scan, target]
    has = e >= 0
    at = np.maximum(e, 0)

    def of(values: Floats, fill: float = 0.0) -> Floats:
        """(T, L) values of the matched estimates."""
        if not values.size:
            return np.full(e.shape, fill)
        return np.where(has, np.nan_to_num(values[at], nan=fill), fill)

    known = has.astype(float)
    place = of((m.error_m**2).sum(axis=1))
    velocity = of((m.error_mps**2).sum(axis=1))
    state = a["estimate_state"]
    speed, course = _speed_and_course(m, state, at, scan, target)
    xx, yy, xy = (of(a["estimate_covariance"][:, i]) for i in range(3))
    ex, ey = (of(m.error_m[:, i]) for i in range(2))
    determinant = xx * yy - xy * xy
    sound = has & (determinant > 0)
    nees = np.where(sound, (yy * ex**2 - 2 * xy * ex * ey + xx * ey**2) / np.where(sound, determinant, 1.0), 0.0)
    calls = manoeuvre_calls(m, a)
    ellipse = _of_plots(a, gate_classes(a), e, NO_CLASS)
    outside = has & (a["estimate_outside"][at] >= 0) if a["estimate_outside"].size else np.zeros(e.shape, bool)
    followed = ((ellipse >= 0) | outside).astype(float)
    late = settled(m)[scan, target].astype(float)[:, None] * np.ones(lanes)
    sets = _set_tallies(m, scan, lanes)
    tallies = [
        Tally("rms_horizontal_m", "m", place, known, root=True, curve=True, compared=True),
        Tally("rms_velocity_mps", "m/s", velocity, known, root=True, compared=True),
        Tally("rms_speed_mps", "m/s", np.where(has, speed**2, 0.0), known, root=True, compared=True),
        Tally("rms_course_deg", "deg", np.where(has, np.degrees(course) ** 2, 0.0), known, root=True, compared=True),
        Tally("claimed_horizontal_m", "m", xx + yy, known, root=True, curve=True),
        Tally("nees", "1", nees, np.where(sound, 2.0, 0.0), curve=True, chi_square=True),
        Tally("tracked_share", "1", known * late, late, curve=True, compared=True, share=True),
        *sets,
        Tally("inner_share", "1", (ellipse == INNER).astype(float), followed, share=True),
        Tally("middle_share", "1", (ellipse == MIDDLE_ONE).astype(float), followed, share=True),
        Tally("outer_share", "1", (ellipse == OUTER).astype(float), followed, share=True),
        Tally("outside_share", "1", outside.astype(float), followed, share=True),
        Tally("manoeuvre_share", "1", calls.called, calls.followed, compared=True, share=True),
        Tally("manoeuvre_false_share", "1", calls.called * calls.steady, calls.followed * calls.steady, share=True),
        Tally("manoeuvre_detected", "1", calls.detected, calls.onset, compared=True, share=True),
        *_per_trial(m, a, lanes, time.size),
        _purity(recording, a),
    ]
    samples = (
        Sample("horizontal_m", "m", np.sqrt(np.where(has, place, np.nan)).astype(np.float32)),
        Sample("manoeuvre_delay_s", "s", calls.delay_s.astype(np.float32)),
    )
    return Scores(tuple(tallies), samples, time[scan], target, m.truth.names)


def _speed_and_course(m: Matched, state: Floats, at: Ints, scan: Ints, target: Ints) -> tuple[Floats, Floats]:
    """Errors of speed in m/s and of course in rad, (T, L)."""
    if not state.size:
        return np.zeros(at.shape), np.zeros(at.shape)
    v = state[at][..., 2:]
    true = v - m.error_mps[at]
    speed = np.hypot(v[..., 0], v[..., 1]) - np.hypot(true[..., 0], true[..., 1])
    course = wrapped(np.arctan2(v[..., 0], v[..., 1]) - np.arctan2(true[..., 0], true[..., 1]))
    return np.nan_to_num(speed), np.nan_to_num(course)


def _of_plots(a: dict[str, Any], values: Ints, e: Ints, none: int) -> Ints:
    """(T, L) values (M, L) of the plot of each matched estimate; `none` where it has none."""
    if not a["estimate_mark"].size:
        return np.full(e.shape, none)
    mark = np.where(e >= 0, a["estimate_mark"][np.maximum(e, 0)], -1)
    lane = np.broadcast_to(np.arange(e.shape[1]), e.shape)
    return np.where(mark >= 0, values[np.maximum(mark, 0), lane], none)


def _set_tallies(m: Matched, scan: Ints, lanes: int) -> list[Tally]:
    """Distances of the sets of all tracks and targets, each once in a scan: at its first target."""
    first = np.concatenate([[True], np.diff(scan) > 0]) if scan.size else np.empty(0, bool)
    of_radar = np.zeros(m.radar.size, np.int64)
    for scans in m.radars():
        of_radar[scans] = np.arange(scans.size)
    since = first & (of_radar[scan] >= SETTLED_SCANS)
    weight = since.astype(float)[:, None] * np.ones(lanes)

    def of(name: str) -> Floats:
        values = np.stack([getattr(d, name) for d in m.distances]) if m.distances else np.empty((0, lanes))
        weighted: Floats = values[scan] * weight
        return weighted

    return [
        Tally("ospa_m", "m", of("ospa_m"), weight, curve=True, compared=True),
        Tally("gospa_m", "m", of("gospa_m"), weight, curve=True, compared=True),
        Tally("gospa_localisation_m", "m", of("localisation"), weight, root=True),
        Tally("gospa_missed", "1", of("missed"), weight),
        Tally("gospa_false", "1", of("false"), weight),
    ]


@dataclass(frozen=True)
class Calls:
    """When a tracker called a manoeuvre and when there was one; arrays (T, L) over scans and targets.

    Attributes
    ----------
    followed, called : 1 where a plot in the tracking gate continued the target's track; where it showed a manoeuvre
    steady : 1 where no true manoeuvre is on, nor ended less than 30 s ago
    onset, detected : 1 at the begin of a true manoeuvre; 1 there where it was detected
    delay_s : there, how long after; else NaN
    """

    followed: Floats
    called: Floats
    steady: Floats
    onset: Floats
    detected: Floats
    delay_s: Floats


def instants(m: Matched) -> tuple[Ints, Ints]:
    """(T,) scan and target of everything that could be tracked."""
    scan, target = np.nonzero(np.isfinite(m.truth.position_m[:, :, 0]))
    return scan, target


def manoeuvre_calls(m: Matched, a: dict[str, Any]) -> Calls:
    """Hold what the tracker called a manoeuvre against the truth."""
    time = a["scan_time_s"]
    scan, target = instants(m)
    decision = _of_plots(a, a["decision"], m.estimate[scan, target], 0)
    onset, detected, steady = (np.full(decision.shape, v) for v in (0.0, 0.0, 1.0))
    delay = np.full(decision.shape, np.nan)
    for k, begin, end in manoeuvres(m, time):
        row = np.flatnonzero((target == k) & (scan == begin))
        inside = np.flatnonzero(
            (target == k)
            & (scan > begin)
            & (m.radar[scan] == m.radar[begin])
            & (time[scan] <= time[end] + DETECTED_WITHIN_S)
        )
        if not (row.size and inside.size):
            continue
        steady[inside] = 0.0
        called = decision[inside] == MANOEUVRE
        onset[row[0]] = 1.0
        found = called.any(axis=0)
        detected[row[0]] = found
        delay[row[0]] = np.where(found, time[scan[inside]][called.argmax(axis=0)] - time[begin], np.nan)
    followed = np.isin(decision, (UPDATED, MIDDLE, MANOEUVRE)).astype(float)
    return Calls(followed, (decision == MANOEUVRE).astype(float), steady, onset, detected, delay)


def _per_trial(m: Matched, a: dict[str, Any], lanes: int, scans: int) -> list[Tally]:
    lane, _, _, share = track_shares(m, a)
    false = np.bincount(lane[share < FALSE_BELOW], minlength=lanes).astype(float)
    switched = switches(m, a["estimate_track"]).sum(axis=(0, 1)).astype(float)
    one = np.ones(lanes)
    targets = float(len(m.truth.names))
    return [
        Tally("switches_per_target", "1", switched, targets * one, compared=True),
        Tally("false_tracks_per_scan", "1", false, max(scans, 1) * one, compared=True),
    ]


def _purity(recording: PolarPlots, a: dict[str, Any]) -> Tally:
    own, of_all = purity_counts(recording, a)
    return Tally("purity", "1", own.astype(float), of_all.astype(float), compared=True, share=True)


def _without_truth(a: dict[str, Any], lanes: int, scans: int) -> list[Tally]:
    """Where there is no target at all every confirmed track is false."""
    key = np.unique(np.stack([a["estimate_trial"], a["estimate_track"]]), axis=1)
    false = np.bincount(key[0], minlength=lanes).astype(float)
    return [Tally("false_tracks_per_scan", "1", false, max(scans, 1) * np.ones(lanes), compared=True)]
