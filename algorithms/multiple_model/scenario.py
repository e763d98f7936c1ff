"""Presets from which antenna plots of one object are simulated (specification 9).

Range and both bicone angles get independent Gaussian errors, added to the exact coordinates. Instants belong to the
scenario, errors to a trial. Where the object leaves the antenna's half-space a plot is missing in all trials.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic.fields import FieldInfo

from algorithms.errors import ParameterError
from algorithms.multiple_model.flight import Command, Flight, Flown, fly
from algorithms.multiple_model.random_flight import (
    AFTER_S,
    ANTENNA_ELEVATION_DEG,
    FIRST_S,
    UP_M,
    VELOCITY_NORTH_MPS,
    VELOCITY_UP_MPS,
    random_flight,
)
from algorithms.recording import AntennaPlots
from algorithms.site import Site
from algorithms.spec import Leg, Parameters, Reference, Scenario, parameter, trial_stream
from algorithms.toolbox.frames.bicone import antenna_axes, bicone_from_position
from algorithms.toolbox.scenario.mark_parameters import NamedInterval
from algorithms.toolbox.scenario.timing import Gap, irregular_times, outside_gaps, regular_times, timing_stream

Floats = NDArray[np.float64]

MOST_PLOTS = 200_000
# Purposes of the random streams; 0 belongs to the algorithm.
NOISE, DETECTION, OUTLIER = 1, 2, 3
_FARTHEST_M = 1e7


class AntennaScenario(Parameters):
    """One object before a flat fixed antenna: start, commanded accelerations, instants and accuracies."""

    east_m: float = parameter(0.0, title="Start, east", unit="m", group="targets", ge=-_FARTHEST_M, le=_FARTHEST_M)
    """In the local frame."""
    north_m: float = parameter(
        50_000.0, title="Start, north", unit="m", group="targets", ge=-_FARTHEST_M, le=_FARTHEST_M
    )
    """In the local frame."""
    up_m: float = parameter(8_000.0, title="Start, up", unit="m", group="targets", ge=-1_000, le=1e6)
    """In the local frame."""
    velocity_east_mps: float = parameter(0.0, title="Velocity, east", unit="m/s", group="targets", ge=-1e4, le=1e4)
    """At the start."""
    velocity_north_mps: float = parameter(-250.0, title="Velocity, north", unit="m/s", group="targets", ge=-1e4, le=1e4)
    """At the start."""
    velocity_up_mps: float = parameter(0.0, title="Velocity, up", unit="m/s", group="targets", ge=-1e4, le=1e4)
    """At the start."""
    free_flight: bool = parameter(False, title="Free flight", group="targets")
    """Gravity and drag act; without, the object flies on where nothing is commanded."""
    ballistic_coefficient_kgpm2: float = parameter(
        12_000.0, title="Ballistic coefficient", unit="kg/m²", symbol="β", group="targets", ge=100, le=1e6
    )
    """Of the drag in free flight."""
    commands: tuple[Command, ...] = parameter((), title="Commands", group="targets", max_length=500)
    """Accelerations at instants, linear between them."""
    duration_s: float = parameter(120.0, title="Duration", unit="s", group="timing", gt=0, le=7200)
    """Of the recording."""
    timing: Literal["regular", "irregular"] = parameter(
        "regular",
        title="Plots come",
        group="timing",
        choices={"regular": "at the rate", "irregular": "after half the mean interval and an exponential remainder"},
    )
    """Instants are the same in all trials."""
    rate_hz: float = parameter(20.0, title="Rate", unit="Hz", group="timing", ge=0.01, le=100)
    """Plots in a second; of irregular ones the mean."""
    gaps: tuple[Gap, ...] = parameter((), title="Gaps", group="timing", max_length=100)
    """Intervals without plots."""
    timing_seed: int = parameter(0, title="Seed of the instants", group="timing", advanced=True, ge=0, le=2**32 - 1)
    """Another seed gives other irregular instants."""
    antenna_azimuth_deg: float = parameter(0.0, title="Antenna azimuth", unit="°", group="stations", ge=-360, le=360)
    """Where the boresight looks, clockwise from north."""
    antenna_elevation_deg: float = parameter(30.0, title="Antenna elevation", unit="°", group="stations", ge=-90, le=90)
    """Where the boresight looks, above the horizon."""
    antenna_up_m: float = parameter(0.0, title="Antenna height", unit="m", group="stations", ge=-1_000, le=1e5)
    """Of the phase centre in the local frame."""
    sigma_range_m: float = parameter(2.5, title="Range error", unit="m", symbol="σ_r", group="reception", gt=0, le=1e4)
    """Standard deviation; the site tells it to the algorithms."""
    sigma_bicone_elevation_deg: float = parameter(
        0.1, title="Bicone elevation error", unit="°", symbol="σ_ε", group="reception", gt=0, le=5
    )
    """Standard deviation; the site tells it to the algorithms."""
    sigma_bicone_azimuth_deg: float = parameter(
        0.1, title="Bicone azimuth error", unit="°", symbol="σ_α", group="reception", gt=0, le=5
    )
    """Standard deviation; the site tells it to the algorithms."""
    detection_probability: float = parameter(
        1.0, title="Detection probability", unit="1", group="reception", ge=0, le=1
    )
    """Share of instants with a plot."""
    outlier_share: float = parameter(0.0, title="Wild plots", unit="1", group="reception", ge=0, le=1)
    """Share of plots whose errors are twenty times as large."""
    legs: tuple[NamedInterval, ...] = parameter((), title="Legs", group="legs", max_length=50)
    """Intervals whose metrics are given apart."""


def site_of(parameters: AntennaScenario) -> Site:
    """Return the site as the algorithms are told it."""
    antenna = {
        "name": "antenna",
        "east_m": 0.0,
        "north_m": 0.0,
        "up_m": parameters.antenna_up_m,
        "azimuth_deg": parameters.antenna_azimuth_deg,
        "elevation_deg": parameters.antenna_elevation_deg,
        "sigma_range_m": parameters.sigma_range_m,
        "sigma_bicone_elevation_deg": parameters.sigma_bicone_elevation_deg,
        "sigma_bicone_azimuth_deg": parameters.sigma_bicone_azimuth_deg,
    }
    return Site.model_validate({"radars": [antenna]})


def legs_of(parameters: AntennaScenario) -> tuple[Leg, ...]:
    """Return the named intervals."""
    return tuple(Leg(leg.name, leg.start_s, leg.stop_s) for leg in parameters.legs)


@lru_cache(maxsize=8)
def truth_of(parameters: AntennaScenario) -> tuple[Floats, Flown]:
    """Instants (M,) and the true states at them; all trials and batches of a run share them.

    Raises
    ------
    ParameterError
        No or too many plots, or a flight that cannot be.
    """
    if parameters.duration_s * parameters.rate_hz > MOST_PLOTS:
        raise ParameterError(
            f"This would make more than {MOST_PLOTS:,} plots.",
            pointer="/rate_hz",
            remedy="Make the observation shorter or the plots rarer.",
        )
    interval = 1 / parameters.rate_hz
    if parameters.timing == "regular":
        times = regular_times(0.0, parameters.duration_s, interval)
    else:
        rng = timing_stream(parameters.timing_seed, 0)
        times = irregular_times(0.0, parameters.duration_s, interval / 2, interval / 2, rng)
    times = outside_gaps(times, parameters.gaps)
    if not times.size:
        raise ParameterError(
            "No plot falls into the observation.",
            pointer="/gaps",
            remedy="Look at gaps, duration and rate.",
        )
    flight = Flight(
        (parameters.east_m, parameters.north_m, parameters.up_m),
        (parameters.velocity_east_mps, parameters.velocity_north_mps, parameters.velocity_up_mps),
        parameters.commands,
        parameters.free_flight,
        parameters.ballistic_coefficient_kgpm2,
    )
    return times, fly(flight, times)


def simulate(parameters: AntennaScenario, trials: tuple[int, ...], seed: int) -> AntennaPlots:
    """Simulate antenna plots over trials; with no trials at all only instants and truth.

    Raises
    ------
    ParameterError
        The scenario cannot be, or the object is never before the antenna; `pointer` names the field.
    """
    times, flown = truth_of(parameters)
    site = site_of(parameters)
    axes = antenna_axes(np.radians(parameters.antenna_azimuth_deg), np.radians(parameters.antenna_elevation_deg))
    exact = np.stack(bicone_from_position(flown.position_m, axes, site.radar_positions()[0]))
    if not np.isfinite(exact).all(axis=0).any():
        raise ParameterError(
            "The object is never in front of the antenna.",
            pointer="/antenna_azimuth_deg",
            remedy="Turn the antenna towards the trajectory.",
        )
    sd = np.array(
        [
            parameters.sigma_range_m,
            np.radians(parameters.sigma_bicone_elevation_deg),
            np.radians(parameters.sigma_bicone_azimuth_deg),
        ]
    )
    m = times.size
    measured = np.empty((3, m, len(trials)))
    for lane, trial in enumerate(trials):
        noise = trial_stream(seed, trial, NOISE).standard_normal((m, 3)).T
        if parameters.outlier_share:
            wild = trial_stream(seed, trial, OUTLIER).random(m) < parameters.outlier_share
            noise[:, wild] *= 20.0
        measured[:, :, lane] = exact + sd[:, None] * noise
        if parameters.detection_probability < 1:
            seen = trial_stream(seed, trial, DETECTION).random(m) < parameters.detection_probability
            measured[:, ~seen, lane] = np.nan
    return AntennaPlots(
        time_s=times,
        row=np.arange(1, m + 1),
        target=np.zeros(m, np.int64),
        truth_m=flown.position_m,
        truth_velocity_mps=flown.velocity_mps,
        site=site,
        range_m=measured[0],
        bicone_elevation_rad=measured[1],
        bicone_azimuth_rad=measured[2],
    )


def preset(name: str, **defaults: Any) -> type[AntennaScenario]:
    """Return the same model with other defaults."""
    namespace: dict[str, Any] = {"__annotations__": {}, "__module__": __name__, "__doc__": AntennaScenario.__doc__}
    for field, value in defaults.items():
        info = AntennaScenario.model_fields[field]
        namespace[field] = FieldInfo.merge_field_infos(info, default=value)
        namespace["__annotations__"][field] = AntennaScenario.__annotations__[field]
    made: type[AntennaScenario] = type(name, (AntennaScenario,), namespace)
    return made


def _legs(*legs: tuple[str, float, float]) -> tuple[NamedInterval, ...]:
    return tuple(NamedInterval(name=name, start_s=start, stop_s=stop) for name, start, stop in legs)


# Specification 9, A. Selected so that the paper's pictures are possible: agreement on it is no independent evidence.
AeroballisticParameters = preset(
    "AeroballisticParameters",
    east_m=25_000.0,
    north_m=331_000.0,
    up_m=31_000.0,
    velocity_north_mps=-1_850.0,
    velocity_up_mps=530.0,
    free_flight=True,
    duration_s=180.0,
    commands=tuple(
        Command(time_s=t, vertical_mps2=v, right_mps2=h)
        for t, v, h in (
            (110, 0, 0), (110.5, 100, -60), (115.5, 100, -60), (116, -110, 90), (119, -110, 90), (119.5, 90, -20),
            (127.5, 90, -20), (128, 0, 0),
        )
    ),
    legs=_legs(
        ("initial", 0, 10), ("ballistic", 10, 110), ("manoeuvre", 110, 127.5), ("settling", 127.5, 136),
        ("near-straight", 136, 180.001),
    ),
)  # fmt: skip

StraightParameters = preset(
    "StraightParameters",
    east_m=-15_000.0,
    north_m=80_000.0,
    up_m=10_000.0,
    velocity_east_mps=150.0,
    velocity_north_mps=-200.0,
    legs=_legs(("initial", 0, 20), ("steady", 20, 120.001)),
)

# Ours: an aircraft in horizontal turns of 3 g and a climb, with a gap, at radar-like rates.
ManoeuvringParameters = preset(
    "ManoeuvringParameters",
    east_m=20_000.0,
    north_m=60_000.0,
    up_m=6_000.0,
    velocity_east_mps=-120.0,
    velocity_north_mps=-200.0,
    duration_s=240.0,
    timing="irregular",
    rate_hz=1.0,
    antenna_elevation_deg=15.0,
    antenna_up_m=12.0,
    sigma_range_m=10.0,
    gaps=(Gap(start_s=150, stop_s=165),),
    commands=tuple(
        Command(time_s=t, vertical_mps2=v, right_mps2=h, along_mps2=a)
        for t, v, h, a in (
            (60, 0, 0, 0), (61, 0, 30, 0), (80, 0, 30, 0), (81, 0, 0, 0), (110, 0, 0, 0), (111, 5, 0, 2),
            (120, 5, 0, 2), (121, 0, 0, 0), (180, 0, 0, 0), (181, -3, -20, 0), (200, -3, -20, 0), (201, 0, 0, 0),
        )
    ),
    legs=_legs(("straight", 10, 60), ("turn", 60, 81), ("climb", 81, 121), ("gap", 150, 175), ("weave", 180, 201)),
)  # fmt: skip


class RandomManoeuvres(Parameters):
    """A trajectory of the random family, its rate and its accuracies."""

    number: int = parameter(0, title="Trajectory", group="targets", ge=0, le=1_000_000)
    """Each number is another random trajectory; nobody selected them."""
    rate_hz: float = parameter(20.0, title="Rate", unit="Hz", group="timing", ge=0.1, le=100)
    """Plots in a second."""
    sigma_range_m: float = parameter(2.5, title="Range error", unit="m", symbol="σ_r", group="reception", gt=0, le=1e4)
    """Standard deviation; the site tells it to the algorithms."""
    sigma_bicone_elevation_deg: float = parameter(
        0.1, title="Bicone elevation error", unit="°", symbol="σ_ε", group="reception", gt=0, le=5
    )
    """Standard deviation; the site tells it to the algorithms."""
    sigma_bicone_azimuth_deg: float = parameter(
        0.1, title="Bicone azimuth error", unit="°", symbol="σ_α", group="reception", gt=0, le=5
    )
    """Standard deviation; the site tells it to the algorithms."""
    detection_probability: float = parameter(
        1.0, title="Detection probability", unit="1", group="reception", ge=0, le=1
    )
    """Share of instants with a plot."""


@lru_cache(maxsize=64)
def random_scenario(parameters: RandomManoeuvres) -> AntennaScenario:
    """Return the scenario that flies the chosen trajectory; its legs begin when the velocity is known."""
    flight = random_flight(parameters.number)
    stop = flight.end_s + AFTER_S
    return AntennaScenario(
        east_m=flight.east_m, north_m=flight.north_m, up_m=UP_M, velocity_north_mps=VELOCITY_NORTH_MPS,
        velocity_up_mps=VELOCITY_UP_MPS, free_flight=True, commands=flight.commands, duration_s=stop,
        antenna_elevation_deg=ANTENNA_ELEVATION_DEG, rate_hz=parameters.rate_hz,
        sigma_range_m=parameters.sigma_range_m, sigma_bicone_elevation_deg=parameters.sigma_bicone_elevation_deg,
        sigma_bicone_azimuth_deg=parameters.sigma_bicone_azimuth_deg,
        detection_probability=parameters.detection_probability,
        legs=_legs(
            ("ballistic", 10, FIRST_S), ("manoeuvre", FIRST_S, flight.end_s),
            ("settling", flight.end_s, flight.end_s + 8.5), ("later", flight.end_s + 8.5, stop + 0.001),
        ),
    )  # fmt: skip


def simulate_random(parameters: RandomManoeuvres, trials: tuple[int, ...], seed: int) -> AntennaPlots:
    """Simulate antenna plots of one trajectory of the random family."""
    return simulate(random_scenario(parameters), trials, seed)


def legs_of_random(parameters: RandomManoeuvres) -> tuple[Leg, ...]:
    """Return the stages of the trajectory."""
    return legs_of(random_scenario(parameters))


SCENARIOS = (
    Scenario(
        name="aeroballistic",
        title="Aeroballistic object",
        summary="Ballistic arc, a manoeuvre of 15 g, free flight again; 20 plots a second. A reconstruction: the paper "
        "gives no trajectory, and this one was selected.",
        family="multiple_model",
        kind="antenna_plots",
        parameters=AeroballisticParameters,
        simulate=simulate,
        legs=legs_of,
        references=(Reference("trudymai2023", "figs. 1-7"),),
    ),
    Scenario(
        name="straight_flight",
        title="Straight flight",
        summary="Constant velocity, 20 plots a second: where the quiet constant-velocity model takes over.",
        family="multiple_model",
        kind="antenna_plots",
        parameters=StraightParameters,
        simulate=simulate,
        legs=legs_of,
        references=(Reference("trudymai2023", "section 4"),),
    ),
    Scenario(
        name="manoeuvring_aircraft",
        title="Manoeuvring aircraft",
        summary="Turns of 3 g, a climb and a gap of 15 s; irregular plots, one a second on average.",
        family="multiple_model",
        kind="antenna_plots",
        parameters=ManoeuvringParameters,
        simulate=simulate,
        legs=legs_of,
    ),
    Scenario(
        name="random_manoeuvres",
        title="Random manoeuvres",
        summary="A dive at 1.8 km/s with two to four random commands of up to 14 g; each number is another trajectory, "
        "and nobody selected them.",
        family="multiple_model",
        kind="antenna_plots",
        parameters=RandomManoeuvres,
        simulate=simulate_random,
        legs=legs_of_random,
    ),
)
