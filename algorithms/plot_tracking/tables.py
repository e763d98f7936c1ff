"""Results of the trackers as long tables (columns as the HTTP API fixes them)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.joined_tables import compared_tracks, joined_states
from algorithms.plot_tracking.outputs import (
    ACQUIRED,
    DECISIONS,
    GATES,
    LEFT_OUT,
    MANOEUVRE,
    MIDDLE,
    MODELS,
    MOTION,
    NOT_DETECTED,
    SECOND,
    SHARED,
    STARTED,
    UPDATED,
)
from algorithms.plot_tracking.requirements import requirements, thresholds_of
from algorithms.plot_tracking.scoring import track_shares
from algorithms.plot_tracking.truth import Matched, matched
from algorithms.recording import PolarPlots
from algorithms.result import GivenColumn, Result, Table
from algorithms.toolbox.tracks.life_cycle import DROPPED, REASONS, STATES

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Beyond this standard deviation a course says nothing.
LARGEST_COURSE_SD_DEG = 30.0

WHY = {
    LEFT_OUT: "it cannot be a plot, or repeats one",
    STARTED: "in no gate: it may be the first of a track",
    SECOND: "within the reach of the largest speed from a single plot",
    ACQUIRED: "near the straight continuation of two plots",
    UPDATED: "near the predicted point",
    MIDDLE: "outside the inner ellipse: the memory does not grow",
    MANOEUVRE: "so far from the predicted point that it shows a manoeuvre",
    SHARED: "several tracks took their share of it",
}
"""What a decision about a plot means."""


def tabulate(recording: PolarPlots, result: Result) -> dict[str, Table]:
    """Return states, tracks, track_events, decisions, gates; of several radars joined_states and compared_tracks.

    With truth there are errors, set_distances and requirements too.
    """
    a: dict[str, Any] = dict(result.arrays)
    lanes = a["decision"].shape[1]
    m = matched(recording, a, lanes)
    names = m.truth.names if m is not None else ()
    owner = m.owner if m is not None else np.full(a["estimate_track"].size, -1)
    target: list[str | None] = [names[i] or None if i >= 0 else None for i in owner.tolist()]
    tables = {
        "states": _states(recording, a, target),
        "tracks": _tracks(recording, a, m),
        "track_events": _events(a),
        "decisions": _decisions(recording, a),
        "gates": _gates(recording, a),
        "gate_areas": _areas(a),
    }
    if "estimate_weights" in a:
        tables["mode_probabilities"] = _weights(recording, a, target)
    if m is not None:
        tables["errors"] = _errors(recording, a, m.error_m, m.error_mps, target)
        tables["set_distances"] = set_distances(recording, a, m)
        tables["requirements"] = requirements(m, a, thresholds_of(dict(result.settings)))
    if len(recording.radars) > 1:
        tables["compared_tracks"] = compared_tracks(a, lanes)
        tables["joined_states"] = joined_states(a, target, lanes)
    return tables


def trial_of(trial: Ints, a: dict[str, Any]) -> Floats:
    """Trial numbers; empty for an uploaded recording, which is no trial."""
    return np.full(trial.size, np.nan) if a["decision"].shape[1] == 1 else trial.astype(float)


def _rows(recording: PolarPlots, mark: Ints) -> Floats:
    """Row numbers of plots; NaN for a track that missed the scan."""
    return (
        np.where(mark >= 0, recording.row[np.maximum(mark, 0)].astype(float), np.nan)
        if len(recording)
        else np.full(mark.size, np.nan)
    )


def _states(recording: PolarPlots, a: dict[str, Any], target: list[str | None]) -> Table:
    """Confirmed tracks, scan by scan."""
    east, north, ve, vn = a["estimate_state"].T
    xx, yy, xy = a["estimate_covariance"].T
    status, mark, nis = a["estimate_status"], a["estimate_mark"], a["estimate_nis"]
    none = np.full(east.size, np.nan)
    radar = [recording.radars[i] or "radar" for i in a["estimate_radar"].tolist()]
    columns: dict[str, GivenColumn] = {
        "trial": trial_of(a["estimate_trial"], a),
        "track": a["estimate_track"].astype(float),
        "time_s": a["estimate_time_s"],
        "east_m": east,
        "north_m": north,
        "up_m": none,
        "velocity_east_mps": ve,
        "velocity_north_mps": vn,
        "sigma_east_m": np.sqrt(xx),
        "sigma_north_m": np.sqrt(yy),
        "sigma_up_m": none,
        "drms_m": np.sqrt(xx + yy),
        "nis": nis,
        "dof": np.where(np.isfinite(nis), 2.0, np.nan),
        "status": [STATES[i] for i in status.tolist()],
        "used": [r if i >= 0 else None for r, i in zip(radar, mark.tolist(), strict=True)],
        "row": _rows(recording, mark),
        "target": target,
        "covariance_east_north_m2": xy,
        "speed_mps": np.hypot(ve, vn),
        "course_deg": _courses(a, ve, vn),
        "misses": a["estimate_misses"].astype(float),
        "joined": _joined(recording, a["estimate_joined"]),
    }
    return Table(columns | {name: a["estimate_motion"][:, i] for i, name in enumerate(MOTION)})


def _tracks(recording: PolarPlots, a: dict[str, Any], m: Any) -> Table:
    """Every track that was ever confirmed: when it lived, how it ended, and whose it was."""
    key = np.stack([a["estimate_trial"], a["estimate_track"]])
    tracks, index, count = np.unique(key, axis=1, return_inverse=True, return_counts=True)
    index = index.ravel()
    size = tracks.shape[1]
    first, last = np.full(size, np.inf), np.full(size, -np.inf)
    np.minimum.at(first, index, a["estimate_time_s"])
    np.maximum.at(last, index, a["estimate_time_s"])
    plots = np.bincount(index, weights=a["estimate_mark"] >= 0, minlength=size)
    radar = np.zeros(size, np.int64)
    radar[index] = a["estimate_radar"]
    # How each of them ended; one that lives on was not dropped.
    place = {(int(t), int(n)): i for i, (t, n) in enumerate(tracks.T)}
    ended: list[str | None] = [None] * size
    for t, n, state, reason in zip(
        a["event_trial"].tolist(), a["event_track"].tolist(), a["event_state"].tolist(), a["event_reason"].tolist(),
        strict=True,
    ):  # fmt: skip
        if state == DROPPED and (t, n) in place:
            ended[place[t, n]] = REASONS[reason]
    columns: dict[str, GivenColumn] = {
        "trial": trial_of(tracks[0], a),
        "track": tracks[1].astype(float),
        "radar": [recording.radars[i] or None for i in radar.tolist()],
        "state": ["lives on" if reason is None else STATES[DROPPED] for reason in ended],
        "start_s": first,
        "end_s": last,
        "updates": plots,
        "misses": count - plots,
        "reason": ended,
    }
    joined = np.zeros(size, np.int64)
    joined[index] = a["estimate_joined"]
    columns["joined"] = _joined(recording, joined)
    if m is not None:
        _, _, best, share = track_shares(m, a)
        columns["target"] = [m.truth.names[i] or None if i >= 0 else None for i in best.tolist()]
        columns["target_share"] = share
    return Table(columns)


def _courses(a: dict[str, Any], ve: Floats, vn: Floats) -> Floats:
    """Courses in degrees; NaN where a track is too slow, or too little known, to have one."""
    sd_speed, sd_course = (a["estimate_motion"][:, MOTION.index(n)] for n in ("sigma_speed_mps", "sigma_course_deg"))
    course = np.degrees(np.mod(np.arctan2(ve, vn), 2 * np.pi))
    with np.errstate(invalid="ignore"):
        unknown = (sd_course > LARGEST_COURSE_SD_DEG) | (np.hypot(ve, vn) < 2 * sd_speed)
    return np.where(unknown, np.nan, course)


def _joined(recording: PolarPlots, number: Ints) -> Floats:
    """Numbers of joint tracks; of one radar there are none."""
    return number.astype(float) if len(recording.radars) > 1 else np.full(number.size, np.nan)


def _events(a: dict[str, Any]) -> Table:
    """The steps of the tracks' lives, with their reasons."""
    return Table(
        {
            "trial": trial_of(a["event_trial"], a),
            "track": a["event_track"].astype(float),
            "time_s": a["event_time_s"],
            "status": [STATES[i] for i in a["event_state"].tolist()],
            "reason": [REASONS[i] for i in a["event_reason"].tolist()],
        }
    )


def _decisions(recording: PolarPlots, a: dict[str, Any]) -> Table:
    """Every plot: in which gate of which track it lay, how far from its middle, which others, and what was done."""
    decision = a["decision"]
    trial, mark = np.nonzero((decision != NOT_DETECTED).T)
    codes = decision[mark, trial].tolist()
    track = a["track"][mark, trial]
    columns: dict[str, GivenColumn] = {
        "track": np.where(track > 0, track, np.nan),
        "row": recording.row[mark].astype(float),
        "time_s": recording.time_s[mark],
        "decision": [DECISIONS[i] for i in codes],
        "distance": a["distance"][mark, trial],
        "threshold": a["threshold"][mark, trial],
        "probability": a["probability"][mark, trial],
        "reason": [WHY.get(i) for i in codes],
        "target": [recording.targets[i] or None for i in recording.target[mark].tolist()],
        "radar": [recording.radars[i] or None for i in recording.radar[mark].tolist()],
        "look": recording.scan[mark].astype(float),
        "trial": trial_of(trial, a),
        "gate": [GATES[i] for i in a["gate"][mark, trial].tolist()],
        "competing": _competing(a, mark, trial),
        "outside": _outside(a)[mark, trial],
    }
    return Table(columns)


def _outside(a: dict[str, Any]) -> Floats:
    """(M, L) number of the track just outside whose gate a plot lay, NaN = none."""
    out = np.full(a["decision"].shape, np.nan)
    known = a["estimate_outside"] >= 0
    out[a["estimate_outside"][known], a["estimate_trial"][known]] = a["estimate_track"][known]
    return out


def _competing(a: dict[str, Any], mark: Ints, trial: Ints) -> list[str | None]:
    """Numbers of the other tracks in whose gates a plot lay; ? stands for one that had no number yet."""
    several = a["rivals"][mark, trial] > 1
    wanted = {(int(i), int(t)): k for k, (i, t) in enumerate(zip(mark, trial, strict=True)) if several[k]}
    out: list[str | None] = [None] * mark.size
    found: dict[int, list[str]] = {}
    for i, t, n in zip(a["pair_mark"].tolist(), a["pair_trial"].tolist(), a["pair_track"].tolist(), strict=True):
        k = wanted.get((i, t))
        if k is not None and n != a["track"][i, t]:
            found.setdefault(k, []).append(str(n) if n else "?")
    for k, numbers in found.items():
        out[k] = " ".join(numbers)
    return out


def _gates(recording: PolarPlots, a: dict[str, Any]) -> Table:
    """Every plot in every gate that it lay in."""
    mark, track = a["pair_mark"], a["pair_track"]
    return Table(
        {
            "trial": trial_of(a["pair_trial"], a),
            "time_s": recording.time_s[mark],
            "row": recording.row[mark].astype(float),
            "track": np.where(track > 0, track, np.nan),
            "gate": [GATES[i] for i in a["pair_gate"].tolist()],
            "distance": a["pair_distance"],
        }
    )


def _areas(a: dict[str, Any]) -> Table:
    """Gates as ellipses around the points where plots are looked for; semi-axes are the roots of the eigenvalues."""
    xx, yy, xy = a["area_covariance"].T
    mean, spread = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return Table(
        {
            "trial": trial_of(a["area_trial"], a),
            "track": np.where(a["area_track"] > 0, a["area_track"], np.nan),
            "time_s": a["area_time_s"],
            "gate": [GATES[i] for i in a["area_gate"].tolist()],
            "east_m": a["area_centre"][:, 0],
            "north_m": a["area_centre"][:, 1],
            "semi_major_m": np.sqrt(mean + spread),
            "semi_minor_m": np.sqrt(np.maximum(mean - spread, 0.0)),
            # Of the long axis, clockwise from north.
            "azimuth_deg": np.degrees(np.mod(0.5 * np.arctan2(2 * xy, yy - xx), np.pi)),
        }
    )


def _weights(recording: PolarPlots, a: dict[str, Any], target: list[str | None]) -> Table:
    """Probabilities of the motion models, track by track."""
    weights = a["estimate_weights"]
    count = len(MODELS)
    return Table(
        {
            "trial": trial_of(np.repeat(a["estimate_trial"], count), a),
            "track": np.repeat(a["estimate_track"], count).astype(float),
            "time_s": np.repeat(a["estimate_time_s"], count),
            "model": list(MODELS) * len(weights),
            "probability": weights.ravel(),
            "row": np.repeat(_rows(recording, a["estimate_mark"]), count),
            "target": [name for name in target for _ in range(count)],
        }
    )


def set_distances(recording: PolarPlots, a: dict[str, Any], m: Matched) -> Table:
    """OSPA and GOSPA of each radar's scans with GOSPA's parts; the part of the pairs as a root, m."""
    scans, lanes = len(m.distances), m.estimate.shape[2]
    radar = [recording.radars[i] or None for i in m.radar.tolist()]
    at = {name: np.stack([getattr(d, name) for d in m.distances]).ravel() if scans else np.empty(0) for name in _PARTS}
    columns: dict[str, GivenColumn] = {
        "trial": trial_of(np.tile(np.arange(lanes), scans), a),
        "radar": [name for name in radar for _ in range(lanes)],
        "time_s": np.repeat(a["scan_time_s"], lanes),
        "ospa_m": at["ospa_m"],
        "gospa_m": at["gospa_m"],
        "localisation_m": np.sqrt(at["localisation"]),
        "missed": at["missed"],
        "false": at["false"],
    }
    return Table(columns)


_PARTS = ("ospa_m", "gospa_m", "localisation", "missed", "false")


def _errors(
    recording: PolarPlots, a: dict[str, Any], error: Floats, error_v: Floats, target: list[str | None]
) -> Table:
    keep = np.flatnonzero(np.isfinite(error).all(axis=1))
    return Table(
        {
            "trial": trial_of(a["estimate_trial"], a)[keep],
            "track": a["estimate_track"][keep].astype(float),
            "target": [target[i] for i in keep.tolist()],
            "time_s": a["estimate_time_s"][keep],
            "error_east_m": error[keep, 0],
            "error_north_m": error[keep, 1],
            "error_up_m": np.full(keep.size, np.nan),
            "error_horizontal_m": np.hypot(error[keep, 0], error[keep, 1]),
            "error_velocity_mps": np.hypot(error_v[keep, 0], error_v[keep, 1]),
            "row": _rows(recording, a["estimate_mark"][keep]),
        }
    )
