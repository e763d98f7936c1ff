"""Metrics of the forward-scatter algorithms on one recording: for all rows, and for each target."""

from __future__ import annotations

import numpy as np

from algorithms.errors import RecordingError
from algorithms.forward_scatter.conditions import site_of
from algorithms.forward_scatter.outputs import ANSWERED
from algorithms.forward_scatter.truth import true_crossings
from algorithms.recording import DopplerPairs
from algorithms.result import Metric, Result
from algorithms.toolbox.frames.forward_scatter import scatter_frame
from algorithms.toolbox.metrics.position import claim_metrics, error_metrics


def measure(recording: DopplerPairs, result: Result) -> list[Metric]:
    """Return the metrics of a result; those that need truth only where there is truth."""
    out = _of(recording, result, np.arange(len(recording)), "")
    if len(recording.targets) > 1:
        for target, name in enumerate(recording.targets):
            rows = recording.rows_of(target)
            if rows.size:
                out += _of(recording, result, rows, name)
    return out


def _of(recording: DopplerPairs, result: Result, rows: np.ndarray, target: str) -> list[Metric]:
    a = result.arrays
    state, plane = a["state"][rows], a["covariance"][rows]
    answered = np.isin(a["status"][rows], ANSWERED)
    out: list[Metric] = []
    if recording.has_truth:
        errors = state[:, ::3] - recording.truth_m[rows][:, :, None]
        out += error_metrics(np.moveaxis(errors, -1, 0).reshape(-1, 3), target)
        out.append(_crossing(recording, result, rows, target))
    drms = np.sqrt(plane[:, 0, 0] + plane[:, 1, 1])
    last = _last_of_passes(result, rows)
    out += claim_metrics(
        answered.T.ravel(), drms.T.ravel(), np.where(last, a["chi2"][rows], np.nan).T.ravel(), a["dof"][rows].T.ravel(),
        target,
    )  # fmt: skip
    passes = int(sum(np.unique(t[t > 0]).size for t in a["track"][rows].T))
    return [*out, Metric("passes", float(passes), "1", passes, target=target)]


def _last_of_passes(result: Result, rows: np.ndarray) -> np.ndarray:
    """Whether a row is the last of its pass: chi2 is of all data so far, so it counts once."""
    track = result.arrays["track"][rows]
    following = np.vstack([track[1:], np.zeros((1, track.shape[1]), track.dtype)]) if len(track) else track
    last: np.ndarray = (track > 0) & (track != following)
    return last


def _crossing(recording: DopplerPairs, result: Result, rows: np.ndarray, target: str) -> Metric:
    """Root mean square of the crossing distance's error over the answered rows."""
    try:
        site = site_of(recording)
    except RecordingError:
        return Metric("crossing_distance_rms_m", None, "m", 0, target=target)
    places = site.terminal_positions()
    count = len(site.transmitters)
    true = true_crossings(recording, scatter_frame(places[:count], places[count:]))[rows, 1]
    answered = np.isin(result.arrays["status"][rows], ANSWERED)
    errors = np.where(answered, result.arrays["theta"][rows, 1] - true[:, None], np.nan)
    errors = errors[np.isfinite(errors)]
    value = float(np.sqrt(np.mean(errors**2))) if errors.size else None
    return Metric("crossing_distance_rms_m", value, "m", int(errors.size), target=target)
