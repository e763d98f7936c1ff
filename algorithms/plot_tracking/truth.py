"""Where the targets truly are at the instants of the scans, and which track is whose.

Scan by scan each target is given at most one confirmed track near it, and each track at most one target: as many pairs
as can be, and of those the nearest, where the track that had the target before counts as nearer by 0.15 of that. Near
are ten errors of a plot there, at most 2 km, which it is where an air-traffic radar errs by 200 m; boats 30 m apart on
a marine radar are not one another's.

References
----------
Specification 8.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import CLUTTER, PolarPlots
from algorithms.toolbox.association.sparse import most_pairs_at_least_cost
from algorithms.toolbox.metrics.point_sets import SetDistance, set_distance

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FARTHEST_M, NEAR_ERRORS = 2000.0, 10.0
LOYALTY = 0.15
# Truth that was given so much more rarely than scans come is not joined by straight lines.
LONGEST_STEP_S = 60.0


@dataclass(frozen=True)
class Truth:
    """K targets at S scans.

    Attributes
    ----------
    names : (K,)
    position_m, velocity_mps : (S, K, 2) at the scans' instants, NaN where a target is not there
    """

    names: tuple[str, ...]
    position_m: Floats
    velocity_mps: Floats


@dataclass(frozen=True)
class Matched:
    """Which track is whose, in L trials.

    Attributes
    ----------
    estimate : (S, K, L) position of the estimate that a target has at a scan, -1 = none
    owner : (E,) target of each estimate, -1 = none
    error_m, error_mps : (E, 2) of the matched estimates, else NaN
    distances : of each scan, over all targets
    radar : (S,) of each scan; those of one radar lie together, in the order of time
    """

    truth: Truth
    estimate: Ints
    owner: Ints
    error_m: Floats
    error_mps: Floats
    distances: list[SetDistance]
    radar: Ints

    def radars(self) -> list[Ints]:
        """Positions of the scans of each radar."""
        return [np.flatnonzero(self.radar == r) for r in np.unique(self.radar)]


def truth_of(recording: PolarPlots, time_s: Floats) -> Truth | None:
    """True states at instants, from the given paths, else from the rows; None where nothing is known."""
    paths = _paths(recording)
    if not paths:
        return None
    position = np.full((time_s.size, len(paths), 2), np.nan)
    velocity = np.full_like(position, np.nan)
    for k, (time, place, speed) in enumerate(paths.values()):
        inside = (time_s >= time[0] - 1e-6) & (time_s <= time[-1] + 1e-6)
        at = np.searchsorted(time, time_s).clip(1, max(time.size - 1, 1))
        if time.size > 1:
            near = (np.abs(time[at] - time_s) < 1e-6) | (np.abs(time[at - 1] - time_s) < 1e-6)
            inside &= near | (time[at] - time[at - 1] <= LONGEST_STEP_S)
        for axis in range(2):
            position[:, k, axis] = np.where(inside, np.interp(time_s, time, place[:, axis]), np.nan)
            velocity[:, k, axis] = np.where(inside, np.interp(time_s, time, speed[:, axis]), np.nan)
    return Truth(tuple(paths), position, velocity)


def _paths(recording: PolarPlots) -> dict[str, tuple[Floats, Floats, Floats]]:
    """Instants, places and velocities of each target that has any."""
    tracks = recording.truth_tracks
    if tracks is not None:
        out = {}
        for i, name in enumerate(tracks.targets):
            at = tracks.points_of(i)
            if at.size:
                out[name] = _path(tracks.time_s[at], tracks.position_m[at, :2], tracks.velocity_mps[at, :2])
        return out
    out = {}
    known = np.isfinite(recording.truth_m[:, 0] + recording.truth_m[:, 1])
    for i, rows in enumerate(recording.rows_by_target()):
        mine = rows[known[rows]]
        if mine.size and recording.targets[i] != CLUTTER:
            out[recording.targets[i]] = _path(
                recording.time_s[mine], recording.truth_m[mine, :2], recording.truth_velocity_mps[mine, :2]
            )
    return out


def _path(time: Floats, place: Floats, velocity: Floats) -> tuple[Floats, Floats, Floats]:
    """The path with each instant once; a velocity that was not given is that between the points."""
    time, first = np.unique(time, return_index=True)
    place, velocity = place[first], velocity[first]
    if not np.isfinite(velocity).any() and time.size > 1:
        velocity = np.gradient(place, time, axis=0)
    return time, place, velocity


def matched(recording: PolarPlots, arrays: dict[str, Any], lanes: int) -> Matched | None:
    """Give tracks to targets, scan by scan; None where the recording has no truth."""
    truth = truth_of(recording, arrays["scan_time_s"])
    if truth is None:
        return None
    scans, targets = truth.position_m.shape[:2]
    scan, lane, number = (arrays[f"estimate_{n}"] for n in ("scan", "trial", "track"))
    place = arrays["estimate_state"][:, :2]
    # An estimate holds for the instant of its plot, which may be some seconds before the scan's last one.
    own = truth_of(recording, arrays["estimate_time_s"])
    assert own is not None
    near = _near(truth, arrays["scan_accuracy"])
    estimate = np.full((scans, targets, lanes), -1)
    owner = np.full(scan.size, -1)
    before = np.zeros((targets, lanes), np.int64)
    distances = []
    bounds = np.searchsorted(scan, np.arange(scans + 1))
    for s in range(scans):
        here = np.arange(bounds[s], bounds[s + 1])
        alive = np.flatnonzero(np.isfinite(truth.position_m[s, :, 0]))
        if alive.size and here.size:
            offset = place[here][:, None] - own.position_m[here][:, alive]
            d = np.hypot(offset[..., 0], offset[..., 1])
            within = near[s, alive]
            i, k = np.nonzero(d < within)
            same = before[alive[k], lane[here[i]]] == number[here[i]]
            chosen = most_pairs_at_least_cost(
                i, lane[here[i]] * targets + alive[k], d[i, k] - LOYALTY * within[k] * same
            )
            e, t = here[i[chosen]], alive[k[chosen]]
            estimate[s, t, lane[e]] = e
            owner[e] = t
            before[t, lane[e]] = number[e]
        cut = float(near[s, alive].max(initial=0.0)) or FARTHEST_M
        distances.append(set_distance(lane[here], place[here], truth.position_m[s, alive], lanes, cut_m=cut))
    at = np.maximum(owner, 0)
    each = np.arange(scan.size)
    unknown = np.expand_dims(owner < 0, 1)
    error = np.where(unknown, np.nan, place - own.position_m[each, at])
    error_v = np.where(unknown, np.nan, arrays["estimate_state"][:, 2:] - own.velocity_mps[each, at])
    return Matched(truth, estimate, owner, error, error_v, distances, arrays["scan_radar"])


def _near(truth: Truth, accuracy: Floats) -> Floats:
    """(S, K) m, how near a track must be to be a target's; `accuracy` as the output `scan_accuracy`."""
    sigma_r, sigma_th, east, north = accuracy.T[:, :, None]
    rho = np.hypot(truth.position_m[:, :, 0] - east, truth.position_m[:, :, 1] - north)
    out: Floats = np.minimum(NEAR_ERRORS * np.maximum(sigma_r, sigma_th * np.nan_to_num(rho)), FARTHEST_M)
    return out
