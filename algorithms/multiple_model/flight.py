"""True trajectories of one object under commanded accelerations, in free flight or powered, above a flat Earth.

    dp/dt = v,   dv/dt = a_v n_v + a_h n_h + a_t u  [ - g up - rho(h) V^2 / (2 beta) u  in free flight ],

u = v/V, n_v = unit(up - (up . u) u), n_h = u x n_v turned to the right, rho = 1.225 exp(-h / 7200). Commands are linear
between their instants and zero outside them. Fourth-order Runge-Kutta steps of 0.05 s (error 4e-6 m over 180 s); an
instant between two steps is reached by a shorter one.

References
----------
specification of the multiple-model paper, section 9.

Differences from the paper
--------------------------
The paper gives no trajectory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.spec import Parameters, parameter
from algorithms.toolbox.motion.models import GRAVITY_MPS2, SCALE_HEIGHT_M, SEA_LEVEL_DENSITY

Floats = NDArray[np.float64]

STEP_S = 0.05
MAX_SPEED_MPS = 20_000.0
_FARTHEST_M = 1e7


class Command(Parameters):
    """Accelerations that are commanded at an instant; linear from one to the next, zero before and after all."""

    time_s: float = parameter(title="Time", unit="s", group="targets", ge=0, le=1e5)
    """On the recording's clock."""
    vertical_mps2: float = parameter(0.0, title="Up", unit="m/s²", group="targets", ge=-1000, le=1000)
    """Across the velocity, in the vertical plane."""
    right_mps2: float = parameter(0.0, title="Right", unit="m/s²", group="targets", ge=-1000, le=1000)
    """Across the velocity, horizontal."""
    along_mps2: float = parameter(0.0, title="Along", unit="m/s²", group="targets", ge=-1000, le=1000)
    """Along the velocity."""


@dataclass(frozen=True)
class Flight:
    """What determines a trajectory: m and m/s in east, north, up; `beta` in kg/m2."""

    position_m: tuple[float, float, float]
    velocity_mps: tuple[float, float, float]
    commands: tuple[Command, ...] = ()
    free: bool = False
    beta: float = 12_000.0


@dataclass(frozen=True)
class Flown:
    """Positions, velocities and accelerations (M, 3)."""

    position_m: Floats
    velocity_mps: Floats
    acceleration_mps2: Floats


def check_commands(commands: Sequence[Command], pointer: str = "/commands") -> None:
    """Refuse commands that are not in the order of time."""
    for i in range(1, len(commands)):
        if commands[i].time_s <= commands[i - 1].time_s:
            raise ParameterError(
                f"Command {i + 1} is not later than the one before it.",
                pointer=f"{pointer}/{i}/time_s",
                remedy="Put the commands into the order of time, each instant once.",
            )


def fly(flight: Flight, times_s: Floats) -> Flown:
    """Answer at instants (M,) s >= 0, rising.

    Raises
    ------
    ParameterError
        Commands out of order, no speed to turn, below the ground in free flight, or faster than 20 km/s.
    """
    check_commands(flight.commands)
    steps = int(np.ceil((times_s[-1] if times_s.size else 0.0) / STEP_S - 1e-9))
    grid = np.empty((max(steps, 0) + 1, 6))
    grid[0] = (*flight.position_m, *flight.velocity_mps)
    knots, values = _commands(flight)
    straight = not flight.free and not flight.commands
    if straight:
        grid[:, :3] = grid[0, :3] + STEP_S * np.arange(len(grid))[:, None] * grid[0, 3:]
        grid[:, 3:] = grid[0, 3:]
    else:
        for k in range(steps):
            grid[k + 1] = _step(flight, knots, values, k * STEP_S, grid[k], np.float64(STEP_S))
            _refuse(flight, grid[k + 1], (k + 1) * STEP_S)
    at = np.minimum((times_s / STEP_S + 1e-9).astype(np.int64), len(grid) - 1)
    rest = times_s - at * STEP_S
    rest[np.abs(rest) < 1e-9] = 0.0
    state = grid[at].T
    moved = _step(flight, knots, values, at * STEP_S, state, rest).T
    return Flown(moved[:, :3], moved[:, 3:], _slope(flight, knots, values, times_s, moved.T)[3:].T)


def _commands(flight: Flight) -> tuple[Floats, Floats]:
    knots = np.array([c.time_s for c in flight.commands])
    values = np.array([(c.vertical_mps2, c.right_mps2, c.along_mps2) for c in flight.commands], float).reshape(-1, 3)
    return knots, values


def _slope(flight: Flight, knots: Floats, values: Floats, time: Floats | float, s: Floats) -> Floats:
    """Derivative of a state (6,) or (6, M)."""
    v = s[3:]
    speed = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    out = np.empty_like(s)
    out[:3] = v
    u = v / np.where(speed > 0, speed, 1.0)
    plan = np.sqrt(u[0] * u[0] + u[1] * u[1])
    level = plan > 1e-9
    safe = np.where(level, plan, 1.0)
    # Straight up or down has no right and no up across it: nothing turns it.
    nv = np.stack([-u[2] * u[0] / safe, -u[2] * u[1] / safe, plan]) * level
    nh = np.stack([u[1] / safe, -u[0] / safe, np.zeros_like(plan)]) * level
    acceleration = np.zeros_like(v)
    if knots.size:
        a = [np.interp(time, knots, values[:, i], left=0.0, right=0.0) for i in range(3)]
        acceleration = a[0] * nv + a[1] * nh + a[2] * u
    if flight.free:
        density = SEA_LEVEL_DENSITY * np.exp(-np.maximum(s[2], -1e4) / SCALE_HEIGHT_M)
        acceleration = acceleration - density * speed * speed / (2 * flight.beta) * u
        acceleration[2] -= GRAVITY_MPS2
    out[3:] = acceleration
    return out


def _step(
    flight: Flight, knots: Floats, values: Floats, time: Floats | float, s: Floats, h: Floats | np.float64
) -> Floats:
    k1 = _slope(flight, knots, values, time, s)
    k2 = _slope(flight, knots, values, time + h / 2, s + h / 2 * k1)
    k3 = _slope(flight, knots, values, time + h / 2, s + h / 2 * k2)
    k4 = _slope(flight, knots, values, time + h, s + h * k3)
    moved: Floats = s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return moved


def _refuse(flight: Flight, state: Floats, time: float) -> None:
    if not (np.isfinite(state).all() and np.linalg.norm(state[3:]) < MAX_SPEED_MPS):
        raise ParameterError(
            f"At {time:g} s the object is faster than {MAX_SPEED_MPS:g} m/s.",
            pointer="/commands",
            remedy="Command less, or start slower.",
        )
    if np.linalg.norm(state[3:]) < 1e-3 and flight.commands:
        raise ParameterError(
            f"At {time:g} s the object stands still, and has no direction to turn from.",
            pointer="/commands",
            remedy="Brake less.",
        )
    if flight.free and state[2] < -1000.0:
        raise ParameterError(
            f"At {time:g} s the object is {-state[2]:.0f} m below the ground.",
            pointer="/duration_s",
            remedy="Make the observation shorter, or start higher.",
        )
