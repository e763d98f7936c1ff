"""Presets from which plots of separated radars are simulated (specification 9, 11, 12).

The places of targets belong to the scenario, not to the trial: where they are random (`two_radars_cluster`) each look
has its own, drawn from `placement_seed`, and a trial sees all looks. Everything is elementwise arithmetic with the
trials innermost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.identification.scenario_parameters import (
    ClusterParameters,
    RadarScenario,
    TracksParameters,
    TurningParameters,
    TwoTargetsParameters,
)
from algorithms.recording import PolarPlots
from algorithms.site import Site
from algorithms.spec import Leg, Reference, Scenario, trial_stream

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CLUTTER = "clutter"
"""Name of the target of plots that come from no target."""
# Purposes of the random streams; 0 belongs to the algorithm.
NOISE, DETECTION, FALSE_PLOTS, MANOEUVRE = range(1, 5)
# Radars after the second stand on the base turned by this much each, so that three make an equal-sided triangle.
TURN_RAD = np.pi / 3
MAX_ROWS = 200_000
# Rounds in which the instant and the place at which a beam meets a target settle: each gains the ratio of their speeds.
CLOSER = 6


def _unit(azimuth_deg: float) -> Floats:
    """(2,) east and north of a compass azimuth."""
    a = np.radians(azimuth_deg)
    return np.array([np.sin(a), np.cos(a)])


def _left(unit: Floats) -> Floats:
    return np.array([-unit[1], unit[0]])


def radar_places(p: RadarScenario, count: int) -> Floats:
    """(K, 2) m: true places of the radars; the first is the origin."""
    base = p.base_m * _unit(p.base_azimuth_deg)
    places = [np.zeros(2), base]
    for k in range(1, count - 1):
        c, s = np.cos(k * TURN_RAD), np.sin(k * TURN_RAD)
        places.append(np.array([c * base[0] - s * base[1], s * base[0] + c * base[1]]))
    return np.array(places[:count])


def _site(p: RadarScenario, places: Floats) -> Site:
    radars = []
    for k, place in enumerate(places):
        error = (p.site_error_east_m, p.site_error_north_m) if k == 1 else (0.0, 0.0)
        radars.append(
            {
                "name": str(k + 1),
                "east_m": float(place[0] + error[0]),
                "north_m": float(place[1] + error[1]),
                "up_m": 0.0,
                "sigma_range_m": _of_radar(p.sigma_range_m, p.second_sigma_range_m, k),
                "sigma_azimuth_deg": _of_radar(p.sigma_azimuth_deg, p.second_sigma_azimuth_deg, k),
                "range_kind": "ground",
            }
        )
    return Site.model_validate({"radars": radars})


def _of_radar(common: float, second: float | None, radar: int) -> float:
    return second if radar == 1 and second is not None else common


def target_1(p: RadarScenario) -> Floats:
    """(2,) m: place of target 1."""
    place: Floats = p.target_range_m * _unit(p.target_azimuth_deg)
    return place


def _second_target(p: TwoTargetsParameters | TracksParameters) -> Floats:
    sight = _unit(p.target_azimuth_deg)
    place: Floats = target_1(p) + p.offset_along_m * sight + p.offset_across_m * _left(sight)
    return place


def simulate_two_targets(p: TwoTargetsParameters, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Two targets at one instant, seen by two radars."""
    places = np.stack([target_1(p), _second_target(p)])
    return _plots(p, 2, places[None], p.speed_mps * _unit(p.course_deg), np.zeros(1), trials, seed)


def simulate_cluster(p: ClusterParameters, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Targets at random in a square, anew at each look."""
    rng = np.random.default_rng(np.random.SeedSequence(entropy=p.placement_seed, spawn_key=(7,)))
    offsets = (rng.random((p.looks, p.targets, 2)) - 0.5) * p.region_side_m
    time: Floats = p.period_s * np.arange(p.looks, dtype=float)
    return _plots(p, p.radars, target_1(p) + offsets, p.speed_mps * _unit(p.course_deg), time, trials, seed)


def simulate_tracks(p: TracksParameters, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Two targets on parallel straight lines that end at the places of `two_radars_two_targets`."""
    ends = np.stack([target_1(p), _second_target(p)])
    time: Floats = p.period_s * np.arange(p.scans, dtype=float)
    velocity: Floats = p.speed_mps * _unit(p.course_deg)
    places = ends[None] + velocity * (time - time[-1])[:, None, None]
    return _plots(p, 2, places, velocity, time, trials, seed)


@dataclass(frozen=True)
class _Rows:
    """What stands behind each plot, look by look, radar by radar, targets before false plots.

    Attributes
    ----------
    look, radar, slot : (M,) the slot is the target, or beyond them a false plot
    real : (M,) whether a target is behind it
    time : (M,) s
    place, velocity : (M, 2) m and m/s of the target; NaN of a false plot
    """

    look: Ints
    radar: Ints
    slot: Ints
    real: NDArray[np.bool_]
    time: Floats
    place: Floats
    velocity: Floats


def _numbered(p: RadarScenario, looks: int, radars: int, targets: int) -> tuple[Ints, Ints, Ints]:
    """Look, radar and slot of each row."""
    slots = targets + p.false_plots
    rows = looks * radars * slots
    if rows > MAX_ROWS:
        raise ParameterError(
            f"This would make {rows:,} plots; a simulated recording takes at most {MAX_ROWS:,}.",
            pointer="/false_plots",
            remedy="Take fewer false plots, targets or looks.",
        )
    look = np.repeat(np.arange(looks), radars * slots)
    radar = np.tile(np.repeat(np.arange(radars), slots), looks)
    return look, radar, np.tile(np.arange(slots), looks * radars)


def _plots(
    p: RadarScenario, radars: int, places: Floats, velocity: Floats, time: Floats, trials: tuple[int, ...], seed: int
) -> PolarPlots:
    """Plots of targets at places (look, target, 2), all at the instant of their look."""
    looks, targets, _ = places.shape
    look, radar, slot = _numbered(p, looks, radars, targets)
    real = slot < targets
    place, speed = np.full((look.size, 2), np.nan), np.full((look.size, 2), np.nan)
    place[real] = places[look[real], slot[real]]
    speed[real] = velocity
    rows = _Rows(look, radar, slot, real, time[look], place, speed)
    return _measured(p, rows, radars, targets, places.shape[:2], trials, seed)


def simulate_turning(p: TurningParameters, trials: tuple[int, ...], seed: int) -> PolarPlots:
    """Targets on straight lines of their own, each plot at the instant at which the beam of its radar meets them."""
    rng = np.random.default_rng(np.random.SeedSequence(entropy=p.placement_seed, spawn_key=(8,)))
    sites = radar_places(p, p.radars)
    turn = p.rotation_s + p.rotation_step_s * np.arange(p.radars)
    phase = rng.random(p.radars)
    middle = target_1(p) + (rng.random((p.targets, 2)) - 0.5) * p.region_side_m
    course = rng.random(p.targets) * 2 * np.pi
    flown = p.speed_mps * np.stack([np.sin(course), np.cos(course)], axis=1)
    span = p.looks * p.rotation_s
    # The slowest radar turns less often: what it has not seen by the end is cut off.
    look, radar, slot = _numbered(p, p.looks + 1, p.radars, p.targets)
    real = slot < p.targets
    which = slot.clip(max=p.targets - 1)
    velocity = np.where(real[:, None], flown[which], 0.0)
    half = span / 2
    time: Floats = np.full(look.size, half)
    first: Floats | None = None
    for _ in range(CLOSER):
        # The beam is at 0 at its phase; it meets a target where that is by then. False plots lie about the middle.
        place = np.where(real[:, None], middle[which] + velocity * (time - half)[:, None], target_1(p))
        east, north = (place - sites[radar]).T
        share = np.mod(np.arctan2(east, north) / (2 * np.pi) + phase[radar], 1.0)
        first = share if first is None else first
        # On the side of the middle place: a share that goes on from 0.99 to 0.01 would lose a turn.
        time = turn[radar] * (look + first + np.mod(share - first + 0.5, 1.0) - 0.5)
    kept = np.flatnonzero((time >= 0) & (time < span))
    kept = kept[np.argsort(time[kept], kind="stable")]
    place[~real], velocity[~real] = np.nan, np.nan
    number = np.floor(time / p.rotation_s).astype(np.int64)
    rows = _Rows(number[kept], radar[kept], slot[kept], real[kept], time[kept], place[kept], velocity[kept])
    return _measured(p, rows, p.radars, p.targets, (p.looks, p.targets), trials, seed)


def _measured(
    p: RadarScenario, rows: _Rows, radars: int, targets: int, shape: tuple[int, ...], trials: tuple[int, ...], seed: int
) -> PolarPlots:
    """What the radars say of what stands behind the rows."""
    sites = radar_places(p, radars)
    look, radar, slot, real = rows.look, rows.radar, rows.slot, rows.real
    count = look.size
    truth = np.column_stack([rows.place, np.where(real, p.height_m, np.nan)])
    speed = np.column_stack([rows.velocity, np.where(real, 0.0, np.nan)])
    late = np.where(radar == 1, p.time_offset_s, 0.0)
    # A radar whose clock is wrong looks at another instant than it says.
    seen = np.where(real[:, None], rows.place + late[:, None] * rows.velocity - sites[radar], 0.0)
    names = tuple(str(i + 1) for i in range(targets)) + ((CLUTTER,) if p.false_plots else ())
    site = _site(p, sites)
    sigma_range = np.array([r.sigma_range_m for r in site.radars], float)[radar]
    sigma_azimuth = np.radians(np.array([r.sigma_azimuth_deg for r in site.radars], float))[radar]
    drawn = _drawn(p, shape, look, radar, slot, real, sites, trials, seed)
    east, north = seen[:, :1] + drawn.east, seen[:, 1:] + drawn.north
    slant = np.sqrt(east * east + north * north + np.where(real, p.height_m, 0.0)[:, None] ** 2)
    true_plot = np.where(real, 1.0, 0.0)[:, None]
    range_m = slant + true_plot * sigma_range[:, None] * drawn.noise[0]
    bias = np.where(radar == 1, np.radians(p.azimuth_bias_deg), 0.0)
    azimuth = np.arctan2(east, north) + true_plot * (sigma_azimuth[:, None] * drawn.noise[1] + bias[:, None])
    range_m = np.where(drawn.detected, range_m, np.nan)
    none = np.full(range_m.shape, np.nan)
    return PolarPlots(
        time_s=rows.time,
        row=np.arange(1, count + 1),
        target=slot.clip(max=targets).astype(np.int64),
        targets=names,
        truth_m=truth,
        truth_velocity_mps=speed,
        site=site,
        range_m=range_m,
        azimuth_rad=np.where(drawn.detected, np.mod(azimuth, 2 * np.pi), np.nan),
        elevation_rad=none,
        altitude_m=none,
        east_m=none,
        north_m=none,
        radar=radar.astype(np.int64),
        radar_east_m=np.full(count, np.nan),
        radar_north_m=np.full(count, np.nan),
        scan=look.astype(np.int64),
        address=np.full(count, -1),
        callsign=np.full(count, -1),
        radars=tuple(str(k + 1) for k in range(radars)),
    )


class _Draws:
    """What a trial draws, trials side by side: (2, rows, L) noise, (rows, L) offsets and detections."""

    def __init__(self, rows: int, lanes: int) -> None:
        self.noise = np.empty((2, rows, lanes))
        self.detected = np.ones((rows, lanes), np.bool_)
        self.east = np.zeros((rows, lanes))
        self.north = np.zeros((rows, lanes))


def _drawn(
    p: RadarScenario, shape: tuple[int, ...], look: Ints, radar: Ints, slot: Ints, real: NDArray[np.bool_],
    sites: Floats, trials: tuple[int, ...], seed: int,
) -> _Draws:  # fmt: skip
    rows = look.size
    out = _Draws(rows, len(trials))
    false = np.flatnonzero(~real)
    middle = target_1(p) - sites[radar[false]]
    for lane, trial in enumerate(trials):
        out.noise[:, :, lane] = trial_stream(seed, trial, NOISE).standard_normal((2, rows))
        if p.detection_probability < 1:
            seen = trial_stream(seed, trial, DETECTION).random(rows) < p.detection_probability
            out.detected[:, lane] = seen | ~real
        if false.size:
            inside = (trial_stream(seed, trial, FALSE_PLOTS).random((2, false.size)) - 0.5) * p.region_side_m
            out.east[false, lane] = middle[:, 0] + inside[0]
            out.north[false, lane] = middle[:, 1] + inside[1]
        if isinstance(p, TracksParameters) and p.acceleration_density_m2ps3:
            rng = trial_stream(seed, trial, MANOEUVRE)
            deviation = _deviations(shape, p.acceleration_density_m2ps3, p.period_s, rng)
            out.east[:, lane] += deviation[look, slot, 0]
            out.north[:, lane] += deviation[look, slot, 1]
    return out


def _deviations(shape: tuple[int, ...], density: float, period: float, rng: np.random.Generator) -> Floats:
    """(look, target, 2) m from the straight line: white acceleration of this density, ending at 0 with the line."""
    looks, targets = shape
    draws = rng.standard_normal((2, looks, targets, 2)) * np.sqrt(density * period)
    position, velocity = np.zeros((targets, 2)), np.zeros((targets, 2))
    out = np.empty((looks, targets, 2))
    for k in range(looks):
        out[k] = position
        # Cholesky factor of [[T^3/3, T^2/2], [T^2/2, T]] over sqrt(T).
        a, b = draws[0, k], draws[1, k]
        position = position + period * velocity + period * (a / 2 + b / np.sqrt(12.0))
        velocity = velocity + a
    return out


def _last_scan(p: TracksParameters) -> tuple[Leg, ...]:
    """The last scan, at which tracks have settled best, by its instant."""
    last = p.period_s * (p.scans - 1)
    return (Leg(f"t={last:g}", last, last + p.period_s / 2),)


def _scenario(
    name: str,
    title: str,
    summary: str,
    parameters: type[RadarScenario],
    simulate: Any,
    legs: Callable[[Any], tuple[Leg, ...]] = lambda _: (),
) -> Scenario:
    return Scenario(
        name=name,
        title=title,
        summary=summary,
        family="identification",
        kind="polar_plots",
        parameters=parameters,
        simulate=simulate,
        legs=legs,
        references=(Reference("prosov2008", "table 1"),),
    )


SCENARIOS = (
    _scenario(
        "two_radars_two_targets",
        "Two radars, two targets",
        "One look of two radars at two close targets 150 km away, the geometry of the paper's table.",
        TwoTargetsParameters,
        simulate_two_targets,
    ),
    _scenario(
        "two_radars_cluster",
        "Radars and a cluster of targets",
        "Two to four radars look at targets spread at random over a square, each look with other places, on request "
        "with missed detections and false plots.",
        ClusterParameters,
        simulate_cluster,
    ),
    _scenario(
        "two_radars_tracks",
        "Two radars track two targets",
        "Two targets fly side by side in a straight line, and two radars track each of them for some scans.",
        TracksParameters,
        simulate_tracks,
        _last_scan,
    ),
    _scenario(
        "turning_radars",
        "Radars that turn by themselves",
        "Two to four radars turn, each with its own period and phase, past targets that fly straight, each its own "
        "way: no two plots have the same instant. Stored as a recording its plots are moved to one; trials show what "
        "becomes of them where nobody does.",
        TurningParameters,
        simulate_turning,
    ),
)
