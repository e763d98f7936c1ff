"""Presets from which plots of separated radars are simulated (specification 9, 11, 12).

The places of targets belong to the scenario, not to the trial: where they are random (`two_radars_cluster`) each look
has its own, drawn from `placement_seed`, and a trial sees all looks. Everything is elementwise arithmetic with the
trials innermost.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.identification.scenario_parameters import (
    ClusterParameters,
    RadarScenario,
    TracksParameters,
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


def _plots(
    p: RadarScenario, radars: int, places: Floats, velocity: Floats, time: Floats, trials: tuple[int, ...], seed: int
) -> PolarPlots:
    """Plots of targets at places (look, target, 2), look by look, radar by radar, targets before false plots."""
    looks, targets, _ = places.shape
    slots = targets + p.false_plots
    rows = looks * radars * slots
    if rows > MAX_ROWS:
        raise ParameterError(
            f"This would make {rows:,} plots; a simulated recording takes at most {MAX_ROWS:,}.",
            pointer="/false_plots",
            remedy="Take fewer false plots, targets or looks.",
        )
    sites = radar_places(p, radars)
    look = np.repeat(np.arange(looks), radars * slots)
    radar = np.tile(np.repeat(np.arange(radars), slots), looks)
    slot = np.tile(np.arange(slots), looks * radars)
    real = slot < targets
    truth = np.full((rows, 3), np.nan)
    truth[real, :2] = places[look[real], slot[real]]
    truth[real, 2] = p.height_m
    speed = np.full((rows, 3), np.nan)
    speed[real] = (*velocity, 0.0)
    late = np.where(radar == 1, p.time_offset_s, 0.0)
    # A radar whose clock is wrong looks at another instant than it says.
    seen = np.where(real[:, None], truth[:, :2] + late[:, None] * velocity - sites[radar], 0.0)
    names = tuple(str(i + 1) for i in range(targets)) + ((CLUTTER,) if p.false_plots else ())
    site = _site(p, sites)
    sigma_range = np.array([r.sigma_range_m for r in site.radars], float)[radar]
    sigma_azimuth = np.radians(np.array([r.sigma_azimuth_deg for r in site.radars], float))[radar]
    drawn = _drawn(p, places, look, radar, slot, real, sites, trials, seed)
    east, north = seen[:, :1] + drawn.east, seen[:, 1:] + drawn.north
    slant = np.sqrt(east * east + north * north + np.where(real, p.height_m, 0.0)[:, None] ** 2)
    true_plot = np.where(real, 1.0, 0.0)[:, None]
    range_m = slant + true_plot * sigma_range[:, None] * drawn.noise[0]
    bias = np.where(radar == 1, np.radians(p.azimuth_bias_deg), 0.0)
    azimuth = np.arctan2(east, north) + true_plot * (sigma_azimuth[:, None] * drawn.noise[1] + bias[:, None])
    range_m = np.where(drawn.detected, range_m, np.nan)
    none = np.full(range_m.shape, np.nan)
    return PolarPlots(
        time_s=time[look],
        row=np.arange(1, rows + 1),
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
        radar_east_m=np.full(rows, np.nan),
        radar_north_m=np.full(rows, np.nan),
        scan=look.astype(np.int64),
        address=np.full(rows, -1),
        callsign=np.full(rows, -1),
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
    p: RadarScenario, places: Floats, look: Ints, radar: Ints, slot: Ints, real: NDArray[np.bool_], sites: Floats,
    trials: tuple[int, ...], seed: int,
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
            deviation = _deviations(places.shape[:2], p.acceleration_density_m2ps3, p.period_s, rng)
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
)
