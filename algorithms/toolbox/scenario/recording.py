"""From a scenario of marks to a recording with its truth and site."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from algorithms.errors import ParameterError
from algorithms.recording import ToaMarks
from algorithms.site import Site
from algorithms.spec import Leg
from algorithms.toolbox.frames import earth as earths
from algorithms.toolbox.scenario.mark_parameters import MarkScenario, site_of
from algorithms.toolbox.scenario.marks import MarkNoise, simulate_marks
from algorithms.toolbox.scenario.targets import Path, path_of, states_of
from algorithms.toolbox.scenario.timing import (
    MAX_MARKS,
    interrogated_times,
    irregular_times,
    outside_gaps,
    regular_times,
    timing_stream,
)
from algorithms.toolbox.scenario.trajectory import Trajectory

Floats = NDArray[np.float64]


def simulate(parameters: MarkScenario, trials: tuple[int, ...], seed: int) -> ToaMarks:
    """Simulate a scenario of marks; with no trials at all only its instants and truth, which checks it completely.

    Raises
    ------
    ParameterError
        The scenario cannot be: below the ground, too fast, no mark, too many marks; `pointer` names the field.
    """
    world = _world(parameters)
    marks = simulate_marks(world.truth, world.site.station_positions(), world.noise, trials, seed)
    return ToaMarks(
        time_s=world.time_s,
        row=np.arange(1, world.time_s.size + 1),
        target=world.target,
        targets=_names(parameters),
        truth_m=world.truth.position_m,
        truth_velocity_mps=world.truth.velocity_mps,
        site=world.site,
        toa_s=marks.toa_s,
        altitude_m=marks.altitude_m,
        stations=tuple(s.name for s in parameters.stations),
    )


@dataclass(frozen=True)
class _World:
    """What is the same in all trials; its arrays are shared by the recordings made of it."""

    site: Site
    time_s: Floats
    target: NDArray[np.int64]
    truth: Trajectory
    noise: MarkNoise


@lru_cache(maxsize=2)
def _world(parameters: MarkScenario) -> _World:
    """Compute it once: a Monte Carlo run asks for batch after batch of the same."""
    site = _site(parameters)
    origin = site.frame_origin()
    earth = earths.sphere() if origin is None else earths.wgs84(origin)
    time, target, truth = _marks(parameters, earth)
    noise = MarkNoise(
        sigma_toa_s=np.array([1e-9 * (s.sigma_toa_ns or parameters.sigma_toa_ns) for s in parameters.stations]),
        reception_probability=_receptions(parameters, time),
        clock_error_s=_clocks(parameters, time),
        sigma_altitude_m=parameters.sigma_altitude_m,
        altitude_bias_sd_m=parameters.altitude_bias_sd_m,
        altitude_step_m=parameters.altitude_step_m,
        decoding_probability=parameters.decoding_probability,
        emission_offset_s=parameters.emission_offset_ms / 1000,
        gate_length_s=parameters.gate_length_ms / 1000,
        outlier_share=parameters.outlier_share,
        outlier_late_s=_delays(parameters),
    )
    return _World(site, time, target, truth, noise)


def legs_of(parameters: MarkScenario) -> tuple[Leg, ...]:
    """Return the named intervals."""
    return tuple(Leg(leg.name, leg.start_s, leg.stop_s) for leg in parameters.legs)


def _site(parameters: MarkScenario) -> Site:
    try:
        return site_of(parameters)
    except ValidationError as error:
        message = str(error.errors()[0]["msg"]).removeprefix("Value error, ")
        raise ParameterError(message, pointer="/stations") from error


def _names(parameters: MarkScenario) -> tuple[str, ...]:
    targets = parameters.targets
    if len(targets) == 1:
        return (targets[0].name,)
    names = tuple(t.name or str(i + 1) for i, t in enumerate(targets))
    for i, name in enumerate(names):
        if name in names[:i]:
            raise ParameterError(
                f"Two targets are called {name!r}.", pointer=f"/targets/{i}/name", remedy="Give each its own name."
            )
    return names


def _marks(parameters: MarkScenario, earth: Floats) -> tuple[Floats, NDArray[np.int64], Trajectory]:
    """Instants of all targets in the order of time, whose they are, and the true states then."""
    times, states = [], []
    count = 0
    for i, target in enumerate(parameters.targets):
        pointer = f"/targets/{i}"
        try:
            path = path_of(target)
        except ParameterError as error:
            raise ParameterError(error.message, pointer=pointer + error.pointer, remedy=error.remedy) from error
        own = _instants(parameters, path, i)
        count += own.size
        if count > MAX_MARKS:
            raise ParameterError(
                f"The first {i + 1} of {len(parameters.targets)} targets make more than {MAX_MARKS:,} marks.",
                pointer="/targets",
                remedy="Make the observation shorter, the marks rarer or the targets fewer.",
            )
        # The path is asked for even where no mark falls on it: what cannot be flown is an error anyway.
        states.append(states_of(path, own, earth, pointer))
        times.append(own)
    time = np.concatenate(times)
    if not time.size:
        raise ParameterError(
            "No target sends a mark.",
            pointer="/timing",
            remedy="Look at gaps, duration and, with interrogators, at the reply probability.",
        )
    order = np.argsort(time, kind="stable")
    target_index = np.repeat(np.arange(len(times)), [t.size for t in times])
    truth = Trajectory(
        np.concatenate([s.position_m for s in states])[order],
        np.concatenate([s.velocity_mps for s in states])[order],
        np.concatenate([s.altitude_m for s in states])[order],
        np.concatenate([s.climb_rate_mps for s in states])[order],
    )
    return time[order], target_index[order], truth


def _instants(p: MarkScenario, path: Path, target: int) -> Floats:
    begin, end = path.begin_s, path.end_s if p.duration_s is None else min(path.end_s, p.duration_s)
    if end < begin:
        return np.empty(0)
    rng = timing_stream(p.timing_seed, target)
    if p.timing == "regular":
        times = regular_times(begin, end, p.period_s)
    elif p.timing == "irregular":
        times = irregular_times(begin, end, p.minimum_interval_s, p.mean_extra_interval_s, rng)
    else:
        times = interrogated_times(begin, end, p.interrogators, rng)
    return outside_gaps(times, p.gaps)


def _receptions(parameters: MarkScenario, time: Floats) -> Floats:
    """(M, S), from the intervals, the last one that holds an instant."""
    count = len(parameters.stations)
    probability = np.ones((time.size, count))
    for i, interval in enumerate(parameters.receptions):
        given = interval.probabilities
        where = f"/receptions/{i}"
        if len(given) != count:
            raise ParameterError(
                f"Interval {i + 1} has {len(given)} probabilities for {count} stations.",
                pointer=f"{where}/probabilities",
                remedy="Give one for each station, in their order.",
            )
        if not all(0 <= p <= 1 for p in given):
            raise ParameterError(
                f"The probabilities of interval {i + 1} do not all lie between 0 and 1.",
                pointer=f"{where}/probabilities",
                remedy="Give shares of marks, 0.9 for nine in ten.",
            )
        stop = np.inf if interval.stop_s is None else interval.stop_s
        if stop <= interval.start_s:
            raise ParameterError(
                f"Interval {i + 1} ends at {stop:g} s, not after its beginning.",
                pointer=f"{where}/stop_s",
                remedy="Make it later, or leave it out.",
            )
        probability[(time >= interval.start_s) & (time < stop)] = given
    return probability * parameters.reception_probability


def _clocks(parameters: MarkScenario, time: Floats) -> Floats | None:
    stations = parameters.stations
    constant = np.array([1e-9 * (s.clock_offset_ns + s.clock_error_ns) for s in stations])
    drift = np.array([1e-9 * s.clock_drift_ns_s for s in stations])
    if not (constant.any() or drift.any()):
        return None
    errors: Floats = constant + drift * time[:, None]
    return errors


def _delays(parameters: MarkScenario) -> tuple[float, float]:
    least, most = parameters.outlier_least_ns, parameters.outlier_most_ns
    if most < least:
        raise ParameterError(
            f"The largest delay, {most:g} ns, is less than the least one, {least:g} ns.",
            pointer="/outlier_most_ns",
            remedy="Exchange the two.",
        )
    return 1e-9 * least, 1e-9 * most
