"""Tracks of several sensors that are one target: found by comparing them wherever they live at the same time.

At every estimate of a track, those of other sensors are carried to its instant along a straight line, and the distance
S of place and velocity is taken (four degrees of freedom). Two tracks are compared by the mean of S over all instants
that they have in common; errors of a track hang together over some instants, so that n of them count as n / 8. A
difference is counted as at most `FARTHEST`: a moment far apart must not decide alone. The sensors are joined one after
the other: as many tracks as can be, and of those ways the one with the least sum of mean S + ln det C. A sensor may
have several tracks of a target one after the other, but not two at once. What is left after that is joined pair by
pair, the nearest first.

The joint place and velocity take the errors of the tracks for independent. They are not quite: a target's manoeuvre
surprises all of its tracks at once, and there the joint errors are larger than said.

References
----------
barshalom2001, section 8.4.

Differences from the paper
--------------------------
plots2006 has one radar.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.association.sparse import most_pairs_at_least_cost, pairs_within
from algorithms.toolbox.association.track_distance import DOF, track_distances

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Probability that two tracks of one target are not joined.
TAIL = 1e-4
# So many instants in a row have about one independent error.
HANGS_TOGETHER = 8.0
FEWEST_COMMON = 3
FARTHEST = 30.0
# Two estimates farther apart in time than so many periods say nothing of each other.
LONGEST_STEP = 1.0


@dataclass(frozen=True)
class Estimates:
    """Estimates of the tracks of all sensors, E of them.

    Attributes
    ----------
    lane, track, sensor : (E,) trial; number of the track, different for each in a trial; number of the sensor
    time_s : (E,)
    state : (E, 4) east, north m and their velocities m/s, in one frame
    covariance : (E, 4, 4)
    identity : (E,) of the track's target where it said one, -1 = unknown
    """

    lane: Ints
    track: Ints
    sensor: Ints
    time_s: Floats
    state: Floats
    covariance: Floats
    identity: Ints


@dataclass(frozen=True)
class Comparison:
    """Pairs of tracks that were compared, K of them.

    Attributes
    ----------
    lane, first, second : (K,) trial and numbers of the tracks
    common : (K,) instants that both have
    statistic, threshold : (K,) mean S and what it may be
    same : (K,) whether the two were joined
    """

    lane: Ints
    first: Ints
    second: Ints
    common: Ints
    statistic: Floats
    threshold: Floats
    same: NDArray[np.bool_]


@dataclass(frozen=True)
class Joined:
    """What is one target.

    Attributes
    ----------
    number : (E,) of the joint track: the least number of its tracks
    state, covariance : (E, 4), (E, 4, 4) from all tracks of the joint one at this instant
    tracks : (E,) how many those are
    compared : the pairs
    """

    number: Ints
    state: Floats
    covariance: Floats
    tracks: Ints
    compared: Comparison


def join(e: Estimates, period_s: Floats, sd_acceleration_mps2: float, registration_m: float = 0.0) -> Joined:
    """Find the joint tracks.

    Parameters
    ----------
    period_s : (sensors,)
    sd_acceleration_mps2 : by which targets leave the straight line between two instants
    registration_m : standard deviation of the sensors' places and zeros against each other, in each axis
    """
    at, other, state, covariance = _met(e, period_s, sd_acceleration_mps2, registration_m)
    extra = np.zeros((4, 4))
    extra[0, 0] = extra[1, 1] = registration_m**2
    s, log_det = track_distances(e.state[at] - state, e.covariance[at] + covariance + extra)
    tracks = _tracks(e)
    sums = _sums(e, tracks, at, other, s, log_det, period_s)
    group, compared = _grouped(e, tracks, sums)
    same = group[tracks.of[at]] == group[tracks.of[other]]
    least = np.full(group.max(initial=-1) + 1, np.iinfo(np.int64).max)
    np.minimum.at(least, group, tracks.number)
    fused = _fused(e, at[same], state[same], covariance[same] + extra)
    return Joined(least[group][tracks.of], *fused, compared)


def _met(e: Estimates, period_s: Floats, sd: float, shift: float) -> tuple[Ints, Ints, Floats, Floats]:
    """Estimates and those of other sensors near them; state and covariance of these at the instants of the first."""
    rows = {int(sensor): np.flatnonzero(e.sensor == sensor) for sensor in np.unique(e.sensor)}
    parts = [_near(e, rows[one], rows[two], float(period_s[two]), shift) for one in rows for two in rows if two != one]
    at = np.concatenate([np.empty(0, np.int64), *(p[0] for p in parts)])
    other = np.concatenate([np.empty(0, np.int64), *(p[1] for p in parts)])
    dt = e.time_s[at] - e.time_s[other]
    step = np.tile(np.eye(4), (dt.size, 1, 1))
    step[:, 0, 2] = step[:, 1, 3] = dt
    state = np.einsum("kij,kj->ki", step, e.state[other])
    noise = np.zeros_like(step)
    for i in range(2):
        noise[:, i, i] = dt**4 / 4
        noise[:, i, i + 2] = noise[:, i + 2, i] = dt**3 / 2
        noise[:, i + 2, i + 2] = dt**2
    covariance = step @ e.covariance[other] @ step.swapaxes(1, 2) + sd**2 * noise
    return at, other, state, covariance


def _near(e: Estimates, mine: Ints, theirs: Ints, period_s: float, shift: float) -> tuple[Ints, Ints]:
    """Estimates of two sensors that are near each other: of each other track the one that is nearest in time."""
    if not mine.size or not theirs.size:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    theirs = theirs[np.lexsort((e.time_s[theirs], e.lane[theirs]))]
    window = LONGEST_STEP * period_s
    i, j = pairs_within(
        e.lane[mine], e.time_s[mine] - window, e.time_s[mine] + window, e.lane[theirs], e.time_s[theirs]
    )
    at, other = mine[i], theirs[j]
    dt = e.time_s[at] - e.time_s[other]
    away = e.state[at, :2] - e.state[other, :2] - dt[:, None] * e.state[other, 2:]
    spread = sum(e.covariance[k, 0, 0] + e.covariance[k, 1, 1] for k in (at, other))
    moved = dt**2 * (e.covariance[other, 2, 2] + e.covariance[other, 3, 3])
    near = (away**2).sum(axis=1) <= FARTHEST * (spread + moved + 2 * shift**2)
    at, other, dt = at[near], other[near], np.abs(dt[near])
    order = np.lexsort((dt, e.track[other], at))
    at, other = at[order], other[order]
    first = np.ones(at.size, bool)
    first[1:] = (at[1:] != at[:-1]) | (e.track[other[1:]] != e.track[other[:-1]])
    return at[first], other[first]


@dataclass(frozen=True)
class _Tracks:
    """Tracks of all sensors, and of which each estimate is (E,)."""

    of: Ints
    lane: Ints
    number: Ints
    sensor: Ints
    begin: Floats
    end: Floats
    identity: Ints


def _tracks(e: Estimates) -> _Tracks:
    key, of = np.unique(np.stack([e.lane, e.track]), axis=1, return_inverse=True)
    of, size = of.ravel(), key.shape[1]
    begin, end = np.full(size, np.inf), np.full(size, -np.inf)
    np.minimum.at(begin, of, e.time_s)
    np.maximum.at(end, of, e.time_s)
    sensor, identity = np.zeros(size, np.int64), np.full(size, -1)
    sensor[of] = e.sensor
    np.maximum.at(identity, of, e.identity)
    return _Tracks(of, key[0], key[1], sensor, begin, end, identity)


@dataclass(frozen=True)
class _Sums:
    """Of pairs of tracks (a before b): instants in common, sums of S and of ln det C over them."""

    a: Ints
    b: Ints
    common: Ints
    statistic: Floats
    log_det: Floats


def _sums(e: Estimates, tracks: _Tracks, at: Ints, other: Ints, s: Floats, log_det: Floats, period_s: Floats) -> _Sums:
    """Sums over the instants; those at which the two were too far apart to be met count as farthest."""
    # Each pair of sensors is looked at from the one side only: from the later sensor.
    once = e.sensor[at] > e.sensor[other]
    a, b = tracks.of[other[once]], tracks.of[at[once]]
    pairs, index = np.unique(np.stack([a, b]), axis=1, return_inverse=True)
    index, size = index.ravel(), pairs.shape[1]
    met = np.bincount(index, minlength=size)
    near = np.bincount(index, weights=np.minimum(s[once], FARTHEST), minlength=size)
    a, b = pairs
    window = LONGEST_STEP * period_s[tracks.sensor[a]]
    order = np.lexsort((e.time_s, tracks.of))
    begins = np.searchsorted(tracks.of[order], np.arange(tracks.number.size))
    common = np.zeros(size, np.int64)
    counts = np.bincount(tracks.of, minlength=tracks.number.size)
    low = np.maximum(tracks.begin[a] - window, tracks.begin[b])
    high = np.minimum(tracks.end[a] + window, tracks.end[b])
    for k in range(size):
        times = e.time_s[order[begins[b[k]] : begins[b[k]] + counts[b[k]]]]
        common[k] = np.searchsorted(times, high[k], "right") - np.searchsorted(times, low[k], "left")
    common = np.maximum(common, met)
    return _Sums(
        a,
        b,
        common,
        near + FARTHEST * (common - met),
        np.bincount(index, weights=log_det[once], minlength=size) / np.maximum(met, 1) * common,
    )


def _threshold(common: Ints | Floats) -> Floats:
    """Mean S that a true pair exceeds with `TAIL`, from so many instants."""
    independent = np.maximum(np.round(np.asarray(common, float) / HANGS_TOGETHER), 1.0)
    values, index = np.unique(independent, return_inverse=True)
    table = np.array([gate_threshold(TAIL, int(DOF * n)) / n for n in values])
    out: Floats = table[index.ravel()] if values.size else np.empty(0)
    return out


def _grouped(e: Estimates, tracks: _Tracks, sums: _Sums) -> tuple[Ints, Comparison]:
    """Group of each track, and what was decided about each pair."""
    group = np.arange(tracks.number.size)
    one, two = tracks.identity[sums.a], tracks.identity[sums.b]
    contrary = (one >= 0) & (two >= 0) & (one != two)
    usable = (sums.common >= FEWEST_COMMON) & ~contrary
    # Sensor by sensor, each of its tracks to one group; then what is left, the nearest first.
    for sensor in np.unique(tracks.sensor)[1:]:
        mine = usable & (tracks.sensor[sums.b] == sensor)
        while _step(tracks, sums, group, mine, all_at_once=True):
            pass
    while _step(tracks, sums, group, usable, all_at_once=False):
        pass
    _, group = np.unique(group, return_inverse=True)
    group = group.ravel()
    compared = Comparison(
        tracks.lane[sums.a],
        tracks.number[sums.a],
        tracks.number[sums.b],
        sums.common,
        sums.statistic / np.maximum(sums.common, 1),
        _threshold(sums.common),
        group[sums.a] == group[sums.b],
    )
    return group, compared


def _step(tracks: _Tracks, sums: _Sums, group: Ints, usable: NDArray[np.bool_], *, all_at_once: bool) -> bool:
    """Join groups by the best assignment, or the two nearest ones; False where none can be joined."""
    g, h = group[sums.a], group[sums.b]
    usable = usable & (g != h)
    if all_at_once:
        # Tracks that are in a group already stay there.
        usable &= h == sums.b
    at = np.flatnonzero(usable)
    if not at.size:
        return False
    both = np.stack([g[at], h[at]])
    pairs, index = np.unique(both if all_at_once else np.sort(both, axis=0), axis=1, return_inverse=True)
    index, size = index.ravel(), pairs.shape[1]
    common = np.bincount(index, weights=sums.common[at], minlength=size)
    mean = np.bincount(index, weights=sums.statistic[at], minlength=size) / common
    cost = mean + np.bincount(index, weights=sums.log_det[at], minlength=size) / common
    good = mean <= _threshold(common)
    good[good] = [_apart(tracks, group, *pairs[:, k]) for k in np.flatnonzero(good)]
    where = np.flatnonzero(good)
    if not where.size:
        return False
    if all_at_once:
        chosen = where[most_pairs_at_least_cost(pairs[0, where], pairs[1, where], cost[where])]
    else:
        chosen = where[[int(np.argmin(cost[where]))]]
    for k in chosen:
        group[group == pairs[1, k]] = pairs[0, k]
    return True


def _apart(tracks: _Tracks, group: Ints, g: int, h: int) -> bool:
    """Whether no sensor would have two tracks of one target at once."""
    for a in np.flatnonzero(group == g):
        for b in np.flatnonzero(group == h):
            if tracks.sensor[a] == tracks.sensor[b] and (
                min(tracks.end[a], tracks.end[b]) > max(tracks.begin[a], tracks.begin[b])
            ):
                return False
    return True


def _fused(e: Estimates, at: Ints, state: Floats, covariance: Floats) -> tuple[Floats, Floats, Ints]:
    """State and covariance of each estimate with those of the other tracks, and how many tracks there are in it."""
    information = np.linalg.inv(e.covariance)
    weighted = np.einsum("eij,ej->ei", information, e.state)
    inverse = np.linalg.inv(covariance)
    np.add.at(information, at, inverse)
    np.add.at(weighted, at, np.einsum("kij,kj->ki", inverse, state))
    whole = np.linalg.inv(information)
    return np.einsum("eij,ej->ei", whole, weighted), whole, 1 + np.bincount(at, minlength=e.lane.size)
