"""Cramer-Rao bounds of a target's place along a known path of straight, turning and accelerating segments.

Unknown are the first place, course and speed; and of every segment its acceleration a and curvature K:

* `curved`: with independent priors, a of standard deviation s_a and K V^2 of s_n (B1). It bounds trackers that allow
  for every such motion at any time; one that expects straight flight may lie below it there.
* known (B2): nobody who does not know the path itself is better.

Instants of the manoeuvres are known in both. Where a plot may be missing its information counts with the share of
trials that have it, which makes the bound a little too low, never too high.

References
----------
tichavsky1998; specification 9.1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.plot_tracking.parameters import CurvatureParameters, TrackerParameters
from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.radars import Feed, feeds_of
from algorithms.plot_tracking.truth import Floats, truth_of
from algorithms.recording import PolarPlots
from algorithms.toolbox.motion.curvature import shifted, wrapped

# Steps between scans belong to one segment where acceleration and turn rate differ by less, m/s2 and rad/s.
SAME_ACCELERATION, SAME_TURN_RATE = 0.02, 2e-4
# Steps of the numerical derivatives: m, m, rad, m/s, m/s2, 1/m.
STEPS = np.array([1.0, 1.0, 1e-5, 1e-2, 1e-4, 1e-9])
LARGEST_CONDITION = 1e12


class Segment(NamedTuple):
    """A piece of a path: when it begins, s, its acceleration and curvature."""

    begin_s: float
    acceleration: float
    curvature: float


def bound(recording: PolarPlots, parameters: TrackerParameters) -> Floats | None:
    """(T,) m: bound of the rms horizontal error at every scan of every target, as `score` orders them.

    None where there is no truth, or where several radars make several estimates of a target.
    """
    feeds, _, _ = feeds_of(recording, parameters)
    if len(feeds) != 1:
        return None
    (feed,) = feeds
    time = np.array([scan.time_s for scan in feed.plots.scans])
    truth = truth_of(recording, time)
    if truth is None:
        return None
    seen = seen_of(recording, feed.plots.scans, truth.names)
    priors = None
    if isinstance(parameters, CurvatureParameters):
        priors = parameters.sd_acceleration_mps2, parameters.sd_normal_mps2
    out = np.full((time.size, len(truth.names)), np.nan)
    for k in range(len(truth.names)):
        there = np.flatnonzero(np.isfinite(truth.position_m[:, k, 0]))
        if there.size > 2:
            place, velocity = truth.position_m[there, k], truth.velocity_mps[there, k]
            out[there, k] = bound_of_path(time[there], place, velocity, seen[there, k], feed, priors)
    alive = np.isfinite(truth.position_m[:, :, 0])
    return out[alive]


def bound_of_path(
    time_s: Floats, place: Floats, velocity: Floats, seen: Floats, feed: Feed, priors: tuple[float, float] | None
) -> Floats:
    """(n,) m: bound at each scan from the plots up to it.

    Parameters
    ----------
    place, velocity : (n, 2) east and north, m and m/s
    seen : (n,) share of trials with a plot
    priors : standard deviations of a and of K V^2, m/s2; None = both are known
    """
    speed = np.hypot(*velocity.T)
    course = np.arctan2(velocity[:, 0], velocity[:, 1])
    segments = segments_of(time_s, speed, course)
    bends = [(s.acceleration, s.curvature) for s in segments]
    p = np.array([place[0, 1], place[0, 0], course[0], speed[0], *np.ravel(bends)])
    steps = np.concatenate([STEPS[:4], np.tile(STEPS[4:], len(segments))])
    begins = [s.begin_s for s in segments]
    up, down = (_flown(time_s, p[:, None] + sign * np.diag(steps), begins) for sign in (1.0, -1.0))
    jacobian = (up - down) / (2 * steps)
    prior = np.zeros((p.size, p.size))
    free = 4
    if priors is not None:
        free = p.size
        began = np.interp(begins, time_s, speed)
        weights = np.ravel([(1 / priors[0], max(v, 1.0) ** 2 / priors[1]) for v in began])
        prior[range(4, free), range(4, free)] = weights**2
    total, out = prior[:free, :free], np.full(time_s.size, np.nan)
    scale = np.concatenate([[1e-3, 1e-3, 1.0, 1e-1], np.tile([1.0, 1e4], len(segments))])[:free]
    for k in range(time_s.size):
        j = jacobian[k][:, :free]
        total = total + seen[k] * j.T @ _weight(place[k], feed) @ j
        scaled = total / scale[:, None] / scale[None]
        if np.linalg.cond(scaled) < LARGEST_CONDITION:
            out[k] = np.sqrt(np.trace(j / scale @ np.linalg.inv(scaled) @ (j / scale).T))
    return out


def segments_of(time_s: Floats, speed: Floats, course: Floats) -> list[Segment]:
    """Pieces of constant acceleration and turn rate; where one ends between two scans both sides tell when."""
    dt = np.diff(time_s)
    a, turn = np.diff(speed) / dt, wrapped(np.diff(course)) / dt
    alike = (np.abs(np.diff(a)) < SAME_ACCELERATION) & (np.abs(np.diff(turn)) < SAME_TURN_RATE)
    runs = np.split(np.arange(dt.size), np.flatnonzero(~alike) + 1)
    # A single step between two runs is where one goes over into the other.
    whole = [r for i, r in enumerate(runs) if r.size > 1 or i in (0, len(runs) - 1)]
    out = []
    for i, run in enumerate(whole):
        mean_a, mean_turn = float(a[run].mean()), float(turn[run].mean())
        begin = float(time_s[run[0]])
        if i and whole[i - 1][-1] + 1 < run[0]:
            before, mixed = whole[i - 1], int(run[0]) - 1
            old_a, old_turn = float(a[before].mean()), float(turn[before].mean())
            by_turn = abs(mean_turn - old_turn) / SAME_TURN_RATE > abs(mean_a - old_a) / SAME_ACCELERATION
            now, new, old = (turn[mixed], mean_turn, old_turn) if by_turn else (a[mixed], mean_a, old_a)
            begin = float(time_s[mixed] + dt[mixed] * np.clip((now - new) / (old - new), 0.0, 1.0))
        middle = max(float(speed[run].mean()), 1.0)
        out.append(Segment(begin, mean_a, mean_turn / middle if abs(mean_turn) > SAME_TURN_RATE else 0.0))
    return out


def _flown(time_s: Floats, p: Floats, begins: list[float]) -> Floats:
    """(n, 2, W) east and north at instants, of paths p (4 + 2 segments, W)."""
    out = np.empty((time_s.size, 2, p.shape[1]))
    state, since = p[:4], time_s[0]
    for i, begin in enumerate(begins):
        end = begins[i + 1] if i + 1 < len(begins) else np.inf
        motion = np.concatenate([state, p[4 + 2 * i : 6 + 2 * i]])
        if i == 0:
            since = time_s[0]
        for k in np.flatnonzero((time_s >= (begin if i else -np.inf)) & (time_s < end)):
            north, east = shifted(motion, time_s[k] - since)[:2]
            out[k] = east, north
        if np.isfinite(end):
            state, since = shifted(motion, np.array(end - since))[:4], end
    return out


def _weight(place: Floats, feed: Feed) -> Floats:
    """(2, 2) information of a plot at a place, in east and north."""
    rho = max(float(np.hypot(*place)), 1.0)
    along = place / rho
    across = np.array([along[1], -along[0]])
    sigma = max(feed.sigma_th * rho, feed.across_m)
    out: Floats = np.outer(along, along) / feed.sigma_r**2 + np.outer(across, across) / sigma**2
    return out


def seen_of(recording: PolarPlots, scans: tuple[Scan, ...], names: tuple[str, ...]) -> Floats:
    """(S, K) share of trials in which a scan has a plot of a target."""
    lanes = recording.range_m.shape[1]
    place = {name: k for k, name in enumerate(names)}
    of = np.array([place.get(name, -1) for name in recording.targets])
    out = np.zeros((len(scans), len(names)))
    for s, scan in enumerate(scans):
        target = of[recording.target[scan.position]]
        out[s] = np.bincount(target[target >= 0], minlength=len(names)) / lanes
    return out
