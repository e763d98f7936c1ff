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
from algorithms.toolbox.metrics.position import claim_metrics, error_metrics, nees

Floats = NDArray[np.float64]


def measure(recording: ToaMarks, result: Result) -> list[Metric]:
    """Return the metrics of a result; those that need truth only where there is truth."""
    a = result.arrays
    covariance = position_covariance(result)
    what = _What(
        errors_m=position_errors(recording, result) if recording.has_truth else None,
        covariance_m2=covariance,
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
    covariance_m2: Floats
    answered: NDArray[np.bool_]
    drms_m: Floats
    nis: Floats
    dof: NDArray[np.int32]


def _of(what: _What, rows: slice | NDArray[np.int64], target: str) -> list[Metric]:
    def flat(values: NDArray[Any]) -> NDArray[Any]:
        return np.moveaxis(values[rows], -1, 0).reshape(-1, *values.shape[1:-1])

    out: list[Metric] = []
    if what.errors_m is not None:
        errors = flat(what.errors_m)
        out += error_metrics(errors, target)
        out.append(nees(errors, unpack(flat(what.covariance_m2), axis=1), target))
    out += claim_metrics(flat(what.answered), flat(what.drms_m), flat(what.nis), flat(what.dof), target)
    return out
