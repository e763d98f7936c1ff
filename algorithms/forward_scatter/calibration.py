"""Errors of calibration in the predicted errors: clocks, carriers, places and wavelength that are known only so well.

Residuals do not show such errors, so what they cost is computed. The pass as it was estimated is simulated without
noise, once as the site is told and once with an error of one standard deviation, and the method that ran answers to
both. Its shift J of theta at each row is one more standard deviation: P + sum J J^T. Told places that are too large by
some percent are the same as true ones that are too small, to first order, so the method itself is left alone.

References
----------
specification 8.7, 10 ("clock or frequency mismatch").
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter.conditions import Conditions
from algorithms.forward_scatter.motion import UNKNOWNS, doppler_rows
from algorithms.forward_scatter.outputs import ANSWERED
from algorithms.forward_scatter.parameters import ScatterParameters
from algorithms.forward_scatter.piece import Arrays, Method, Piece

Floats = NDArray[np.float64]

RATE_STEP_S = 1e-3


def widen(piece: Piece, method: Method, parameters: ScatterParameters, conditions: Conditions, arrays: Arrays) -> None:
    """Add what errors of calibration cost to the covariance of theta of a pass; nothing where none is told."""
    errors = list(_errors(parameters, conditions))
    if not errors:
        return
    last = _last_answers(piece, arrays)
    plain = _answers(piece, method, arrays, _measured(piece, conditions, last))
    rows = np.ix_(piece.rows, np.arange(UNKNOWNS), np.arange(UNKNOWNS), piece.lanes)
    covariance = np.asarray(arrays["theta_covariance"], float)
    for other, late_s, offset_hz in errors:
        shift = _answers(piece, method, arrays, _measured(piece, other, last, late_s, offset_hz)) - plain
        shift = np.nan_to_num(shift)
        covariance[rows] += shift[:, :, None] * shift[:, None, :]


def _errors(parameters: ScatterParameters, told: Conditions) -> Iterator[tuple[Conditions, float, float]]:
    """What the Dopplers would be measured under: places and wavelength; delay and offset of the second ones."""
    if parameters.sigma_clock_ms > 0:
        yield told, parameters.sigma_clock_ms / 1000, 0.0
    if parameters.sigma_frequency_offset_hz > 0:
        yield told, 0.0, parameters.sigma_frequency_offset_hz
    for percent, axis in ((parameters.sigma_base_percent, 0), (parameters.sigma_spacing_percent, 1)):
        if percent > 0:
            smaller = np.ones(3)
            smaller[axis] = 1 / (1 + percent / 100)
            yield replace(told, feet=told.feet * smaller), 0.0, 0.0
    if parameters.sigma_wavelength_percent > 0:
        wavelength = told.wavelength / (1 + parameters.sigma_wavelength_percent / 100)
        yield replace(told, wavelength=wavelength), 0.0, 0.0


def _last_answers(piece: Piece, arrays: Arrays) -> Floats:
    """(5, L): theta of each trial's last row with an answer; NaN where there is none."""
    out = np.full((UNKNOWNS, piece.lanes.size), np.nan)
    for i, lane in enumerate(piece.lanes):
        answered = piece.rows[np.isin(arrays["status"][piece.rows, lane], ANSWERED)]
        if answered.size:
            out[:, i] = arrays["theta"][answered[-1], :, lane]
    return out


def _measured(
    piece: Piece, conditions: Conditions, theta: Floats, late_s: float = 0.0, offset_hz: float = 0.0
) -> Piece:
    """The pass without noise, with values where it has some; `late_s` and `offset_hz` are of every second Doppler."""
    doppler, rate = np.full_like(piece.doppler, np.nan), np.full_like(piece.rate, np.nan)
    azimuth = np.full_like(piece.azimuth, np.nan)
    for i in np.flatnonzero(np.isfinite(theta).all(axis=0)):
        one = np.ascontiguousarray(theta[:, i])

        def at(time_s: Floats, one: Floats = one) -> Floats:
            value, _ = doppler_rows(time_s, one, conditions.feet, conditions.wavelength, conditions.altitude)
            return value.T

        doppler[:, :, i] = at(piece.time)
        doppler[:, 1::2, i] = at(piece.time + late_s)[:, 1::2] + offset_hz
        if np.isfinite(piece.rate).any():
            slope = (at(piece.time + RATE_STEP_S) - at(piece.time - RATE_STEP_S)) / (2 * RATE_STEP_S)
            rate[:, : slope.shape[1], i] = slope[:, : rate.shape[1]]
        d = piece.time - one[0]
        azimuth[:, i] = np.arctan2(one[2] * d + 0.5 * one[4] * d * d, one[1] + one[3] * d)
    return replace(
        piece,
        doppler=np.where(np.isfinite(piece.doppler), doppler, np.nan),
        rate=np.where(np.isfinite(piece.rate), rate, np.nan),
        azimuth=np.where(np.isfinite(piece.azimuth), azimuth, np.nan),
    )


def _answers(piece: Piece, method: Method, arrays: Arrays, measured: Piece) -> Floats:
    """(K, 5, L): what the method says of a pass; NaN where it has no answer."""
    k, lanes = piece.rows.size, piece.lanes.size
    # Its trials stand behind an empty first one, because the methods count what they see of the first.
    own = replace(measured, rows=np.arange(k), lanes=np.arange(1, lanes + 1))
    scratch: Arrays = {}
    for name, array in arrays.items():
        if array.ndim > 1:
            shape = (k, *array.shape[1:-1], lanes + 1)
            scratch[name] = np.full(shape, np.nan) if array.dtype.kind == "f" else np.zeros(shape, array.dtype)
    method(own, scratch)
    theta = np.asarray(scratch["theta"], float)[:, :, 1:]
    return np.where(np.isin(scratch["status"][:, None, 1:], ANSWERED), theta, np.nan)
