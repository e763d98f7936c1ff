"""Everything a tracker does, scan by scan, put together into the arrays of a result."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.joined import Joining, joined_tracks
from algorithms.plot_tracking.outputs import LEFT_OUT, MOTION, NO_GATE, NOT_DETECTED
from algorithms.plot_tracking.plots import NOT_MEASURED, TAKEN, Scan
from algorithms.plot_tracking.radars import Feed
from algorithms.toolbox.tracks.life_cycle import Diary

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Estimates:
    """Confirmed tracks after a scan, in the radar's own frame; arrays (E,), (E, 4), (E, 4, 4), (E, len(MOTION)).

    The state is east, north, and their velocities.
    """

    lane: Ints
    number: Ints
    time_s: Floats
    mark: Ints
    outside: Ints
    status: Ints
    misses: Ints
    state: Floats
    covariance: Floats
    motion: Floats
    nis: Floats
    weights: Floats
    """(E, models)"""


@dataclass
class History:
    """What became of M plots in L trials, and of the tracks.

    A track takes its first plots before it has a number; `baptise` gives it to them afterwards.
    """

    marks: int
    lanes: int
    diary: Diary = field(default_factory=Diary)
    _estimates: list[tuple[int, int, Estimates]] = field(default_factory=list)
    _pairs: list[tuple[Ints, Ints, Ints, int, Floats]] = field(default_factory=list)
    _areas: list[tuple[Ints, Ints, Ints, Floats, Floats, Floats]] = field(default_factory=list)
    _scans: list[tuple[float, int]] = field(default_factory=list)
    _accuracies: list[tuple[float, float, float, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        shape = (self.marks, self.lanes)
        self.decision = np.full(shape, NOT_DETECTED)
        self.gate = np.full(shape, NO_GATE)
        self.track = np.zeros(shape, np.int64)
        self.rivals = np.zeros(shape, np.int64)
        self.distance, self.threshold, self.probability = (np.full(shape, np.nan) for _ in range(3))

    def begin(self, feed: Feed) -> None:
        """Mark what cannot be used of a radar's rows."""
        fate = feed.plots.fate
        self.decision[feed.rows] = np.where((fate != TAKEN) & (fate != NOT_MEASURED), LEFT_OUT, NOT_DETECTED)

    def begin_scan(self, feed: Feed, time_s: float) -> None:
        """Start a scan; what follows belongs to it."""
        self._scans.append((time_s, feed.index))
        self._accuracies.append((feed.sigma_r, feed.sigma_th, float(feed.origin[0]), float(feed.origin[1])))

    def take(
        self, scan: Scan, *, decision: Ints, gate: Ints, number: Ints, distance: Floats, threshold: Floats,
        rivals: Ints, probability: Floats | None = None,
    ) -> None:  # fmt: skip
        """Write down what became of a scan's plots, (P,) each."""
        at = (scan.position, scan.lane)
        self.decision[at], self.gate[at], self.track[at], self.rivals[at] = decision, gate, number, rivals
        self.distance[at], self.threshold[at] = distance, threshold
        if probability is not None:
            self.probability[at] = probability

    def pairs(self, scan: Scan, plot: Ints, number: Ints, gate: int, distance: Floats) -> None:
        """Write down which plots lay in gates of which tracks."""
        if plot.size:
            self._pairs.append((scan.position[plot], scan.lane[plot], number, gate, distance))

    def areas(
        self, feed: Feed, time_s: float, gate: int, lane: Ints, number: Ints, centre: Floats, covariance: Floats
    ) -> None:
        """Write down where the gates of a scan lie, in the frame of the site."""
        if lane.size:
            east, north = feed.to_site(centre[:, 0], centre[:, 1])
            turned = feed.turned @ covariance @ feed.turned.T
            place = np.stack([east, north], axis=1)
            gates, times = np.full(lane.size, gate), np.full(lane.size, time_s)
            self._areas.append((lane, number, gates, times, place, _in_place(turned)))

    def baptise(self, mark: Ints, lane: Ints, number: Ints) -> None:
        """Give the number of a track to plots that it took before it had one."""
        known = mark >= 0
        self.track[mark[known], lane[known]] = number[known]

    def estimates(self, feed: Feed, found: Estimates) -> None:
        """Write down where the confirmed tracks are, in the frame of the site."""
        if not found.lane.size:
            return
        state, covariance = found.state.copy(), found.covariance
        state[:, 0], state[:, 1] = feed.to_site(found.state[:, 0], found.state[:, 1])
        state[:, 2], state[:, 3] = feed.turn(found.state[:, 2], found.state[:, 3])
        if (feed.turned != np.eye(2)).any():
            turn = np.kron(np.eye(2), feed.turned)
            covariance = turn @ covariance @ turn.T
        whole = Estimates(**{**found.__dict__, "state": state, "covariance": covariance})
        self._estimates.append((len(self._scans) - 1, feed.index, whole))

    def arrays(self, row: Ints, models: int = 0, joining: Joining | None = None) -> dict[str, Any]:
        """Arrays as `outputs.TRACK_OUTPUTS` declares them, and `estimate_weights` where there are models."""
        parts = [e for _, _, e in self._estimates]
        sizes = np.array([e.lane.size for e in parts], np.int64)
        empty = _no_estimates(models)
        whole = {n: np.concatenate([getattr(e, n) for e in [empty, *parts]]) for n in empty.__dict__}
        out: dict[str, Any] = {
            "row": row,
            "decision": self.decision,
            "gate": self.gate,
            "track": self.track,
            "distance": self.distance,
            "threshold": self.threshold,
            "probability": self.probability,
            "rivals": self.rivals,
            "estimate_trial": whole["lane"],
            "estimate_track": whole["number"],
            "estimate_radar": np.repeat(np.array([r for _, r, _ in self._estimates], np.int64), sizes),
            "estimate_scan": np.repeat(np.array([s for s, _, _ in self._estimates], np.int64), sizes),
            "scan_time_s": np.array([t for t, _ in self._scans], float),
            "scan_radar": np.array([r for _, r in self._scans], np.int64),
            "scan_accuracy": np.array(self._accuracies, float).reshape(-1, 4),
        }
        for n in ("time_s", "mark", "outside", "status", "misses", "state", "motion", "nis"):
            out[f"estimate_{n}"] = whole[n]
        out["estimate_covariance"] = _in_place(whole["covariance"])
        out |= joined_tracks(out, whole["covariance"], joining)
        if models:
            out["estimate_weights"] = whole["weights"]
        none = np.empty(0, np.int64)
        gates = [np.full(p[0].size, p[3]) for p in self._pairs]
        for i, n in enumerate(("mark", "trial", "track")):
            out[f"pair_{n}"] = np.concatenate([none, *(p[i] for p in self._pairs)])
        out["pair_gate"] = np.concatenate([none, *gates])
        out["pair_distance"] = np.concatenate([np.empty(0), *(p[4] for p in self._pairs)])
        empty_area = (none, none, none, np.empty(0), np.empty((0, 2)), np.empty((0, 3)))
        for i, n in enumerate(("trial", "track", "gate", "time_s", "centre", "covariance")):
            out[f"area_{n}"] = np.concatenate([empty_area[i], *(part[i] for part in self._areas)])
        names = ("trial", "track", "time_s", "state", "reason")
        return out | {f"event_{n}": a for n, a in zip(names, self.diary.joined(), strict=True)}


def _in_place(covariance: Floats) -> Floats:
    """(E, 3) east-east, north-north, east-north."""
    return np.stack([covariance[:, 0, 0], covariance[:, 1, 1], covariance[:, 0, 1]], axis=1)


def _no_estimates(models: int) -> Estimates:
    number, value = np.empty(0, np.int64), np.empty(0)
    return Estimates(
        lane=number,
        number=number,
        time_s=value,
        mark=number,
        outside=number,
        status=number,
        misses=number,
        state=np.empty((0, 4)),
        covariance=np.empty((0, 4, 4)),
        motion=np.empty((0, len(MOTION))),
        nis=value,
        weights=np.empty((0, models)),
    )
