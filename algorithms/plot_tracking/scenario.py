"""Presets from which the plots of one rotating radar are simulated (specification 7).

The radar is the origin. Instants and paths belong to the scenario; noise, detections and false plots to a trial. Each
scan has a row for each target that is there, and as many rows for false plots as any trial could need: what a trial
did not detect, or has not so many false plots for, is no measurement in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.plot_tracking.presets import (
    BASE_10,
    CLUTTER_ONLY,
    EN_ROUTE,
    FORMATION,
    MANY,
    OVERTAKING,
    SPEED_CHANGE,
    STEADY,
    STRAIGHT,
    TIGHT_TURN,
    WIDE_TURN,
    crossing_targets,
    many_targets,
    parallel_targets,
)
from algorithms.plot_tracking.scenario_parameters import (
    AircraftScans,
    CrossingScans,
    ManyScans,
    ParallelScans,
    RadarScans,
)
from algorithms.recording import CLUTTER, PolarPlots
from algorithms.site import Site
from algorithms.spec import Leg, Reference, Scenario, trial_stream
from algorithms.toolbox.frames.earth import sphere
from algorithms.toolbox.scenario.targets import Target, path_of, states_of
from algorithms.toolbox.scenario.timing import outside_gaps, regular_times

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Purposes of the random streams; 0 belongs to the algorithm.
NOISE, DETECTION, FALSE_COUNT, FALSE_PLACE = range(1, 5)
MOST_ROWS = 400_000
# 25 ft, the step of a coded altitude.
ALTITUDE_STEP_M = 7.62


@dataclass(frozen=True)
class _Rows:
    """Rows of a recording: scan and target (one behind the last is clutter) of each, and the true states."""

    scan: Ints
    target: Ints
    truth_m: Floats
    velocity_mps: Floats
    altitude_m: Floats
    false_slots: int


def simulate_aircraft(p: AircraftScans, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Targets with paths of their own."""
    return _plots(p, p.targets, trials, seed)


def simulate_crossing(p: CrossingScans, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Two targets that are at one place at half the time."""
    return _plots(p, crossing_targets(p), trials, seed)


def simulate_parallel(p: ParallelScans, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Two targets side by side."""
    return _plots(p, parallel_targets(p), trials, seed)


def simulate_many(p: ManyScans, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """As many targets as are asked for."""
    return _plots(p, many_targets(p), trials, seed)


def simulate_clutter(p: RadarScans, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """No target at all."""
    return _plots(p, (), trials, seed)


def _plots(p: RadarScans, targets: tuple[Target, ...], trials: tuple[int, ...], seed: int) -> PolarPlots:
    time = outside_gaps(regular_times(0.0, p.duration_s, p.period_s), p.gaps)
    rows = _rows(p, targets, time)
    false = rows.target == len(targets)
    east, north = (np.where(false, 0.0, rows.truth_m[:, i])[:, None] for i in (0, 1))
    up = np.where(false, 0.0, rows.truth_m[:, 2])[:, None] if p.range_kind == "slant" else np.zeros_like(east)
    range_m = np.broadcast_to(np.sqrt(east**2 + north**2 + up**2), (false.size, len(trials))).copy()
    azimuth = np.broadcast_to(np.arctan2(east, north), range_m.shape).copy()
    for lane, trial in enumerate(trials):
        _draw(p, rows, time.size, ~false, range_m[:, lane], azimuth[:, lane], trial, seed)
    azimuth = np.where(np.isfinite(range_m), np.mod(azimuth, 2 * np.pi), np.nan)
    none = np.full(range_m.shape, np.nan)
    coded = np.round(rows.altitude_m / ALTITUDE_STEP_M)[:, None] * ALTITUDE_STEP_M
    said = ~false[:, None] & np.isfinite(range_m) & (p.transponders != "none")
    names = tuple(t.name or str(i + 1) for i, t in enumerate(targets))
    if len(set(names)) < len(names):
        raise ParameterError(
            "Two targets have the same name.", pointer="/targets", remedy="Name each of them once, or none."
        )
    return PolarPlots(
        time_s=time[rows.scan],
        row=np.arange(1, rows.scan.size + 1),
        target=rows.target,
        targets=(*names, CLUTTER) if rows.false_slots or not targets else names,
        truth_m=rows.truth_m,
        truth_velocity_mps=rows.velocity_mps,
        site=_site(p),
        range_m=range_m,
        azimuth_rad=azimuth,
        elevation_rad=none,
        altitude_m=np.where(said, coded, np.nan),
        east_m=none,
        north_m=none,
        radar=np.zeros(rows.scan.size, np.int64),
        radar_east_m=np.full(rows.scan.size, np.nan),
        radar_north_m=np.full(rows.scan.size, np.nan),
        scan=rows.scan,
        address=np.where(false | (p.transponders != "address"), -1, rows.target),
        callsign=np.full(rows.scan.size, -1),
        radars=("radar",),
        addresses=tuple(f"{0x400000 + i:06X}" for i in range(len(targets))) if p.transponders == "address" else (),
    )


def _rows(p: RadarScans, targets: tuple[Target, ...], time: Floats) -> _Rows:
    """Scan by scan: the targets that are there, then the places of false plots."""
    # A trial has more of a Poisson number than this once in 1e12 scans.
    slots = int(np.ceil(p.false_plots + 8 * np.sqrt(p.false_plots) + 8)) if p.false_plots else 0
    if time.size * (len(targets) + slots) > MOST_ROWS:
        raise ParameterError(
            f"This would make up to {time.size * (len(targets) + slots):,} plots; a simulated recording takes at most "
            f"{MOST_ROWS:,}.",
            pointer="/false_plots" if slots > len(targets) else "/duration_s",
            remedy="Take fewer false plots, targets or scans.",
        )
    earth = sphere()
    scan, target, states = [np.repeat(np.arange(time.size), slots)], [np.full(time.size * slots, len(targets))], []
    for i, one in enumerate(targets):
        path = path_of(one)
        there = np.flatnonzero((time >= path.begin_s - 1e-9) & (time <= path.end_s + 1e-9))
        states.append(states_of(path, time[there].clip(path.begin_s, path.end_s), earth, f"/targets/{i}"))
        scan.append(there)
        target.append(np.full(there.size, i))
    all_scans, all_targets = np.concatenate(scan), np.concatenate(target)
    nothing = np.full((time.size * slots, 3), np.nan)
    truth = np.concatenate([nothing, *(s.position_m for s in states)])
    velocity = np.concatenate([nothing, *(s.velocity_mps for s in states)])
    altitude = np.concatenate([nothing[:, 0], *(s.altitude_m for s in states)])
    order = np.lexsort((all_targets, all_scans))
    return _Rows(all_scans[order], all_targets[order], truth[order], velocity[order], altitude[order], slots)


def _draw(
    p: RadarScans, rows: _Rows, scans: int, real: NDArray[np.bool_], range_m: Floats, azimuth: Floats, trial: int,
    seed: int,
) -> None:  # fmt: skip
    """Put one trial's noise, detections and false plots into its columns."""
    count = range_m.size
    noise = trial_stream(seed, trial, NOISE).standard_normal((2, int(real.sum())))
    range_m[real] += p.sigma_range_m * noise[0]
    azimuth[real] += np.radians(p.sigma_azimuth_deg) * noise[1]
    # An error of the range beyond the range itself is no plot.
    range_m[real & (range_m <= 0)] = np.nan
    if p.detection_probability < 1:
        missed = trial_stream(seed, trial, DETECTION).random(int(real.sum())) >= p.detection_probability
        range_m[np.flatnonzero(real)[missed]] = np.nan
    if rows.false_slots:
        number = trial_stream(seed, trial, FALSE_COUNT).poisson(p.false_plots, scans)
        place = trial_stream(seed, trial, FALSE_PLACE).random((2, count - int(real.sum())))
        slot = np.tile(np.arange(rows.false_slots), scans)
        here = slot < np.repeat(number, rows.false_slots)
        range_m[~real] = np.where(here, p.clutter_radius_m * np.sqrt(place[0]), np.nan)
        azimuth[~real] = 2 * np.pi * place[1]


def _site(p: RadarScans) -> Site:
    radar = {
        "name": "radar",
        "east_m": 0.0,
        "north_m": 0.0,
        "up_m": 0.0,
        "sigma_range_m": p.sigma_range_m,
        "sigma_azimuth_deg": p.sigma_azimuth_deg,
        "period_s": p.period_s,
        "range_kind": p.range_kind,
    }
    return Site.model_validate({"radars": [radar]})


def _legs(p: RadarScans) -> tuple[Leg, ...]:
    return tuple(Leg(leg.name, leg.start_s, leg.stop_s) for leg in p.legs)


def _scenario(
    name: str, title: str, summary: str, parameters: type[RadarScans], simulate: Callable[[Any, Any, int], PolarPlots]
) -> Scenario:
    return Scenario(
        name=name,
        title=title,
        summary=summary,
        family="plot_tracking",
        kind="polar_plots",
        parameters=parameters,
        simulate=simulate,
        legs=_legs,
        references=(Reference("plots2006", "section 2"),),
    )


SCENARIOS = (
    _scenario(
        "wide_turn",
        "Aircraft in a wide turn",
        "One aircraft at 200 m/s flies straight, turns by 90 degrees with a bank of 25 degrees, and flies straight on.",
        WIDE_TURN,
        simulate_aircraft,
    ),
    _scenario(
        "straight_aircraft",
        "Aircraft in straight flight",
        "One aircraft passes the radar at 200 m/s: what every manoeuvre detector must keep quiet on.",
        STRAIGHT,
        simulate_aircraft,
    ),
    _scenario(
        "tight_turn",
        "Aircraft in a tight turn",
        "One slow aircraft turns back at the standard rate of 3 degrees a second.",
        TIGHT_TURN,
        simulate_aircraft,
    ),
    _scenario(
        "speed_change",
        "Aircraft that speeds up",
        "One aircraft on a straight line goes from 100 to 220 m/s within a minute.",
        SPEED_CHANGE,
        simulate_aircraft,
    ),
    _scenario(
        "en_route_turn",
        "Turn far from the radar",
        "An en-route radar with a period of 10 s sees an aircraft turn by 60 degrees at 150 km.",
        EN_ROUTE,
        simulate_aircraft,
    ),
    _scenario(
        "ten_aircraft",
        "Ten aircraft",
        "Ten aircraft within 80 km fly straight, turn, weave and change speed; made for missed detections and false "
        "plots.",
        BASE_10,
        simulate_aircraft,
    ),
    _scenario(
        "crossing_aircraft",
        "Crossing aircraft",
        "Two aircraft are at the same place at the same instant, their courses apart by an angle.",
        CrossingScans,
        simulate_crossing,
    ),
    _scenario(
        "parallel_aircraft",
        "Aircraft side by side",
        "Two aircraft fly side by side, closer than the radar's errors where the distance is small.",
        ParallelScans,
        simulate_parallel,
    ),
    _scenario(
        "overtaking_aircraft",
        "Overtaking",
        "A faster aircraft overtakes another on a parallel course 300 m away.",
        OVERTAKING,
        simulate_aircraft,
    ),
    _scenario(
        "aircraft_formation",
        "Formation in a turn",
        "Four aircraft in a formation of 1.5 km turn by 90 degrees at the same time.",
        FORMATION,
        simulate_aircraft,
    ),
    _scenario(
        "steady_motions",
        "Five steady motions",
        "Straight flight at 200, 50 and 20 m/s, a wide and a tight turn, each for a minute at 58 km: what a trajectory "
        "fitted to the last plots is worth.",
        STEADY,
        simulate_aircraft,
    ),
    _scenario(
        "many_aircraft",
        "Many aircraft",
        "Aircraft all over a disc of 200 km, a third of them turning, and as many false plots: how trackers hold out, "
        "and what they cost, as there are more.",
        MANY,
        simulate_many,
    ),
    _scenario(
        "clutter_only",
        "False plots alone",
        "No aircraft at all: every confirmed track is a false one.",
        CLUTTER_ONLY,
        simulate_clutter,
    ),
)
