"""Results of the multiple-model algorithms as long tables (columns as the HTTP API fixes them)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.multiple_model import states
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.measures import names_of
from algorithms.result import Result, Table

_POSITION, _VELOCITY, _ACCELERATION = [0, 3, 6], [1, 4, 7], [2, 5, 8]
_AXES = ("east", "north", "up")
_TAKEN = (states.UPDATED, states.STARTED, states.UNUSUAL, states.RESTARTED)


def tabulate(recording: Plots, result: Result) -> dict[str, Table]:
    """Return the tables states, tracks, decisions, mode_probabilities, model_states and, with truth, errors."""
    tables = {
        "states": _states(recording, result),
        "tracks": _tracks(recording, result),
        "decisions": _decisions(recording, result),
    }
    if len(result.arrays["sigma_model"]) > 1:
        tables["mode_probabilities"] = _probabilities(recording, result)
        tables["model_states"] = _model_states(recording, result)
    if recording.has_truth:
        tables["errors"] = _errors(recording, result)
    return tables


def _flat(array: NDArray[Any]) -> NDArray[Any]:
    """(mark, trial) -> rows: trial by trial, marks in time order."""
    return array.T.reshape(-1)


def _targets(recording: Plots, trials: int) -> list[str | None]:
    return [recording.targets[i] or None for i in recording.target] * trials


def _trial(marks: int, trials: int) -> NDArray[np.float64]:
    """Trial numbers; empty for an uploaded recording, which is no trial."""
    return np.full(marks, np.nan) if trials == 1 else np.repeat(np.arange(trials, dtype=float), marks)


def _or_nan(track: NDArray[Any]) -> NDArray[np.float64]:
    return np.where(track > 0, track, np.nan)


def _states(recording: Plots, result: Result) -> Table:
    a = result.arrays
    state, cov = a["state"], a["covariance"]
    marks, trials = a["track"].shape
    sd = np.sqrt(np.stack([cov[:, i, i] for i in range(9)], axis=1))
    columns: dict[str, Any] = {
        "trial": _trial(marks, trials),
        "track": _or_nan(_flat(a["track"])),
        "time_s": np.tile(recording.time_s, trials),
    }
    for prefix, where, unit in (
        ("", _POSITION, "m"),
        ("velocity_", _VELOCITY, "mps"),
        ("acceleration_", _ACCELERATION, "mps2"),
    ):
        for axis, i in zip(_AXES, where, strict=True):
            columns[f"{prefix}{axis}_{unit}"] = _flat(state[:, i])
    for i, axis in zip(_POSITION, _AXES, strict=True):
        columns[f"sigma_{axis}_m"] = _flat(sd[:, i])
    columns["drms_m"] = _flat(np.hypot(sd[:, 0], sd[:, 3]))
    columns["nis"] = _flat(a["nis"])
    columns["dof"] = np.tile(a["dof"], trials)
    columns["status"] = [states.STATUS[i] for i in _flat(a["status"])]
    taken = np.isin(_flat(a["status"]), _TAKEN)
    columns["used"] = ["plot" if one else None for one in taken.tolist()]
    columns["row"] = np.tile(a["row"], trials)
    columns["target"] = _targets(recording, trials)
    for i, axis in zip(_VELOCITY, _AXES, strict=True):
        columns[f"sigma_velocity_{axis}_mps"] = _flat(sd[:, i])
    columns["covariance_east_north_m2"] = _flat(cov[:, 0, 3])
    return Table(columns)


def _errors(recording: Plots, result: Result) -> Table:
    a = result.arrays
    error = a["state"][:, _POSITION] - recording.truth_m[:, :, None]
    velocity = a["state"][:, _VELOCITY] - recording.truth_velocity_mps[:, :, None]
    keep = np.isfinite(_flat(error[:, 0]))
    marks, trials = a["track"].shape
    targets = _targets(recording, trials)
    columns: dict[str, Any] = {
        "trial": _trial(marks, trials)[keep],
        "track": _or_nan(_flat(a["track"]))[keep],
        "target": [targets[i] for i in np.flatnonzero(keep)],
        "time_s": np.tile(recording.time_s, trials)[keep],
    }
    for i, axis in enumerate(_AXES):
        columns[f"error_{axis}_m"] = _flat(error[:, i])[keep]
    columns["error_horizontal_m"] = _flat(np.hypot(error[:, 0], error[:, 1]))[keep]
    columns["error_velocity_mps"] = _flat(np.sqrt((velocity**2).sum(axis=1)))[keep]
    for i, axis in enumerate(_AXES):
        columns[f"error_velocity_{axis}_mps"] = _flat(velocity[:, i])[keep]
    columns["row"] = np.tile(a["row"], trials)[keep]
    return Table(columns)


def _tracks(recording: Plots, result: Result) -> Table:
    a = result.arrays
    rows: list[tuple[Any, ...]] = []
    for trial in range(a["track"].shape[1]):
        number, status, reason = a["track"][:, trial], a["status"][:, trial], a["reason"][:, trial]
        for track in np.unique(number[number > 0]):
            where = np.flatnonzero(number == track)
            target = int(recording.target[where[0]])
            later = recording.rows_of(target)
            later = later[(later > where[-1]) & (number[later] > 0)]
            taken = np.isin(status[where], _TAKEN)
            end = "end of the recording" if later.size == 0 else states.REASONS[reason[later[0]]] or "restarted"
            rows.append(
                (
                    int(track), recording.targets[target] or None, "open" if later.size == 0 else "ended",
                    float(recording.time_s[where[0]]), float(recording.time_s[where[-1]]), int(taken.sum()),
                    int((~taken).sum()), end,
                )
            )  # fmt: skip
    names = ("track", "target", "state", "start_s", "end_s", "updates", "misses", "reason")
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(names)
    texts = {"target", "state", "reason"}
    return Table({n: list(c) if n in texts else np.array(c, float) for n, c in zip(names, columns, strict=True)})


def _decisions(recording: Plots, result: Result) -> Table:
    """List every row that was not simply used: what was decided, at which distance, against which gate, and why."""
    a = result.arrays
    status, reason = _flat(a["status"]), _flat(a["reason"])
    keep = np.flatnonzero((status != states.UPDATED) | (reason != states.R_NONE))
    marks, trials = a["track"].shape
    gated = np.isfinite(_flat(a["distance"])[keep])
    distance = np.where(gated, _flat(a["distance"])[keep], np.sqrt(_flat(a["nis"])[keep]))
    dof = np.tile(a["dof"], trials)[keep]
    usual = np.sqrt(np.array(states.UNUSUAL_NIS))[np.clip(dof, 1, 3) - 1] if keep.size else np.empty(0)
    targets = _targets(recording, trials)
    return Table(
        {
            "track": _or_nan(_flat(a["track"]))[keep],
            "row": np.tile(a["row"], trials)[keep],
            "time_s": np.tile(recording.time_s, trials)[keep],
            "decision": [states.STATUS[i] for i in status[keep]],
            "distance": distance,
            "threshold": np.where(gated, _flat(a["gate"])[keep], np.where(np.isfinite(distance), usual, np.nan)),
            "probability": np.full(keep.size, np.nan),
            "reason": [states.REASONS[i] or None for i in reason[keep]],
            "target": [targets[i] for i in keep],
            "trial": _trial(marks, trials)[keep],
            "code": [states.REASON_CODES[i] or None for i in reason[keep]],
        }
    )


def _shown(result: Result) -> NDArray[np.int64]:
    """Positions (trial by trial) of the rows with an estimate."""
    return np.flatnonzero(np.isfinite(_flat(result.arrays["state"][:, 0])))


def _probabilities(recording: Plots, result: Result) -> Table:
    a = result.arrays
    names = names_of(result)
    marks, trials = a["track"].shape
    keep = _shown(result)
    n = len(names)
    probability = np.stack([_flat(a["mode_probability"][:, m])[keep] for m in range(n)], axis=1)
    likelihood = np.stack([_flat(a["log_likelihood"][:, m])[keep] for m in range(n)], axis=1)
    targets = _targets(recording, trials)
    return Table(
        {
            "trial": np.repeat(_trial(marks, trials)[keep], n),
            "track": np.repeat(_or_nan(_flat(a["track"]))[keep], n),
            "time_s": np.repeat(np.tile(recording.time_s, trials)[keep], n),
            "model": list(names) * keep.size,
            "probability": probability.ravel(),
            "log_likelihood": likelihood.ravel(),
            "row": np.repeat(np.tile(a["row"], trials)[keep], n),
            "target": [targets[i] for i in keep for _ in range(n)],
        }
    )


def _model_states(recording: Plots, result: Result) -> Table:
    a = result.arrays
    names = names_of(result)
    marks, trials = a["track"].shape
    keep = _shown(result)
    n = len(names)
    columns: dict[str, Any] = {
        "trial": np.repeat(_trial(marks, trials)[keep], n),
        "track": np.repeat(_or_nan(_flat(a["track"]))[keep], n),
        "time_s": np.repeat(np.tile(recording.time_s, trials)[keep], n),
        "model": list(names) * keep.size,
    }
    for prefix, where, unit in (
        ("", _POSITION, "m"),
        ("velocity_", _VELOCITY, "mps"),
        ("acceleration_", _ACCELERATION, "mps2"),
    ):
        for axis, i in zip(_AXES, where, strict=True):
            values = [_flat(a["model_state"][:, m, i])[keep] for m in range(n)]
            columns[f"{prefix}{axis}_{unit}"] = np.stack(values, axis=1).ravel()
    targets = _targets(recording, trials)
    columns["target"] = [targets[i] for i in keep for _ in range(n)]
    return Table(columns)
