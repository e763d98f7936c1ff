"""Random manoeuvres of an aeroballistic object: trajectories that nobody selected (specification 10).

It dives from 40 km at 1.8 km/s; from 30 s on two to four commands in a row, of random length, size and direction, with
ramps of half a second. A trajectory that comes below 500 m or leaves the antenna's half-space is drawn again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from algorithms.errors import ParameterError
from algorithms.multiple_model.flight import Command, Flight, fly
from algorithms.toolbox.frames.bicone import antenna_axes, bicone_from_position

FIRST_S, RAMP_S, AFTER_S = 30.0, 0.5, 25.0
UP_M, VELOCITY_NORTH_MPS, VELOCITY_UP_MPS = 40_000.0, -1_800.0, -200.0
ANTENNA_ELEVATION_DEG = 30.0
LOWEST_M = 500.0
STREAM = 10


@dataclass(frozen=True)
class RandomFlight:
    """A trajectory: its start in m, its commands, and when the last of them has ended."""

    east_m: float
    north_m: float
    commands: tuple[Command, ...]
    end_s: float


@lru_cache(maxsize=64)
def random_flight(number: int) -> RandomFlight:
    """Return trajectory `number`, the same at every call."""
    rng = np.random.default_rng((STREAM, number))
    while True:
        flight = _draw(rng)
        if _seen(flight):
            return flight


def _draw(rng: np.random.Generator) -> RandomFlight:
    x, u = rng.uniform(90_000, 150_000), rng.uniform(-0.2, 0.2)
    size, t = rng.uniform(30, 140), FIRST_S
    points = [(t, 0.0, 0.0)]
    for _ in range(int(rng.integers(2, 5))):
        length, magnitude = rng.uniform(3, 12), size * rng.uniform(0.6, 1)
        direction = rng.uniform(0, 2 * np.pi)
        force = magnitude * np.cos(direction), magnitude * np.sin(direction)
        points += [(t + RAMP_S, *force), (t + max(length, 2 * RAMP_S), *force)]
        t += max(length, 2 * RAMP_S)
    points.append((t + RAMP_S, 0.0, 0.0))
    commands = tuple(Command(time_s=at, vertical_mps2=v, right_mps2=h) for at, v, h in points)
    return RandomFlight(float(u * x), float(x + 54_000), commands, float(t + RAMP_S))


def _seen(flight: RandomFlight) -> bool:
    start, velocity = (flight.east_m, flight.north_m, UP_M), (0.0, VELOCITY_NORTH_MPS, VELOCITY_UP_MPS)
    times = np.arange(0.0, flight.end_s + AFTER_S, 0.25)
    try:
        flown = fly(Flight(start, velocity, flight.commands, free=True), times)
    except ParameterError:
        # It hit the ground.
        return False
    axes = antenna_axes(0.0, np.radians(ANTENNA_ELEVATION_DEG))
    seen = np.stack(bicone_from_position(flown.position_m, axes, np.zeros(3)))
    return bool(flown.position_m[:, 2].min() > LOWEST_M and np.isfinite(seen).all())
