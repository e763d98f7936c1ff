"""Simulate the times of arrival and decoded altitudes of marks over trials.

A mark's gate opens at `time_s`; the pulse leaves up to `gate_length_s` later, and the emitter has moved on until then.
Every trial draws, in this order and whether it needs them or not: emission offset (M), timing noise (M, S), reception
(M, S), altitude noise (M), decoding (M), altitude bias (1), outlier choice and size (M, S each). Switching one effect
on therefore leaves the draws of the others as they were.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.spec import trial_stream
from algorithms.toolbox.frames.earth import altitude_from_position
from algorithms.toolbox.scenario.trajectory import Trajectory
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MarkNoise:
    """What makes a mark imperfect.

    Attributes
    ----------
    sigma_toa_s : s
    reception_probability : (M, S)
    sigma_altitude_m, altitude_bias_sd_m, altitude_step_m : m; a step of 0 leaves the altitude unrounded
    decoding_probability : of the altitude
    gate_length_s : s, the emission's largest offset
    outlier_probability, outlier_late_s : share of receptions that are late, and between which two delays
    """

    sigma_toa_s: float
    reception_probability: Floats
    sigma_altitude_m: float = 0.0
    altitude_bias_sd_m: float = 0.0
    altitude_step_m: float = 0.0
    decoding_probability: float = 1.0
    gate_length_s: float = 0.0
    outlier_probability: float = 0.0
    outlier_late_s: tuple[float, float] = (0.2e-6, 20e-6)


def simulate_marks(
    trajectory: Trajectory, stations_m: Floats, earth: Floats, noise: MarkNoise, trials: tuple[int, ...], seed: int
) -> tuple[Floats, Floats, Floats]:
    """Draw the marks of one emitter.

    Returns
    -------
    toa_s : (M, S, L) float, s, offset from the gate's opening; NaN = not received
    altitude_m : (M, L) float, m; NaN = not decoded
    emission_s : (M, L) float, s, offset of the emission
    """
    marks, count, lanes = len(trajectory.position_m), len(stations_m), len(trials)
    toa = np.empty((marks, count, lanes))
    altitude = np.empty((marks, lanes))
    emission = np.empty((marks, lanes))
    for lane, trial in enumerate(trials):
        rng = trial_stream(seed, trial, 1)
        emission[:, lane] = noise.gate_length_s * rng.random(marks)
        timing = noise.sigma_toa_s * rng.standard_normal((marks, count))
        received = rng.random((marks, count)) < noise.reception_probability
        white = noise.sigma_altitude_m * rng.standard_normal(marks)
        decoded = rng.random(marks) < noise.decoding_probability
        bias = noise.altitude_bias_sd_m * rng.standard_normal()
        late = rng.random((marks, count)) < noise.outlier_probability
        delay = rng.uniform(*noise.outlier_late_s, (marks, count))
        position = trajectory.position_m + emission[:, lane, None] * trajectory.velocity_mps
        distance = np.linalg.norm(position[:, None] - stations_m, axis=2)
        offset = distance / SPEED_OF_LIGHT_MPS + emission[:, lane, None] + timing + np.where(late, delay, 0.0)
        toa[:, :, lane] = np.where(received, offset, np.nan)
        value = altitude_from_position(position, earth) + bias + white
        if noise.altitude_step_m > 0:
            value = np.round(value / noise.altitude_step_m) * noise.altitude_step_m
        altitude[:, lane] = np.where(decoded, value, np.nan)
    return toa, altitude, emission
