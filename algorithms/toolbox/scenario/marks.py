"""Simulate the times of arrival and decoded altitudes of marks over trials.

A mark's gate opens at `time_s`; the pulse leaves up to `gate_length_s` later, and the emitter has moved on until then.
Each kind of draw of a trial has a stream of its own and is made only where the noise needs it. A trial therefore does
not depend on its neighbours, and switching one effect on leaves the draws of the others as they were. Everything is
elementwise arithmetic on arrays with the trials innermost: no kernel has to be compiled, and no bit depends on how
trials are cut.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.spec import trial_stream
from algorithms.toolbox.scenario.trajectory import Trajectory
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]

# Purposes of the random streams; 0 belongs to the algorithm.
EMISSION, TIMING, RECEPTION, ALTITUDE, DECODING, BIAS, OUTLIER, OUTLIER_SIZE = range(1, 9)
# So many trials at a time stay in the cache.
BLOCK = 16


@dataclass(frozen=True)
class MarkNoise:
    """What makes a mark imperfect.

    Attributes
    ----------
    sigma_toa_s : s, of each time of arrival; one number, or (S,)
    reception_probability : (M, S)
    clock_error_s : (M, S) s, by how much each station's clock is ahead
    sigma_altitude_m, altitude_bias_sd_m, altitude_step_m : m; a step of 0 leaves the altitude unrounded
    decoding_probability : of the altitude
    emission_offset_s, gate_length_s : s, the emission's least offset, and how much later it may be
    outlier_share, outlier_late_s : share of receptions that are late, and between which two delays
    """

    sigma_toa_s: float | Floats
    reception_probability: Floats
    clock_error_s: Floats | None = None
    sigma_altitude_m: float = 0.0
    altitude_bias_sd_m: float = 0.0
    altitude_step_m: float = 0.0
    decoding_probability: float = 1.0
    emission_offset_s: float = 0.0
    gate_length_s: float = 0.0
    outlier_share: float = 0.0
    outlier_late_s: tuple[float, float] = (0.2e-6, 20e-6)


class SimulatedMarks(NamedTuple):
    """What was measured, and when it was sent."""

    toa_s: Floats
    """(M, S, L) s, offset from the gate's opening; NaN = not received"""
    altitude_m: Floats
    """(M, L) m; NaN = not decoded"""
    emission_s: Floats
    """(M, L) s, offset of the emission from the gate's opening"""


def simulate_marks(
    trajectory: Trajectory, stations_m: Floats, noise: MarkNoise, trials: Sequence[int], seed: int
) -> SimulatedMarks:
    """Draw the marks of emitters whose true states are `trajectory` (M instants), at stations (S, 3) m."""
    marks, stations, lanes = len(trajectory.position_m), len(stations_m), len(trials)
    out = SimulatedMarks(np.empty((marks, stations, lanes)), np.empty((marks, lanes)), np.empty((marks, lanes)))
    for first in range(0, lanes, BLOCK):
        block = slice(first, first + BLOCK)
        draw = _Draws(seed, trials[block])
        emission = _emission(noise, marks, draw)
        out.emission_s[:, block] = emission
        out.toa_s[:, :, block] = _times_of_arrival(trajectory, stations_m, noise, emission, draw)
        out.altitude_m[:, block] = _altitudes(trajectory, noise, emission, draw)
    return out


_Fill = Callable[[np.random.Generator, Floats], object]


class _Draws:
    """Random numbers of a block of trials, the trials last."""

    def __init__(self, seed: int, trials: Sequence[int]) -> None:
        self._seed = seed
        self._trials = trials

    def _of(
        self, purpose: int, shape: tuple[int, ...], fill: Callable[[np.random.Generator, Floats], object]
    ) -> Floats:
        rows = np.empty((len(self._trials), int(np.prod(shape))))
        for trial, row in zip(self._trials, rows, strict=True):
            fill(trial_stream(self._seed, trial, purpose), row)
        return np.ascontiguousarray(rows.T).reshape(*shape, len(self._trials))

    def normal(self, purpose: int, *shape: int) -> Floats:
        """Draw from the standard normal distribution."""
        return self._of(purpose, shape, lambda rng, row: rng.standard_normal(out=row))

    def uniform(self, purpose: int, *shape: int) -> Floats:
        """Draw from 0 to 1."""
        return self._of(purpose, shape, lambda rng, row: rng.random(out=row))


def _emission(noise: MarkNoise, marks: int, draw: _Draws) -> Floats:
    """Offset of the emission, (M, block) s; (1, 1) where all are the same."""
    if noise.gate_length_s == 0.0:
        return np.full((1, 1), noise.emission_offset_s)
    return noise.emission_offset_s + noise.gate_length_s * draw.uniform(EMISSION, marks)


def _times_of_arrival(
    trajectory: Trajectory, stations_m: Floats, noise: MarkNoise, emission: Floats, draw: _Draws
) -> Floats:
    """(M, S, block) s."""
    marks, stations = len(trajectory.position_m), len(stations_m)
    # Axis by axis: (M, block) planes fit the cache, (M, S, 3, block) does not.
    where = [trajectory.position_m[:, a, None] + emission * trajectory.velocity_mps[:, a, None] for a in range(3)]
    sigma = np.broadcast_to(noise.sigma_toa_s, stations)
    toa = draw.normal(TIMING, marks, stations)
    for s in range(stations):
        d = [w - stations_m[s, a] for a, w in enumerate(where)]
        flight = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / SPEED_OF_LIGHT_MPS + emission
        if noise.clock_error_s is not None:
            flight = flight + noise.clock_error_s[:, s, None]
        toa[:, s] = flight + sigma[s] * toa[:, s]
    if noise.outlier_share > 0.0:
        late = draw.uniform(OUTLIER, marks, stations) < noise.outlier_share
        least, most = noise.outlier_late_s
        delay = least + (most - least) * draw.uniform(OUTLIER_SIZE, marks, stations)
        np.add(toa, delay, out=toa, where=late)
    if (noise.reception_probability < 1.0).any():
        missed = draw.uniform(RECEPTION, marks, stations) >= noise.reception_probability[:, :, None]
        np.copyto(toa, np.nan, where=missed)
    return toa


def _altitudes(trajectory: Trajectory, noise: MarkNoise, emission: Floats, draw: _Draws) -> Floats:
    """(M, block) m, or (M, 1) where all trials read the same."""
    marks = len(trajectory.altitude_m)
    altitude = trajectory.altitude_m[:, None] + emission * trajectory.climb_rate_mps[:, None]
    if noise.altitude_bias_sd_m > 0.0:
        altitude = altitude + noise.altitude_bias_sd_m * draw.normal(BIAS, 1)
    if noise.sigma_altitude_m > 0.0:
        altitude = altitude + noise.sigma_altitude_m * draw.normal(ALTITUDE, marks)
    if noise.altitude_step_m > 0.0:
        altitude = np.round(altitude / noise.altitude_step_m) * noise.altitude_step_m
    if noise.decoding_probability < 1.0:
        decoded = draw.uniform(DECODING, marks) < noise.decoding_probability
        altitude = np.where(decoded, altitude, np.nan)
    return altitude
