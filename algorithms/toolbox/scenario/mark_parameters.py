"""What can be said about a simulated recording of multilateration marks: one model, whose presets differ in defaults.

Numbers that an experiment varies stand at the top level, so that a sweep can name each of them.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import field_validator

from algorithms.site import Site
from algorithms.spec import Parameters, parameter
from algorithms.toolbox.scenario.targets import Target
from algorithms.toolbox.scenario.timing import Gap, Interrogator
from algorithms.toolbox.scenario.trajectory import Segment

_FARTHEST_M = 1e7
MOST_STATIONS = 32


class ScenarioStation(Parameters):
    """A receiver: its place as in a site, and what is wrong with its clock."""

    name: str = parameter(title="Name", group="stations", min_length=1, max_length=80)
    """Names the column of its times of arrival."""
    east_m: float | None = parameter(None, title="East", unit="m", group="stations", ge=-_FARTHEST_M, le=_FARTHEST_M)
    """In the local frame."""
    north_m: float | None = parameter(None, title="North", unit="m", group="stations", ge=-_FARTHEST_M, le=_FARTHEST_M)
    """In the local frame."""
    up_m: float | None = parameter(None, title="Up", unit="m", group="stations", ge=-1e6, le=1e6)
    """In the local frame."""
    latitude_deg: float | None = parameter(
        None, title="Latitude", unit="°", group="stations", advanced=True, ge=-90, le=90
    )
    """WGS-84, with longitude and height in place of east, north and up."""
    longitude_deg: float | None = parameter(
        None, title="Longitude", unit="°", group="stations", advanced=True, ge=-180, le=360
    )
    """WGS-84."""
    height_m: float | None = parameter(
        None, title="Height", unit="m", group="stations", advanced=True, ge=-10_000, le=100_000
    )
    """Above the ellipsoid."""
    sigma_toa_ns: float | None = parameter(
        None, title="Time-of-arrival error", unit="ns", symbol="σ_n", group="stations", advanced=True, gt=0, le=1e5
    )
    """Where it differs from that of the other stations."""
    clock_offset_ns: float = parameter(
        0.0, title="Known clock error", unit="ns", group="stations", advanced=True, ge=-1e9, le=1e9
    )
    """In the times of arrival and in the site, so that the algorithms subtract it."""
    clock_error_ns: float = parameter(
        0.0, title="Unknown clock error", unit="ns", group="stations", advanced=True, ge=-1e9, le=1e9
    )
    """In the times of arrival alone."""
    clock_drift_ns_s: float = parameter(
        0.0, title="Clock drift", unit="ns/s", group="stations", advanced=True, ge=-1e6, le=1e6
    )
    """By how much the unknown error grows in a second."""


class ScenarioOrigin(Parameters):
    """WGS-84 position of the local frame's zero."""

    latitude_deg: float = parameter(title="Latitude", unit="°", group="stations", ge=-90, le=90)
    """WGS-84."""
    longitude_deg: float = parameter(title="Longitude", unit="°", group="stations", ge=-180, le=360)
    """WGS-84."""
    height_m: float = parameter(0.0, title="Height", unit="m", group="stations", ge=-10_000, le=100_000)
    """Above the ellipsoid."""


class ReceptionInterval(Parameters):
    """How well the stations receive for some time."""

    start_s: float = parameter(0.0, title="From", unit="s", group="reception", ge=0, le=1e6)
    """First instant."""
    stop_s: float | None = parameter(None, title="To", unit="s", group="reception", ge=0, le=1e6)
    """First instant after it; none = until the end."""
    probabilities: tuple[float, ...] = parameter(title="Probabilities", unit="1", group="reception", max_length=32)
    """One for each station, in their order; the last interval that holds an instant counts."""


class NamedInterval(Parameters):
    """A leg, whose metrics are given apart, start_s <= t < stop_s."""

    name: str = parameter(title="Name", group="legs", min_length=1, max_length=80)
    """Stands in the column `segment` of the metrics."""
    start_s: float = parameter(title="From", unit="s", group="legs", ge=0, le=1e6)
    """First instant."""
    stop_s: float = parameter(title="To", unit="s", group="legs", gt=0, le=1e6)
    """First instant after it."""


# Specification 7.0: one central station and three at 10 km, azimuths 30, 150 and 270 degrees.
_NORTH_M = float(10_000 * 0.75**0.5)
FOUR_STATIONS = tuple(
    ScenarioStation(name=name, east_m=x, north_m=y, up_m=15.0)
    for name, x, y in (("1", 5_000.0, _NORTH_M), ("2", 5_000.0, -_NORTH_M), ("3", -10_000.0, 0.0), ("4", 0.0, 0.0))
)


class MarkScenario(Parameters):
    """Stations, targets, instants, receptions, altitudes, and what is wrong with each of them."""

    stations: tuple[ScenarioStation, ...] = parameter(
        FOUR_STATIONS, title="Stations", group="stations", min_length=2, max_length=MOST_STATIONS
    )
    """As in a site: in the local frame, or in WGS-84."""
    origin: ScenarioOrigin | None = parameter(None, title="Origin", group="stations", advanced=True)
    """WGS-84 position of the local frame's zero. With one the Earth is the ellipsoid, without one a sphere."""
    targets: tuple[Target, ...] = parameter(
        (Target(segments=(Segment(duration_s=600),)),), title="Targets", group="targets", min_length=1, max_length=100
    )
    """Each with a start and segments, or with a table of points."""
    timing: Literal["regular", "irregular", "interrogators"] = parameter(
        "regular",
        title="Marks come",
        group="timing",
        choices={
            "regular": "every period",
            "irregular": "after a least interval and an exponential remainder",
            "interrogators": "when ground interrogators ask, in bursts",
        },
    )
    """What makes a target send."""
    period_s: float = parameter(1.0, title="Period", unit="s", group="timing", ge=1e-6, le=1e5)
    """Between regular marks."""
    minimum_interval_s: float = parameter(0.4, title="Least interval", unit="s", group="timing", ge=0, le=1e5)
    """Between irregular marks."""
    mean_extra_interval_s: float = parameter(0.6, title="Mean remainder", unit="s", group="timing", ge=0, le=1e5)
    """Mean of what an irregular interval is longer than the least one."""
    interrogators: tuple[Interrogator, ...] = parameter(
        (Interrogator(),), title="Interrogators", group="timing", max_length=20
    )
    """Ground stations that make targets answer."""
    gaps: tuple[Gap, ...] = parameter((), title="Gaps", group="timing", max_length=100)
    """Intervals in which no target sends."""
    duration_s: float | None = parameter(None, title="Duration", unit="s", group="timing", gt=0, le=1e6)
    """Of the recording; none = until the last target's end."""
    timing_seed: int = parameter(0, title="Seed of the instants", group="timing", advanced=True, ge=0, le=2**32 - 1)
    """Instants are the same in all trials; another seed gives others."""
    gate_length_ms: float = parameter(0.0, title="Gate length", unit="ms", group="timing", ge=0, le=1000)
    """A mark leaves at random within so long after its gate opens; the site tells it to the algorithms."""
    emission_offset_ms: float = parameter(
        0.0, title="Emission offset", unit="ms", group="timing", advanced=True, ge=0, le=1000
    )
    """Every mark leaves later by so much; nobody tells the algorithms."""
    sigma_toa_ns: float = parameter(
        10.0, title="Time-of-arrival error", unit="ns", symbol="σ_n", group="reception", gt=0, le=1e5
    )
    """Standard deviation of one time of arrival."""
    reception_probability: float = parameter(
        1.0, title="Reception probability", unit="1", group="reception", ge=0, le=1
    )
    """Of every station; multiplies those of the intervals."""
    receptions: tuple[ReceptionInterval, ...] = parameter(
        (), title="Reception by time", group="reception", max_length=100
    )
    """How well each station receives in an interval; elsewhere it misses nothing."""
    outlier_share: float = parameter(0.0, title="Late receptions", unit="1", group="reception", ge=0, le=1)
    """Share of receptions that come late, as after a reflection."""
    outlier_least_ns: float = parameter(
        200.0, title="Least delay", unit="ns", group="reception", advanced=True, ge=0, le=1e9
    )
    """Of a late reception."""
    outlier_most_ns: float = parameter(
        20_000.0, title="Largest delay", unit="ns", group="reception", advanced=True, ge=0, le=1e9
    )
    """Of a late reception; delays are uniform between the two."""
    sigma_altitude_m: float = parameter(
        100.0, title="Altitude error", unit="m", symbol="σ_h", group="altitude", ge=0, le=1e5
    )
    """Standard deviation of the decoded altitude, white; also the filters' default, unless they are told another."""
    claimed_sigma_altitude_m: float | None = parameter(
        None, title="Altitude error told to filters", unit="m", group="altitude", gt=0, le=1e5
    )
    """Default of the filters' altitude error; none = the true one."""
    altitude_bias_sd_m: float = parameter(0.0, title="Altitude bias", unit="m", group="altitude", ge=0, le=1e5)
    """Standard deviation of a bias that is constant in a trial."""
    altitude_step_m: float = parameter(0.0, title="Altitude step", unit="m", group="altitude", ge=0, le=1e4)
    """Altitudes are rounded to its multiples: 30.48 and 7.62 are 100 ft and 25 ft, 0 is none."""
    decoding_probability: float = parameter(1.0, title="Decoding probability", unit="1", group="altitude", ge=0, le=1)
    """Share of marks with an altitude."""
    legs: tuple[NamedInterval, ...] = parameter((), title="Legs", group="legs", max_length=50)
    """Intervals whose metrics are given apart."""

    @field_validator("stations")
    @classmethod
    def _a_site(cls, stations: tuple[ScenarioStation, ...]) -> tuple[ScenarioStation, ...]:
        # The origin's part of the rules follows in `site_of`, when the origin is known.
        Site.model_validate({"stations": [_as_in_a_site(s) for s in stations], "origin": _ANYWHERE})
        return stations


# Stands for the origin while stations are checked: with it, local and WGS-84 positions may be mixed.
_ANYWHERE = {"latitude_deg": 0.0, "longitude_deg": 0.0}


def _as_in_a_site(station: ScenarioStation) -> dict[str, Any]:
    return station.model_dump(exclude={"clock_error_ns", "clock_drift_ns_s"}, exclude_none=True)


def site_of(parameters: MarkScenario) -> Site:
    """Return the site as the algorithms are told it."""
    claimed = parameters.claimed_sigma_altitude_m or parameters.sigma_altitude_m or None
    return Site.model_validate(
        {
            "origin": None if parameters.origin is None else parameters.origin.model_dump(),
            "stations": [_as_in_a_site(s) for s in parameters.stations],
            "sigma_toa_ns": parameters.sigma_toa_ns,
            "sigma_altitude_m": claimed,
            "gate_length_s": parameters.gate_length_ms / 1000 or None,
        }
    )
