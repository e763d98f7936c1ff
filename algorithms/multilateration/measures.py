"""Metrics of the multilateration algorithms on one recording: for all marks, and for each target."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration import lanes
from algorithms.multilateration.outputs import position_covariance
from algorithms.multilateration.tables import position_errors
from algorithms.recording import ToaMarks
from algorithms.result import Metric, Result
from algorithms.toolbox.kernels.symmetric import unpack
from algorithms.toolbox.metrics.position import claim_metrics, error_metrics, mean_nees, normalised_squares

Floats = NDArray[np.float64]

# Covariances unpacked at once: more take no less time, and the memory of all of them.
_AT_ONCE = 1 << 14


def measure(recording: ToaMarks, result: Result) -> list[Metric]:
    """Return the metrics of a result; those that need truth only where there is truth."""
    a = result.arrays
    covariance = position_covariance(result)
    errors = position_errors(recording, result) if recording.has_truth else None
    what = _What(
        errors_m=errors,
        # Once for all marks: metrics of a target take theirs.
        squares=None if errors is None else _squares(errors, covariance),
        answered=np.isfinite(a["state"][:, 0]),
        drms_m=np.sqrt(covariance[:, 0] + covariance[:, 2]),
        # A mark whose noise was scaled up is a decision, listed as such; one late reception would drown the mean.
        nis=np.where(a["status"] == lanes.DOWNWEIGHTED, np.nan, a["nis"]),
        dof=a["dof"],
    )
    out = _of(what, slice(None), "")
    if len(recording.targets) > 1:
        for name, rows in zip(recording.targets, recording.rows_by_target(), strict=True):
            if rows.size:
                out += _of(what, rows, name)
    return out


class _What(NamedTuple):
    """What metrics are made of: (mark, ..., trial)."""

    errors_m: Floats | None
    squares: Floats | None
    answered: NDArray[np.bool_]
    drms_m: Floats
    nis: Floats
    dof: NDArray[np.int32]


def _of(what: _What, rows: slice | NDArray[np.int64], target: str) -> list[Metric]:
    def flat(values: NDArray[Any]) -> NDArray[Any]:
        return np.moveaxis(values[rows], -1, 0).reshape(-1, *values.shape[1:-1])

    out: list[Metric] = []
    if what.errors_m is not None and what.squares is not None:
        out += error_metrics(flat(what.errors_m), target)
        out.append(mean_nees(flat(what.squares), target))
    out += claim_metrics(flat(what.answered), flat(what.drms_m), flat(what.nis), flat(what.dof), target)
    return out


def _squares(errors_m: Floats, covariance_m2: Floats) -> Floats:
    """(mark, trial): normalised squares of errors (mark, 3, trial) with covariances (mark, 6, trial)."""
    out = np.empty((len(errors_m), errors_m.shape[2]))
    for trial in range(errors_m.shape[2]):
        for start in range(0, len(errors_m), _AT_ONCE):
            some = slice(start, start + _AT_ONCE)
            full = unpack(covariance_m2[some, :, trial], axis=1)
            out[some, trial] = normalised_squares(errors_m[some, :, trial], full)
    return out
