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

# The base line is cut into so many parts.
PLACES = 80


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


def bounds_of_crossing(
    recording: DopplerPairs, conditions: Conditions, unknowns: int, sigma_azimuth_rad: float | None = None
) -> Floats:
    """(M, unknowns): bound of the standard deviations of theta after each row of its flight.

    From what was measured in the first trial; with azimuths too where their error is given.
    """
    out = np.full((len(recording), unknowns), np.nan)
    for rows, theta in true_thetas(recording, conditions):
        height = float(recording.truth_m[rows[0], 2] - conditions.frame.origin_m[2])
        time = recording.time_s[rows]
        _, g = doppler_rows(time, theta, conditions.feet, conditions.wavelength, height)
        measured = np.isfinite(recording.doppler_hz[rows][:, :, 0]).T
        extra = None
        if sigma_azimuth_rad is not None:
            there = np.isfinite(recording.azimuth_rad[rows][:, 0])
            extra = azimuth_information(time, theta, sigma_azimuth_rad) * there[:, None, None]
        out[rows] = crossing_bound(g, measured, conditions.sigma, unknowns, extra)
    return out


def azimuth_information(time_s: Floats, theta: Floats, sigma_rad: float) -> Floats:
    """(K, 5, 5): information of an azimuth phi = atan2(y, x) at each instant."""
    tau, s, vy, vx, ay = theta
    d = time_s - tau
    x, y = s + vx * d, vy * d + 0.5 * ay * d * d
    zero, one = np.zeros_like(d), np.ones_like(d)
    dx = np.stack([-vx * one, one, zero, d, zero], axis=1)
    dy = np.stack([-(vy + ay * d), zero, d, zero, 0.5 * d * d], axis=1)
    row = (x[:, None] * dy - y[:, None] * dx) / (x * x + y * y)[:, None]
    return np.asarray(row[:, :, None] * row[:, None, :] / sigma_rad**2)


def bounds_along_base(conditions: Conditions, time_s: Floats, theta: Floats) -> tuple[Floats, Floats]:
    """Places along the base line, m, and there (place, 4) bounds of s, m, for this pass moved to that place.

    Columns: course known at the crossing and at the end of the pass, course unknown at both.
    """
    places = conditions.a * np.arange(1, PLACES) / PLACES
    out = np.full((places.size, 4), np.nan)
    at = int(np.searchsorted(time_s, theta[0])), len(time_s) - 1
    stops = min(at[0], at[1]) + 1, len(time_s)
    for i, s in enumerate(places):
        moved = theta.copy()
        moved[1] = s
        _, g = doppler_rows(time_s, moved, conditions.feet, conditions.wavelength, conditions.altitude)
        for j, unknowns in enumerate((3, 4)):
            for k, stop in enumerate(stops):
                # All rows as those of one instant: the bound after the last of them.
                together = g[:, :stop].reshape(-1, 1, UNKNOWNS)
                there = np.ones(together.shape[:2], np.bool_)
                out[i, 2 * j + k] = crossing_bound(together, there, conditions.sigma, unknowns)[0, 1]
    return places, out


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
