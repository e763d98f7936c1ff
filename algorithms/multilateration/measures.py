"""Metrics of the multilateration algorithms on one recording: for all marks, and for each target."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration import lanes
from algorithms.multilateration.tables import position_errors
from algorithms.recording import ToaMarks
from algorithms.result import Metric, Result
from algorithms.toolbox.metrics.position import claim_metrics, error_metrics, nees

_POSITION = np.array([0, 3, 6])


def measure(recording: ToaMarks, result: Result) -> list[Metric]:
    """Return the metrics of a result; those that need truth only where there is truth."""
    out = _of(recording, result, np.arange(len(recording)), "")
    if len(recording.targets) > 1:
        for target, name in enumerate(recording.targets):
            rows = recording.rows_of(target)
            if rows.size:
                out += _of(recording, result, rows, name)
    return out


def _of(recording: ToaMarks, result: Result, rows: np.ndarray, target: str) -> list[Metric]:
    a = result.arrays
    state = a["state"][rows]
    cov = a["covariance"][rows][:, _POSITION[:, None], _POSITION[None, :]]
    answered = np.isfinite(state[:, 0])
    drms = np.sqrt(cov[:, 0, 0] + cov[:, 1, 1])

    def flat(values: np.ndarray) -> np.ndarray:
        return np.moveaxis(values, -1, 0).reshape(-1, *values.shape[1:-1])

    out: list[Metric] = []
    if recording.has_truth:
        errors = flat(position_errors(recording, result)[rows])
        out += error_metrics(errors, target)
        out.append(nees(errors, flat(cov), target))
    # A mark whose noise was scaled up is a decision, listed as such; one late reception would drown the mean.
    nis = np.where(a["status"][rows] == lanes.DOWNWEIGHTED, np.nan, a["nis"][rows])
    out += claim_metrics(flat(answered), flat(drms), flat(nis), flat(a["dof"][rows]), target)
    return out
