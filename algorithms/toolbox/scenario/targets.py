"""Where targets truly go: a start and segments, or a table of points joined by a cubic spline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from algorithms.errors import FrameError, ParameterError
from algorithms.spec import Parameters, parameter
from algorithms.toolbox.frames.earth import altitude_from_position
from algorithms.toolbox.scenario.trajectory import MAX_SPEED_MPS, Segment, Trajectory, above_the_earth, fly

Floats = NDArray[np.float64]

_FARTHEST_M = 1e7
# Between two points of a table the spline is looked at so many times for a speed or an altitude that cannot be.
_LOOKS = 8


class PathPoint(Parameters):
    """Where a target is at an instant; the altitude is given above the Earth, or as height in the local frame."""

    time_s: float = parameter(title="Time", unit="s", group="targets", ge=0, le=1e6)
    """Counted from the target's start."""
    east_m: float = parameter(title="East", unit="m", group="targets", ge=-_FARTHEST_M, le=_FARTHEST_M)
    """East of the local frame's zero."""
    north_m: float = parameter(title="North", unit="m", group="targets", ge=-_FARTHEST_M, le=_FARTHEST_M)
    """North of the local frame's zero."""
    altitude_m: float | None = parameter(None, title="Altitude", unit="m", group="targets", ge=0, le=1e6)
    """Above the Earth; this or the height."""
    up_m: float | None = parameter(None, title="Height", unit="m", group="targets", ge=-1e6, le=1e6)
    """In the local frame, whose plane rises above the Earth with distance; this or the altitude."""

    @model_validator(mode="after")
    def _one_height(self) -> Self:
        if (self.altitude_m is None) == (self.up_m is None):
            raise ValueError("give altitude_m or up_m, one of the two")
        return self


class Target(Parameters):
    """An emitter: when it appears, where it starts, and what it does then."""

    name: str = parameter("", title="Name", group="targets", max_length=80)
    """Without one, its place in the list."""
    start_s: float = parameter(0.0, title="Appears at", unit="s", group="targets", ge=0, le=1e6)
    """Its segments or points begin then."""
    east_m: float = parameter(30_000.0, title="Start, east", unit="m", group="targets", ge=-_FARTHEST_M, le=_FARTHEST_M)
    """East of the local frame's zero."""
    north_m: float = parameter(
        10_000.0, title="Start, north", unit="m", group="targets", ge=-_FARTHEST_M, le=_FARTHEST_M
    )
    """North of the local frame's zero."""
    altitude_m: float = parameter(5_000.0, title="Altitude", unit="m", group="targets", ge=0, le=1e6)
    """Above the Earth, at the start."""
    heading_deg: float = parameter(270.0, title="Heading", unit="°", group="targets", ge=-360, le=360)
    """Clockwise from north, at the start."""
    speed_mps: float = parameter(150.0, title="Speed", unit="m/s", group="targets", ge=0, le=MAX_SPEED_MPS)
    """Horizontal, at the start."""
    segments: tuple[Segment, ...] = parameter((), title="Segments", group="targets", max_length=500)
    """Flown one after another; without them the points are."""
    points: tuple[PathPoint, ...] = parameter((), title="Points", group="targets", max_length=2000)
    """A table of positions in place of start and segments, joined by a natural cubic spline in time."""

    @model_validator(mode="after")
    def _one_path(self) -> Self:
        if bool(self.segments) == bool(self.points):
            raise ValueError("give segments or at least two points, one of the two")
        return self


class Path(Protocol):
    """The true path of one target between two instants of the recording's clock."""

    @property
    def begin_s(self) -> float:
        """First instant."""

    @property
    def end_s(self) -> float:
        """Last instant."""

    def at(self, times_s: Floats, earth: Floats) -> Trajectory:
        """Return the true states at instants (M,) s on the recording's clock."""


@dataclass(frozen=True)
class SegmentPath:
    """A start and segments."""

    target: Target
    begin_s: float
    end_s: float

    def at(self, times_s: Floats, earth: Floats) -> Trajectory:
        """Return the true states."""
        t = self.target
        return fly(
            # Rounding may take the last instant of a target that appears late past its end.
            np.minimum(times_s - self.begin_s, sum(s.duration_s for s in t.segments)), t.segments, east_m=t.east_m,
            north_m=t.north_m, altitude_m=t.altitude_m, heading_deg=t.heading_deg, speed_mps=t.speed_mps, earth=earth,
        )  # fmt: skip


@dataclass(frozen=True)
class PointPath:
    """A table of points, joined by a natural cubic spline of east, north and altitude over time.

    The spline goes through all points with continuous velocity and acceleration; the acceleration is zero at both
    ends. A height in the local frame is turned into an altitude at the points.
    """

    target: Target
    begin_s: float
    end_s: float

    def at(self, times_s: Floats, earth: Floats) -> Trajectory:
        """Return the true states; raise ParameterError where the spline leaves what can be flown."""
        from scipy.interpolate import CubicSpline

        points = self.target.points
        t = np.array([p.time_s for p in points])
        if (np.diff(t) <= 0).any():
            i = int(np.flatnonzero(np.diff(t) <= 0)[0]) + 1
            raise ParameterError(
                f"Point {i + 1} is not later than the one before it.",
                pointer=f"/points/{i}/time_s",
                remedy="Put the points into the order of time, each instant once.",
            )
        plan = np.array([(p.east_m, p.north_m) for p in points])
        local = np.column_stack([plan, [0.0 if p.up_m is None else p.up_m for p in points]])
        above = altitude_from_position(local, earth)
        altitude = np.array([a if p.altitude_m is None else p.altitude_m for p, a in zip(points, above, strict=True)])
        spline = CubicSpline(t, np.column_stack([plan, altitude]), bc_type="natural")
        _refuse_what_cannot_be_flown(spline, t)
        tau = times_s - self.target.start_s
        x, y, h = spline(tau).T
        vx, vy, climb = spline(tau, 1).T
        return above_the_earth(x, y, h, vx, vy, climb, earth)


def _refuse_what_cannot_be_flown(spline: object, knots: Floats) -> None:
    looks = np.append((knots[:-1, None] + np.diff(knots)[:, None] * np.arange(_LOOKS) / _LOOKS).ravel(), knots[-1])
    altitude = spline(looks)[:, 2]  # type: ignore[operator]  # scipy has no types
    speed = np.linalg.norm(spline(looks, 1), axis=1)  # type: ignore[operator]  # the same
    wrong = (altitude < 0) | (speed > MAX_SPEED_MPS)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise ParameterError(
            f"At {looks[i]:g} s the path through the points is {altitude[i]:.4g} m high and {speed[i]:.4g} m/s fast; "
            f"it must stay above the ground and below {MAX_SPEED_MPS:g} m/s.",
            pointer=f"/points/{min(i // _LOOKS, len(knots) - 1)}",
            remedy="Move the points near it, or give more of them.",
        )


def path_of(target: Target) -> Path:
    """Return the path of a target, which is checked when it is asked for positions."""
    if target.segments:
        return SegmentPath(target, target.start_s, target.start_s + sum(s.duration_s for s in target.segments))
    if len(target.points) < 2:
        raise ParameterError("One point is no path.", pointer="/points", remedy="Give at least two points.")
    return PointPath(target, target.start_s + target.points[0].time_s, target.start_s + target.points[-1].time_s)


def states_of(path: Path, times_s: Floats, earth: Floats, pointer: str) -> Trajectory:
    """Return the true states at these instants and complain, with the target's pointer, about what cannot be."""
    try:
        return path.at(times_s, earth)
    except ParameterError as error:
        raise ParameterError(error.message, pointer=pointer + error.pointer, remedy=error.remedy) from error
    except FrameError as error:
        raise ParameterError(
            "The path goes farther out than the Earth is wide.",
            pointer=pointer,
            remedy="Check the coordinates, which are in metres, and the altitude.",
        ) from error
