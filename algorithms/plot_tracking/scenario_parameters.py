"""What can be said about simulated plots of one rotating radar: one model, whose presets differ in defaults."""

from __future__ import annotations

from typing import Literal

from algorithms.spec import Parameters, parameter
from algorithms.toolbox.scenario.mark_parameters import NamedInterval
from algorithms.toolbox.scenario.targets import Target
from algorithms.toolbox.scenario.timing import Gap
from algorithms.toolbox.scenario.trajectory import Segment


class RadarScans(Parameters):
    """One radar at the origin, when it looks, how well, and what it sees that is no target."""

    period_s: float = parameter(5.0, title="Antenna period", unit="s", symbol="T", group="timing", ge=0.1, le=3600)
    """All plots of a scan carry the instant of the scan."""
    duration_s: float = parameter(300.0, title="Duration", unit="s", group="timing", gt=0, le=1e5)
    """Of the recording; a target's plots end with its path."""
    gaps: tuple[Gap, ...] = parameter((), title="Gaps", group="timing", max_length=100)
    """Intervals in which the antenna stands still."""
    sigma_range_m: float = parameter(
        200.0, title="Range error", unit="m", symbol="σ_r", group="reception", gt=0, le=1e4
    )
    """Standard deviation; the site tells it to the algorithms."""
    sigma_azimuth_deg: float = parameter(
        8 / 60, title="Azimuth error", unit="°", symbol="σ_θ", group="reception", gt=0, le=28
    )
    """Standard deviation, 0.133 is 8 minutes of arc; the site tells it to the algorithms."""
    detection_probability: float = parameter(
        1.0, title="Detection probability", unit="1", symbol="p_d", group="reception", ge=0, le=1
    )
    """That a scan has a plot of a target."""
    false_plots: float = parameter(0.0, title="False plots", unit="1", group="reception", ge=0, le=5000)
    """Mean number in a scan of plots that come from no target: Poisson, uniform over the disc."""
    clutter_radius_m: float = parameter(
        150_000.0, title="Radius of the disc", unit="m", group="reception", gt=0, le=1e6
    )
    """Around the radar; false plots lie in it."""
    range_kind: Literal["ground", "slant"] = parameter(
        "ground",
        title="Range",
        group="reception",
        advanced=True,
        choices={"ground": "along the ground", "slant": "along the line of sight, as the site says"},
    )
    """What the radar measures of a target at its altitude."""
    transponders: Literal["none", "altitude", "address"] = parameter(
        "none",
        title="Transponders",
        group="reception",
        choices={
            "none": "plots carry no identity",
            "altitude": "plots of targets carry their altitude in steps of 25 ft",
            "address": "and their addresses",
        },
    )
    """What the plots of targets say beside their place."""
    legs: tuple[NamedInterval, ...] = parameter((), title="Legs", group="legs", max_length=50)
    """Intervals whose metrics are given apart."""


class AircraftScans(RadarScans):
    """Any number of targets, each with its own path."""

    targets: tuple[Target, ...] = parameter(
        (Target(segments=(Segment(duration_s=600),)),), title="Targets", group="targets", min_length=1, max_length=1000
    )
    """Each with a start and segments, or with a table of points."""


class CrossingScans(RadarScans):
    """Two targets whose paths cross north of the radar at half the time."""

    crossing_angle_deg: float = parameter(30.0, title="Crossing angle", unit="°", group="targets", ge=0, le=180)
    """Between the two courses, which lie evenly about east."""
    speed_mps: float = parameter(200.0, title="Speed", unit="m/s", group="targets", gt=0, le=3000)
    """Of both."""
    crossing_north_m: float = parameter(
        50_000.0, title="Crossing point, north", unit="m", group="targets", ge=1, le=1e6
    )
    """Both are there at the same instant."""


class ManyScans(RadarScans):
    """Aircraft all over a disc around the radar."""

    aircraft: int = parameter(100, title="Aircraft", group="targets", ge=1, le=500)
    """Straight flights and turns, spread evenly; the same in every trial."""
    disc_radius_m: float = parameter(200_000.0, title="Farthest start", unit="m", group="targets", ge=1e4, le=1e6)
    """How far from the radar they begin at most."""


class ParallelScans(RadarScans):
    """Two targets side by side on eastern courses."""

    distance_m: float = parameter(1000.0, title="Distance", unit="m", group="targets", ge=0, le=1e5)
    """Between the two, across their courses."""
    speed_mps: float = parameter(200.0, title="Speed", unit="m/s", group="targets", gt=0, le=3000)
    """Of both."""
