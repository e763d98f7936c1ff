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

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

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
    steps = max(int(np.ceil((times_s[-1] if times_s.size else 0.0) / STEP_S - 1e-9)), 0)
    grid = _straight(flight, steps) if not flight.free and not flight.commands else _curved(flight, steps)
    at = np.minimum((times_s / STEP_S + 1e-9).astype(np.int64), len(grid) - 1)
    rest = times_s - at * STEP_S
    rest[np.abs(rest) < 1e-9] = 0.0
    begin = at * STEP_S
    first, middle, last = (_commanded(flight, instants) for instants in (begin, begin + rest / 2, begin + rest))
    x, y, z, vx, vy, vz = grid[at].T
    moved = _step(flight, (first, middle, last), (x, y, z, vx, vy, vz), rest)
    acceleration = _slope(flight, _commanded(flight, times_s), moved)[3:]
    return Flown(np.stack(moved[:3], -1), np.stack(moved[3:], -1), np.stack(acceleration, -1))


# Triples of components: arrays over instants, or plain numbers, which a loop takes a tenth of the time for.
Triple = tuple[Any, Any, Any]
State = tuple[Any, Any, Any, Any, Any, Any]


def _straight(flight: Flight, steps: int) -> Floats:
    """States (steps + 1, 6) where nothing acts."""
    grid = np.tile((*flight.position_m, *flight.velocity_mps), (steps + 1, 1))
    grid[:, :3] += STEP_S * np.arange(steps + 1)[:, None] * grid[:, 3:]
    return grid


def _curved(flight: Flight, steps: int) -> Floats:
    """States (steps + 1, 6), one step after the other."""
    up, right, along = (a.tolist() for a in _commanded(flight, STEP_S / 2 * np.arange(2 * steps + 1, dtype=np.float64)))
    forces: list[Triple] = list(zip(up, right, along, strict=True))
    state: State = (*flight.position_m, *flight.velocity_mps)
    _refuse(flight, state, 0.0)
    grid = [state]
    for k in range(steps):
        state = _step(flight, (forces[2 * k], forces[2 * k + 1], forces[2 * k + 2]), state, STEP_S)
        _refuse(flight, state, (k + 1) * STEP_S)
        grid.append(state)
    return np.array(grid)


def _commanded(flight: Flight, times_s: Floats) -> Triple:
    """Accelerations up, right and along that are commanded at instants (M,)."""
    if not flight.commands:
        none = np.zeros(times_s.shape)
        return none, none, none
    knots = [c.time_s for c in flight.commands]
    values = np.array([(c.vertical_mps2, c.right_mps2, c.along_mps2) for c in flight.commands], float)
    up, right, along = (np.interp(times_s, knots, values[:, i], left=0.0, right=0.0) for i in range(3))
    return up, right, along


def _slope(flight: Flight, force: Triple, s: State) -> State:
    """Derivative of a state."""
    _, _, height, vx, vy, vz = s
    speed = (vx * vx + vy * vy + vz * vz) ** 0.5
    moving = speed + (speed == 0)
    ux, uy, uz = vx / moving, vy / moving, vz / moving
    plan = (ux * ux + uy * uy) ** 0.5
    # Straight up or down has no right and no up across it: nothing turns it.
    level = plan > 1e-9
    safe = plan + (plan <= 1e-9)
    up, right, along = force[0] * level, force[1] * level, force[2]
    ax = (right * uy - up * uz * ux) / safe + along * ux
    ay = (-right * ux - up * uz * uy) / safe + along * uy
    az = up * plan + along * uz
    if flight.free:
        drag = SEA_LEVEL_DENSITY * math.e ** (-height / SCALE_HEIGHT_M) * speed * speed / (2 * flight.beta)
        ax, ay, az = ax - drag * ux, ay - drag * uy, az - drag * uz - GRAVITY_MPS2
    return vx, vy, vz, ax, ay, az


def _step(flight: Flight, forces: tuple[Triple, Triple, Triple], s: State, h: Any) -> State:
    """State after `h` s; commanded is something else at the begin of the step, in its middle and at its end."""
    begin, middle, end = forces
    k1 = _slope(flight, begin, s)
    k2 = _slope(flight, middle, _moved(s, h / 2, k1))
    k3 = _slope(flight, middle, _moved(s, h / 2, k2))
    k4 = _slope(flight, end, _moved(s, h, k3))
    mean = tuple((a + 2 * (b + c) + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
    return _moved(s, h, mean)


def _moved(s: State, h: Any, slope: Sequence[Any]) -> State:
    x, y, z, vx, vy, vz = (a + h * b for a, b in zip(s, slope, strict=True))
    return x, y, z, vx, vy, vz


def _refuse(flight: Flight, state: State, time: float) -> None:
    speed = math.hypot(*state[3:])
    if not speed < MAX_SPEED_MPS:
        raise ParameterError(
            f"At {time:g} s the object is faster than {MAX_SPEED_MPS:g} m/s.",
            pointer="/commands",
            remedy="Command less, or start slower.",
        )
    if speed < 1e-3 and flight.commands:
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
