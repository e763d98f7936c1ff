"""Cramer-Rao bounds along a true pass: of the crossing's parameters, and of the place at each instant.

References
----------
specification 5. Differences from the paper: it takes the course for known (three unknowns); four are honest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter.conditions import Conditions
from algorithms.forward_scatter.motion import LARGEST_CONDITION, UNKNOWNS, crossing_bound, doppler_rows
from algorithms.forward_scatter.truth import true_crossings
from algorithms.recording import DopplerPairs

Floats = NDArray[np.float64]


def true_thetas(recording: DopplerPairs, conditions: Conditions) -> list[tuple[NDArray[np.int64], Floats]]:
    """Rows of each true flight and its theta (5,)."""
    crossings = true_crossings(recording, conditions.frame)
    speed = conditions.frame.turned_from_enu(recording.truth_velocity_mps)
    place = conditions.frame.from_enu(recording.truth_m)
    out = []
    known = np.flatnonzero(np.isfinite(crossings[:, 0]))
    keys = [crossings[known, 0], recording.target[known]]
    for tau, target in sorted(set(zip(*(k.tolist() for k in keys), strict=True))):
        rows = known[(crossings[known, 0] == tau) & (recording.target[known] == target)]
        nearest = rows[np.argmin(np.abs(place[rows, 1]))]
        t = recording.time_s[rows] - tau
        vy = speed[rows, 1]
        ay = float(np.polyfit(t, vy, 1)[0]) if rows.size > 2 and np.ptp(vy) > 1e-6 else 0.0
        at = vy[np.argmin(np.abs(t))] - ay * t[np.argmin(np.abs(t))]
        out.append((rows, np.array([tau, crossings[nearest, 1], at, speed[nearest, 0], ay])))
    return out


def bounds_of_crossing(recording: DopplerPairs, conditions: Conditions, unknowns: int) -> Floats:
    """(M, unknowns): bound of the standard deviations of theta after each row of its flight."""
    out = np.full((len(recording), unknowns), np.nan)
    for rows, theta in true_thetas(recording, conditions):
        height = float(recording.truth_m[rows[0], 2] - conditions.frame.origin_m[2])
        _, g = doppler_rows(recording.time_s[rows], theta, conditions.feet, conditions.wavelength, height)
        measured = np.isfinite(recording.doppler_hz[rows][:, :, 0]) if recording.doppler_hz.shape[2] else None
        there = np.ones(g.shape[:2], np.bool_) if measured is None else measured.T
        out[rows] = crossing_bound(g, there, conditions.sigma, unknowns)
    return out


def position_bound(recording: DopplerPairs, conditions: Conditions, unknowns: int) -> Floats:
    """(M,) m: bound of the rms horizontal error at each row, from what was measured in the first trial."""
    out = np.full(len(recording), np.nan)
    for rows, theta in true_thetas(recording, conditions):
        height = float(recording.truth_m[rows[0], 2] - conditions.frame.origin_m[2])
        time = recording.time_s[rows]
        _, g = doppler_rows(time, theta, conditions.feet, conditions.wavelength, height)
        g = np.where(np.isfinite(recording.doppler_hz[rows][:, :, 0]).T[:, :, None], g, 0.0)[:, :, :unknowns]
        info = np.cumsum(np.einsum("cki,ckj->kij", g, g) / conditions.sigma**2, axis=0)
        d = time - theta[0]
        for k, row in enumerate(rows):
            scale = np.sqrt(np.diagonal(info[k]))
            if not (scale > 0).all():
                continue
            scaled = info[k] / np.outer(scale, scale)
            if np.linalg.cond(scaled) > LARGEST_CONDITION:
                continue
            covariance = np.linalg.inv(scaled) / np.outer(scale, scale)
            by = np.zeros((2, UNKNOWNS))
            by[0, :4] = (-theta[3], 1.0, 0.0, d[k])
            by[1] = (-(theta[2] + theta[4] * d[k]), 0.0, d[k], 0.0, 0.5 * d[k] ** 2)
            by = by[:, :unknowns]
            out[row] = np.sqrt(np.trace(by @ covariance @ by.T))
    return out
