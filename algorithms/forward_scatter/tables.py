"""Results of the forward-scatter algorithms as long tables (columns as the HTTP API fixes them)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter import outputs
from algorithms.forward_scatter.track_table import is_unsigned, signed_dopplers, track_table
from algorithms.recording import DopplerPairs
from algorithms.result import Result, Table

_POSITION = (0, 3, 6)
_AXES = ("east", "north", "up")
REASONS = {
    outputs.NO_VALUES: "no Doppler since the last pass ended",
    outputs.INSUFFICIENT: "fewer Dopplers than unknowns",
    outputs.NO_LINE: "too few values in the window for a line",
    outputs.NO_CROSSING: "the Dopplers do not fall, so nothing crosses",
    outputs.INVALID: "angular velocity and crossing times contradict each other",
    outputs.NOT_CONVERGED: "the fit did not converge",
    outputs.AT_BOUND: "the fit ended at an end of the base line",
    outputs.FALLBACK: "formula (19) in place of the fit",
    outputs.EXTRAPOLATED: "the crossing lies ahead",
    outputs.CROSSED: "the crossing is kept",
    outputs.FITTED: "",
    outputs.HELD: "between two fits",
}
REJECTED = "off the line or the fit by more than 4 sigma"
KEPT = "crossing time of this receiver is kept from here on"


def tabulate(recording: DopplerPairs, result: Result) -> dict[str, Table]:
    """Return the tables states, crossings, tracks, decisions and, with truth, errors of one recording."""
    tables = {
        "states": _states(recording, result),
        "crossings": _crossings(recording, result),
        "dopplers": _dopplers(recording, result),
        "tracks": track_table(recording, result),
        "decisions": _decisions(recording, result),
    }
    if recording.has_truth:
        tables["errors"] = _errors(recording, result)
    return tables


def _flat(array: NDArray[Any]) -> NDArray[Any]:
    """(mark, trial) -> rows: trial by trial, marks in time order."""
    return array.T.reshape(-1)


def _common(recording: DopplerPairs, result: Result) -> dict[str, Any]:
    marks, trials = result.arrays["time_s"].shape
    trial = np.full(marks, np.nan) if trials == 1 else np.repeat(np.arange(trials, dtype=float), marks)
    track = _flat(result.arrays["track"])
    return {
        "trial": trial,
        "track": np.where(track > 0, track, np.nan),
        "time_s": _flat(result.arrays["time_s"]),
    }


def _ends(recording: DopplerPairs, result: Result) -> dict[str, Any]:
    trials = result.arrays["time_s"].shape[1]
    return {
        "row": np.tile(result.arrays["row"], trials),
        "target": [recording.targets[i] or None for i in recording.target] * trials,
    }


def _status(result: Result) -> list[str]:
    return [outputs.STATUS[i] for i in _flat(result.arrays["status"])]


def _states(recording: DopplerPairs, result: Result) -> Table:
    a = result.arrays
    state, cov = a["state"], a["covariance"]
    with np.errstate(invalid="ignore"):
        sd = np.sqrt(np.stack([cov[:, i, i] for i in range(3)], axis=1))
    columns = _common(recording, result)
    for k, (prefix, unit) in enumerate((("", "m"), ("velocity_", "mps"), ("acceleration_", "mps2"))):
        for axis, i in zip(_AXES, _POSITION, strict=True):
            columns[f"{prefix}{axis}_{unit}"] = _flat(state[:, i + k])
    for i, axis in enumerate(_AXES):
        columns[f"sigma_{axis}_m"] = _flat(sd[:, i])
    columns["drms_m"] = _flat(np.hypot(sd[:, 0], sd[:, 1]))
    columns["nis"] = np.full(columns["time_s"].size, np.nan)
    columns["dof"] = np.zeros(columns["time_s"].size, np.int64)
    columns["status"] = _status(result)
    used = a["used"]
    words = [
        " ".join(c for c, on in zip(recording.channels, row, strict=True) if on) or None
        for row in used.transpose(2, 0, 1).reshape(-1, used.shape[1]).tolist()
    ]
    columns["used"] = words
    columns |= _ends(recording, result)
    columns["covariance_east_north_m2"] = _flat(cov[:, 0, 1])
    return Table(columns)


def _crossings(recording: DopplerPairs, result: Result) -> Table:
    """What each row says about the crossing: time, distance, velocities, with their standard deviations."""
    a = result.arrays
    columns = _common(recording, result)
    names = ("crossing_s", "distance_m", "across_mps", "along_mps", "acceleration_mps2")
    with np.errstate(invalid="ignore"):
        sd = np.sqrt(np.stack([a["theta_covariance"][:, i, i] for i in range(5)], axis=1))
    for i, name in enumerate(names):
        columns[name] = _flat(a["theta"][:, i])
        columns[f"sigma_{name}"] = _flat(sd[:, i])
    for end, name in enumerate(("low", "high")):
        columns[f"distance_{name}_m"] = _flat(a["distance_interval_m"][:, end])
    columns["course_deg"] = np.degrees(np.arctan2(columns["across_mps"], columns["along_mps"]))
    columns["chi2"] = _flat(a["chi2"])
    columns["dof"] = _flat(a["dof"])
    columns["status"] = _status(result)
    for j in range(2) if "line" in a else ():
        for i, name in enumerate(("centre_s", "centre_hz", "slope_hz_s", "squared_times_s2", "values", "zero_s")):
            if name != "squared_times_s2":
                columns[f"line_{j + 1}_{name}"] = _flat(a["line"][:, j, i])
        columns[f"crossing_{j + 1}_s"] = _flat(a["crossing_s"][:, j])
        columns[f"kept_{j + 1}"] = _flat(a["frozen"][:, j]).astype(float)
    if "omega_rad_s" in a:
        columns["omega_rad_s"] = _flat(a["omega_rad_s"])
    for name in ("difference_hz", "gamma_hz_s", "height_m"):
        if name in a:
            columns[name] = _flat(a[name])
    if "azimuth_rad" in a:
        columns["azimuth_deg"] = np.degrees(_flat(a["azimuth_rad"]))
    return Table(columns | _ends(recording, result))


def _dopplers(recording: DopplerPairs, result: Result) -> Table:
    """Every Doppler with what the pass's last estimate gives there, and its residual against that."""
    a = result.arrays
    predicted = _predicted(recording, result)
    marks, channels, trials = a["residual_hz"].shape
    common = _common(recording, result)
    ends = _ends(recording, result)
    return Table(
        {
            **{name: np.concatenate([values] * channels) for name, values in common.items()},
            "channel": [c for c in recording.channels for _ in range(marks * trials)],
            "doppler_hz": np.concatenate([_flat(recording.doppler_hz[:, c]) for c in range(channels)]),
            "predicted_hz": np.concatenate([_flat(predicted[:, c]) for c in range(channels)]),
            "residual_hz": np.concatenate([_flat(a["residual_hz"][:, c]) for c in range(channels)]),
            "used": np.concatenate([_flat(a["used"][:, c]).astype(float) for c in range(channels)]),
            "row": np.concatenate([ends["row"]] * channels),
            "target": ends["target"] * channels,
        }
    )


def _predicted(recording: DopplerPairs, result: Result) -> NDArray[np.float64]:
    """(M, C, L) Hz; magnitudes where the Dopplers are."""
    residual = np.asarray(result.arrays["residual_hz"], float)
    if not is_unsigned(result):
        return np.asarray(recording.doppler_hz - residual)
    out = np.full_like(residual, np.nan)
    track = result.arrays["track"]
    for trial in range(track.shape[1]):
        for one in np.unique(track[:, trial]):
            where = np.flatnonzero(track[:, trial] == one)
            signed = signed_dopplers(recording, where, trial, unsigned=True)
            out[where, :, trial] = np.abs(signed - residual[where, :, trial])
    return out


def _errors(recording: DopplerPairs, result: Result) -> Table:
    a = result.arrays
    errors = a["state"][:, ::3] - recording.truth_m[:, :, None]
    velocity = a["state"][:, 1::3] - recording.truth_velocity_mps[:, :, None]
    keep = np.flatnonzero(np.isfinite(_flat(errors[:, 0])))
    common, ends = _common(recording, result), _ends(recording, result)
    return Table(
        {
            "trial": common["trial"][keep],
            "track": common["track"][keep],
            "target": [ends["target"][i] for i in keep],
            "time_s": common["time_s"][keep],
            **{f"error_{axis}_m": _flat(errors[:, i])[keep] for i, axis in enumerate(_AXES)},
            "error_horizontal_m": _flat(np.hypot(errors[:, 0], errors[:, 1]))[keep],
            "error_velocity_mps": _flat(np.sqrt((velocity * velocity).sum(axis=1)))[keep],
            "row": ends["row"][keep],
        }
    )


def _decisions(recording: DopplerPairs, result: Result) -> Table:
    """Dopplers that were left out, rows without an estimate, and when a crossing was kept."""
    a = result.arrays
    listed: list[tuple[Any, ...]] = []
    sigma = float(result.settings["sigma_doppler_hz"].value) if "sigma_doppler_hz" in result.settings else np.nan
    trials = a["track"].shape[1]
    measured = np.isfinite(recording.doppler_hz)
    for trial in range(trials):
        number = float(trial) if trials > 1 else np.nan
        done = np.isfinite(a["residual_hz"][:, :, trial])
        out = np.argwhere(measured[:, :, trial] & done & ~a["used"][:, :, trial])
        for k, c in out.tolist():
            far = abs(a["residual_hz"][k, c, trial]) / sigma
            listed.append((k, trial, "rejected", far, 4.0, REJECTED, number, f"channel_{recording.channels[c]}"))
        status = a["status"][:, trial]
        for k in np.flatnonzero(~np.isin(status, outputs.ANSWERED) & (a["track"][:, trial] > 0)).tolist():
            code = outputs.STATUS[status[k]]
            listed.append((k, trial, code, np.nan, np.nan, REASONS[int(status[k])], number, code))
        if "frozen" in a:
            kept = a["frozen"][:, :, trial]
            before = np.vstack([np.zeros((1, kept.shape[1]), np.bool_), kept[:-1]]) if len(kept) else kept
            for k, j in np.argwhere(kept & ~before).tolist():
                listed.append((k, trial, "kept", np.nan, np.nan, KEPT, number, f"receiver_{j + 1}"))
    listed.sort(key=lambda one: (one[1], one[0]))
    rows = [one[0] for one in listed]
    track = np.array([a["track"][one[0], one[1]] for one in listed], float)
    return Table(
        {
            "track": np.where(track > 0, track, np.nan),
            "row": recording.row[rows] if rows else np.empty(0, np.int64),
            "time_s": recording.time_s[rows] if rows else np.empty(0),
            "decision": [one[2] for one in listed],
            "distance": np.array([one[3] for one in listed], float),
            "threshold": np.array([one[4] for one in listed], float),
            "probability": np.full(len(listed), np.nan),
            "reason": [one[5] for one in listed],
            "target": [recording.targets[recording.target[k]] or None for k in rows],
            "trial": np.array([one[6] for one in listed], float),
            "code": [one[7] for one in listed],
        }
    )
