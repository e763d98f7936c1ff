"""The textbook's interacting multiple models in another order: every pair is predicted first, and merged afterwards.

Written apart from the compiled filter, in matrices of NumPy, to say by how much the two differ: the paper claims that
its MMA2 with all hypotheses merged is the textbook's IMM, and that merging may come before the prediction.

References
----------
blom1988; barshalom2001, sec. 11.6; trudymai2023, eqs. (4) to (9).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from algorithms.multiple_model import mma2_122
from algorithms.multiple_model.measurements import antenna_of
from algorithms.multiple_model.parameters import PaperParameters
from algorithms.multiple_model.scenario import AeroballisticParameters, simulate
from algorithms.multiple_model.tracker import ModelSet, run_bank
from algorithms.spec import LocalContext
from algorithms.toolbox.frames.bicone import antenna_axes, covariance_from_bicone

Floats = NDArray[np.float64]

_H = np.zeros((3, 9))
_H[[0, 1, 2], [0, 3, 6]] = 1


def predict_then_merge(
    y: Floats, covariances: Floats, chosen: ModelSet, dt_s: float, velocity_sd: float, acceleration_sd: float
) -> Floats:
    """(M, 9) mean of all models after each mark; positions `y` (M, 3) every dt_s with `covariances` (M, 3, 3)."""
    n = len(chosen.models)
    matrix = np.linalg.matrix_power(np.array(chosen.transition), round(dt_s / chosen.step_s))
    f, q, x, p = [], [], [], []
    for kind, sigma in chosen.models:
        ca = float(kind == "ca")
        g = np.array([0.5 * dt_s**2, dt_s, ca])
        f.append(np.kron(np.eye(3), np.array([[1, dt_s, 0.5 * dt_s**2 * ca], [0, 1, dt_s * ca], [0, 0, ca]])))
        q.append(sigma**2 * np.kron(np.eye(3), np.outer(g, g)))
        start = np.kron(np.eye(3), np.diag([0.0, velocity_sd**2, acceleration_sd**2 * ca]))
        start[::3, ::3] = covariances[0]
        x.append(np.kron(y[0], np.array([1.0, 0.0, 0.0])))
        p.append(start)
    share = np.full(n, 1 / n)
    out = np.empty((len(y), 9))
    out[0] = x[0]
    for k in range(1, len(y)):
        joint = share[:, None] * matrix
        predicted = joint.sum(axis=0)
        means, spreads, log = [], [], np.empty(n)
        for j in range(n):
            weights = joint[:, j] / predicted[j]
            pairs = [(f[j] @ x[i], f[j] @ p[i] @ f[j].T + q[j]) for i in range(n)]
            mean = np.einsum("i,ik->k", weights, np.array([pair[0] for pair in pairs]))
            spread = sum(w * (c + np.outer(m - mean, m - mean)) for w, (m, c) in zip(weights, pairs, strict=True))
            s = _H @ spread @ _H.T + covariances[k]
            gain = np.linalg.solve(s, _H @ spread).T
            innovation = y[k] - _H @ mean
            log[j] = -0.5 * (innovation @ np.linalg.solve(s, innovation) + np.linalg.slogdet(s)[1])
            means.append(mean + gain @ innovation)
            updated = spread - gain @ s @ gain.T
            # What rounding leaves unsymmetric would grow from mark to mark.
            spreads.append((updated + updated.T) / 2)
        x, p = means, spreads
        share = predicted * np.exp(log - log.max())
        share /= share.sum()
        out[k] = np.einsum("i,ik->k", share, np.array(x))
    return out


@lru_cache(maxsize=1)
def largest_difference_m() -> float:
    """Return the largest distance of the two answers' positions on one trial of the arc and the manoeuvre at 1 Hz."""
    recording = simulate(AeroballisticParameters(rate_hz=1.0), (0,), 0)
    parameters = PaperParameters()
    chosen = replace(mma2_122.models_of(mma2_122.Mma2Parameters()), merging="moment", output="moment")
    found = run_bank(recording, parameters, chosen, LocalContext(), lean=True)
    antenna = antenna_of(recording)
    axes = antenna_axes(np.radians(antenna.azimuth_deg or 0.0), np.radians(antenna.elevation_deg or 0.0))
    range_sd, elevation_sd, azimuth_sd = (float(value) for value in found.prepared.sd[0])
    z = found.prepared.z[:, :, 0]
    covariances = covariance_from_bicone(z[:, 0], z[:, 1], z[:, 2], (range_sd, elevation_sd, azimuth_sd), axes)
    other = predict_then_merge(
        found.prepared.y[:, :, 0], covariances, chosen, 1.0, parameters.start_velocity_sd_mps,
        parameters.start_acceleration_sd_mps2,
    )  # fmt: skip
    ours = found.report.state[:, :, 0]
    return float(np.linalg.norm((ours - other)[:, ::3], axis=1).max())
