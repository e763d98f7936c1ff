"""Metrics of the multiple-model algorithms on one recording: for all rows, and for each target."""

from __future__ import annotations

import numpy as np

from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.states import NOT_NEAREST, REJECTED
from algorithms.multiple_model.tracker import model_names
from algorithms.result import Metric, Result
from algorithms.toolbox.metrics.position import claim_metrics, error_metrics, nees
from algorithms.toolbox.motion.models import KINDS

_POSITION = np.array([0, 3, 6])


def names_of(result: Result) -> tuple[str, ...]:
    """Names of the models of a result."""
    kinds = (KINDS[k] for k in result.arrays["kind_model"])
    return model_names(tuple(zip(kinds, result.arrays["sigma_model"].tolist(), strict=True)))


def measure(recording: Plots, result: Result) -> list[Metric]:
    """Return the metrics of a result; those that need truth only where there is truth."""
    out = _of(recording, result, np.arange(len(recording)), "")
    if len(recording.targets) > 1:
        for target, name in enumerate(recording.targets):
            rows = recording.rows_of(target)
            if rows.size:
                out += _of(recording, result, rows, name)
    return out


def _of(recording: Plots, result: Result, rows: np.ndarray, target: str) -> list[Metric]:
    a = result.arrays
    # A plot that belongs to something else is no question that was left without an answer.
    rows = rows[~np.isin(a["status"][rows], (NOT_NEAREST, REJECTED)).all(axis=1)]
    state = a["state"][rows]
    cov = a["covariance"][rows][:, _POSITION[:, None], _POSITION[None, :]]

    def flat(values: np.ndarray) -> np.ndarray:
        return np.moveaxis(values, -1, 0).reshape(-1, *values.shape[1:-1])

    out: list[Metric] = []
    if recording.has_truth:
        errors = flat(state[:, _POSITION] - recording.truth_m[rows][:, :, None])
        out += error_metrics(errors, target)
        out.append(nees(errors, flat(cov), target))
        out += _velocity_metrics(flat(state[:, [1, 4, 7]] - recording.truth_velocity_mps[rows][:, :, None]), target)
    dof = np.repeat(a["dof"][rows][:, None], state.shape[-1], axis=1)
    drms = np.sqrt(cov[:, 0, 0] + cov[:, 1, 1])
    out += claim_metrics(flat(np.isfinite(state[:, 0])), flat(drms), flat(a["nis"][rows]), flat(dof), target)
    names = names_of(result)
    if len(names) > 1:
        for m, name in enumerate(names):
            share = a["mode_probability"][rows][:, m]
            share = share[np.isfinite(share)]
            value = float(share.mean()) if share.size else None
            out.append(Metric(f"mode_probability_{name}", value, "1", int(share.size), target=target))
    return out


def _velocity_metrics(errors: np.ndarray, target: str) -> list[Metric]:
    known = errors[np.isfinite(errors).all(axis=1)]
    n = len(known)

    def rms(values: np.ndarray) -> float | None:
        return float(np.sqrt(np.mean(values**2))) if n else None

    out = [Metric("rms_velocity_mps", rms(np.linalg.norm(known, axis=1)), "m/s", n, target=target)]
    for i, axis in enumerate(("east", "north", "up")):
        out.append(Metric(f"rms_velocity_{axis}_mps", rms(known[:, i]), "m/s", n, target=target))
    return out
