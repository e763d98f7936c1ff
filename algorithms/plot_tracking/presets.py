"""The aircraft of the presets: starts and segments (specification 7).

Turns at constant speed have a constant curvature too, so that a segment's turn rate says the same; changes of speed
come on straight lines only.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from algorithms.errors import ParameterError
from algorithms.plot_tracking.scenario_parameters import (
    AircraftScans,
    CrossingScans,
    ManyScans,
    ParallelScans,
    RadarScans,
)
from algorithms.toolbox.scenario.mark_parameters import NamedInterval
from algorithms.toolbox.scenario.preset import preset
from algorithms.toolbox.scenario.targets import Target
from algorithms.toolbox.scenario.trajectory import Segment

STANDARD_GRAVITY_MPS2 = 9.80665
# Bank of 25 degrees at 200 m/s; 90 degrees take 68.70 s.
WIDE_RATE_DEG_S = float(np.degrees(STANDARD_GRAVITY_MPS2 * np.tan(np.radians(25)) / 200.0))
WIDE_TURN_S = 90.0 / WIDE_RATE_DEG_S
# Bank of 20 degrees at 250 m/s.
FAR_RATE_DEG_S = float(np.degrees(STANDARD_GRAVITY_MPS2 * np.tan(np.radians(20)) / 250.0))
FAR_TURN_S = 60.0 / FAR_RATE_DEG_S
# A leg begins between two scans, so that none is counted twice.
BETWEEN_S = 0.05


def _flight(
    east_km: float, north_km: float, course: float, speed: float, *changes: tuple[float, float, float], end: float,
    name: str = "",
) -> Target:  # fmt: skip
    """A target from a start and changes (instant, acceleration, turn rate)."""
    segments = []
    parts = [(0.0, 0.0, 0.0), *changes, (end, 0.0, 0.0)]
    for (begin, a, rate), (stop, _, _) in pairwise(parts):
        if stop > begin:
            segments.append(Segment(duration_s=stop - begin, turn_rate_deg_s=rate, acceleration_mps2=a))
    return Target(
        name=name,
        east_m=1000.0 * east_km,
        north_m=1000.0 * north_km,
        altitude_m=0.0,
        heading_deg=course,
        speed_mps=speed,
        segments=tuple(segments),
    )


def _legs(on: float, off: float, end: float, after: float = 40.0) -> tuple[NamedInterval, ...]:
    """Before, in and behind a manoeuvre, as table 9.1 cuts them."""
    cuts = (("pre", 50.0, on + BETWEEN_S), ("man", on + BETWEEN_S, off + BETWEEN_S))
    behind = (("rec", off + BETWEEN_S, off + after + BETWEEN_S), ("end", end - 50.0 + BETWEEN_S, end + 1.0))
    return tuple(NamedInterval(name=name, start_s=start, stop_s=stop) for name, start, stop in (*cuts, *behind))


def _one(name: str, target: Target, legs: tuple[NamedInterval, ...], **more: object) -> type[AircraftScans]:
    return preset(AircraftScans, name, targets=(target,), legs=legs, **more)


STRAIGHT = _one(
    "StraightScans",
    _flight(-30, 40, 90, 200, end=300),
    (
        NamedInterval(name="pre", start_s=50.0, stop_s=100.0 + BETWEEN_S),
        NamedInterval(name="end", start_s=200.0 + BETWEEN_S, stop_s=301.0),
    ),
)
WIDE_TURN = _one(
    "WideTurnScans",
    _flight(-30, 40, 90, 200, (100, 0, WIDE_RATE_DEG_S), (100 + WIDE_TURN_S, 0, 0), end=300),
    _legs(100, 100 + WIDE_TURN_S, 300),
)
TIGHT_TURN = _one("TightTurnScans", _flight(-6, 45, 90, 120, (100, 0, 3.0), (160, 0, 0), end=300), _legs(100, 160, 300))
SPEED_CHANGE = _one(
    "SpeedChangeScans", _flight(-30, 40, 90, 100, (100, 2.0, 0), (160, 0, 0), end=300), _legs(100, 160, 300)
)
EN_ROUTE = _one(
    "EnRouteScans",
    _flight(-70, 150, 90, 250, (200, 0, FAR_RATE_DEG_S), (200 + FAR_TURN_S, 0, 0), end=600),
    _legs(200, 200 + FAR_TURN_S, 600, after=80.0),
    period_s=10.0,
    duration_s=600.0,
    sigma_range_m=250.0,
    sigma_azimuth_deg=0.2,
    clutter_radius_m=300_000.0,
)
BASE_10 = preset(
    AircraftScans,
    "TenAircraftScans",
    targets=(
        _flight(-60, 40, 90, 220, end=300),
        _flight(60, 50, 270, 200, end=300),
        _flight(-30, -60, 0, 180, (100, 0, 1.5), (160, 0, 0), end=300),
        _flight(55, -25, 315, 230, end=300),
        _flight(0, 80, 180, 210, end=300),
        _flight(-80, -20, 60, 240, (150, 0, -1.2), (200, 0, 0), end=300),
        _flight(20, 30, 45, 120, (60, 0, 3), (120, 0, 0), (180, 0, 3), (240, 0, 0), end=300),
        _flight(70, -10, 200, 150, (120, 1.0, 0), (180, 0, 0), end=300),
        _flight(-40, 70, 135, 250, end=300),
        _flight(30, -75, 350, 190, (90, 0, -2), (135, 0, 0), end=300),
    ),
)
OVERTAKING = preset(
    AircraftScans,
    "OvertakingScans",
    targets=(_flight(-20, 50, 90, 160, end=300), _flight(-29, 50.3, 90, 220, end=300)),
)
FORMATION = preset(
    AircraftScans,
    "FormationScans",
    targets=tuple(
        _flight(-30 + e, 45 + n, 90, 200, (100, 0, WIDE_RATE_DEG_S), (100 + WIDE_TURN_S, 0, 0), end=300)
        for e, n in ((0, 0), (-1.5, 1.5), (-1.5, -1.5), (-3, 0))
    ),
)


STEADY_S = 60.0


def _steady(name: str, turned_deg: float, speed: float, rate_deg_s: float = 0.0) -> Target:
    """A target that has one motion all the time and is 58 km from the radar after a minute."""
    rate = np.radians(rate_deg_s)
    before, half = np.pi / 2 - rate * STEADY_S, 0.5 * rate * STEADY_S
    chord = speed * STEADY_S * np.sinc(half / np.pi)
    start = np.array([42_000.0, 40_000.0]) - chord * np.array([np.sin(before + half), np.cos(before + half)])
    turn = np.radians(turned_deg)
    east, north = start[0] * np.cos(turn) + start[1] * np.sin(turn), start[1] * np.cos(turn) - start[0] * np.sin(turn)
    course = float(np.mod(np.degrees(before + turn), 360.0))
    end = STEADY_S + 5.0
    return _flight(east / 1000, north / 1000, course, speed, (0.0, 0.0, rate_deg_s), end=end, name=name)


STEADY = preset(
    AircraftScans,
    "SteadyScans",
    duration_s=STEADY_S + 5.0,
    targets=(
        _steady("straight_200", 0.0, 200.0),
        _steady("wide_turn", 72.0, 200.0, WIDE_RATE_DEG_S),
        _steady("tight_turn", 144.0, 120.0, 3.0),
        _steady("straight_50", 216.0, 50.0),
        _steady("straight_20", 288.0, 20.0),
    ),
)


MANY = preset(ManyScans, "HundredScans", duration_s=75.0, false_plots=100.0, clutter_radius_m=200_000.0)
CLUTTER_ONLY = preset(RadarScans, "ClutterScans", false_plots=50.0)
# What flies farther from the radar than this leaves the plane.
FARTHEST_WAY_M = 4e6


def _way(p: CrossingScans | ParallelScans) -> float:
    """Length of a path in m; ParameterError where it leaves the plane."""
    way = p.speed_mps * p.duration_s
    if way > FARTHEST_WAY_M:
        raise ParameterError(
            f"At {p.speed_mps:g} m/s the aircraft fly {way / 1000:,.0f} km in {p.duration_s:g} s.",
            pointer="/duration_s",
            remedy=f"Make the recording shorter: at most {FARTHEST_WAY_M / 1000:,.0f} km are flown.",
        )
    return way


# Irrational steps spread places, courses and speeds evenly, for any number of aircraft.
GOLDEN_ANGLE_DEG = 180.0 * (3.0 - 5.0**0.5)
_COURSE_STEP, _SPEED_STEP = 2.0**0.5, 3.0**0.5
SLOWEST_MPS, FASTEST_MPS = 120.0, 260.0


def many_targets(p: ManyScans) -> tuple[Target, ...]:
    """Flights that begin evenly spread over the disc; every third turns by 1.5 degrees a second for half the time."""
    out = []
    for i in range(p.aircraft):
        bearing = np.radians(i * GOLDEN_ANGLE_DEG)
        r_km = p.disc_radius_m / 1000 * np.sqrt((i + 0.5) / p.aircraft)
        course = 360.0 * (i * _COURSE_STEP % 1.0)
        speed = SLOWEST_MPS + (FASTEST_MPS - SLOWEST_MPS) * (i * _SPEED_STEP % 1.0)
        side = 1.5 if i % 2 else -1.5
        turn = ((0.25 * p.duration_s, 0.0, side), (0.75 * p.duration_s, 0.0, 0.0)) if i % 3 == 2 else ()
        out.append(_flight(r_km * np.sin(bearing), r_km * np.cos(bearing), course, speed, *turn, end=p.duration_s))
    return tuple(out)


def crossing_targets(p: CrossingScans) -> tuple[Target, ...]:
    """Two straight flights through one point at half the time."""
    out = []
    for side in (-1, 1):
        course = 90.0 + side * p.crossing_angle_deg / 2
        back = _way(p) / 2
        out.append(
            _flight(
                -back * np.sin(np.radians(course)) / 1000,
                (p.crossing_north_m - back * np.cos(np.radians(course))) / 1000,
                course,
                p.speed_mps,
                end=p.duration_s,
            )
        )
    return tuple(out)


def parallel_targets(p: ParallelScans) -> tuple[Target, ...]:
    """Two straight flights side by side, 50 km north of the radar."""
    _way(p)
    return tuple(_flight(-30, 50 + side * p.distance_m / 2000, 90, p.speed_mps, end=p.duration_s) for side in (-1, 1))
