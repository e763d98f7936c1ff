"""True trajectories from segments: straight lines and exact arcs in the plan, altitude above the Earth.

Heading psi is clockwise from north, w the turn rate (positive to the right), v the horizontal speed. Over tau seconds

    w = 0:  x += v tau sin psi,                       y += v tau cos psi
    else:   x += v / w (cos psi - cos(psi + w tau)),   y += v / w (sin(psi + w tau) - sin psi)

and, with an acceleration along the path, v grows linearly: the arc integrals then carry one more term each. The
altitude changes with the climb rate; the ENU height follows from x, y and the altitude on the given Earth, and

    vz = ((R + h) h' - x vx - y vy) / sqrt((R + h)^2 - x^2 - y^2)      (sphere; on the ellipsoid from grad h).

References
----------
specification of the multilateration paper, 7.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.spec import Parameters, parameter
from algorithms.toolbox.frames.earth import up_from_position, z_from_altitude

Floats = NDArray[np.float64]

MAX_SPEED_MPS = 10_000.0


class Segment(Parameters):
    """One piece of a trajectory with constant turn rate, climb rate and acceleration along the path."""

    duration_s: float = parameter(title="Duration", unit="s", group="motion", gt=0, le=1e6)
    """How long the segment lasts."""
    turn_rate_deg_s: float = parameter(0.0, title="Turn rate", unit="°/s", group="motion", ge=-90, le=90)
    """Positive to the right."""
    climb_rate_mps: float = parameter(0.0, title="Climb rate", unit="m/s", group="motion", ge=-2000, le=2000)
    """Change of the altitude."""
    acceleration_mps2: float = parameter(0.0, title="Acceleration", unit="m/s²", group="motion", ge=-500, le=500)
    """Change of the horizontal speed."""


@dataclass(frozen=True)
class Trajectory:
    """Positions (M, 3) m, velocities (M, 3) m/s, altitudes (M,) m and climb rates (M,) m/s at the asked instants."""

    position_m: Floats
    velocity_mps: Floats
    altitude_m: Floats
    climb_rate_mps: Floats


def fly(
    times_s: Floats,
    segments: Sequence[Segment],
    *,
    east_m: float,
    north_m: float,
    altitude_m: float,
    heading_deg: float,
    speed_mps: float,
    earth: Floats,
) -> Trajectory:
    """Follow the segments from the start and answer at `times_s` (s from the start, any order).

    Raises
    ------
    ParameterError
        An instant outside the segments, a speed below zero or beyond 10 km/s, a point below the ground.
    """
    times = np.asarray(times_s, float)
    total = sum(s.duration_s for s in segments)
    if times.size and not (times.min() >= 0 and times.max() <= total + 1e-9):
        raise ParameterError(
            f"Instants from {times.min():g} to {times.max():g} s do not lie in the trajectory's 0 to {total:g} s.",
            pointer="/segments",
            remedy="Lengthen the segments or shorten the observation.",
        )
    x = np.empty(times.size)
    y = np.empty(times.size)
    h = np.empty(times.size)
    vx = np.empty(times.size)
    vy = np.empty(times.size)
    climb = np.empty(times.size)
    px, py, ph, psi, v = east_m, north_m, altitude_m, np.radians(heading_deg), speed_mps
    begin = 0.0
    for index, s in enumerate(segments):
        last = index == len(segments) - 1
        inside = (times >= begin) & ((times <= begin + s.duration_s + 1e-9) if last else (times < begin + s.duration_s))
        tau = np.append(times[inside] - begin, s.duration_s)
        w = np.radians(s.turn_rate_deg_s)
        dx, dy = _advance(psi, w, v, s.acceleration_mps2, tau)
        speed = v + s.acceleration_mps2 * tau
        if not ((speed >= 0).all() and (speed <= MAX_SPEED_MPS).all()):
            raise ParameterError(
                f"Segment {index + 1} ends with a speed of {speed[-1]:g} m/s.",
                pointer=f"/segments/{index}/acceleration_mps2",
                remedy=f"Keep the speed between 0 and {MAX_SPEED_MPS:g} m/s.",
            )
        x[inside], y[inside] = px + dx[:-1], py + dy[:-1]
        h[inside] = ph + s.climb_rate_mps * tau[:-1]
        vx[inside] = speed[:-1] * np.sin(psi + w * tau[:-1])
        vy[inside] = speed[:-1] * np.cos(psi + w * tau[:-1])
        climb[inside] = s.climb_rate_mps
        px, py, ph = px + dx[-1], py + dy[-1], ph + s.climb_rate_mps * s.duration_s
        psi, v, begin = psi + w * s.duration_s, float(speed[-1]), begin + s.duration_s
        if ph < 0:
            raise ParameterError(
                f"Segment {index + 1} ends at an altitude of {ph:g} m, below the ground.",
                pointer=f"/segments/{index}/climb_rate_mps",
                remedy="Climb less steeply down, or start higher.",
            )
    return above_the_earth(x, y, h, vx, vy, climb, earth)


def above_the_earth(
    x: Floats, y: Floats, altitude_m: Floats, vx: Floats, vy: Floats, climb_rate_mps: Floats, earth: Floats
) -> Trajectory:
    """Complete plan and altitude, each (M,) with its rate, to positions and velocities in the local frame."""
    position = np.stack([x, y, z_from_altitude(x, y, altitude_m, earth)], axis=1)
    up = up_from_position(position, earth)
    vz = (climb_rate_mps - up[:, 0] * vx - up[:, 1] * vy) / up[:, 2]
    return Trajectory(position, np.stack([vx, vy, vz], axis=1), altitude_m, climb_rate_mps)


def _advance(psi: float, w: float, v: float, a: float, tau: Floats) -> tuple[Floats, Floats]:
    """Displacement over tau seconds of a turn with rate w at speed v + a tau."""
    end = psi + w * tau
    if w == 0.0:
        distance = v * tau + 0.5 * a * tau * tau
        return distance * np.sin(psi), distance * np.cos(psi)
    # Integrals of (v + a t) sin(psi + w t) and (v + a t) cos(psi + w t), by parts.
    speed = v + a * tau
    dx = (v * np.cos(psi) - speed * np.cos(end)) / w + a * (np.sin(end) - np.sin(psi)) / w**2
    dy = (speed * np.sin(end) - v * np.sin(psi)) / w + a * (np.cos(end) - np.cos(psi)) / w**2
    return dx, dy
