"""What can be said about simulated plots of separated radars: one model, whose presets add what is theirs."""

from __future__ import annotations

from algorithms.spec import Parameters, parameter


class RadarScenario(Parameters):
    """Radars, where target 1 is, and what is wrong with the second radar."""

    base_m: float = parameter(30_000.0, title="Base", unit="m", symbol="B", group="stations", ge=0, le=1e6)
    """Distance of the second radar from the first."""
    base_azimuth_deg: float = parameter(90.0, title="Base azimuth", unit="°", group="stations", ge=-360, le=360)
    """Direction of the second radar from the first, clockwise from north; 90 is east, 0 in the paper's counting."""
    sigma_range_m: float = parameter(100.0, title="Range error", unit="m", symbol="σ_r", group="stations", gt=0, le=1e4)
    """Standard deviation of a range."""
    sigma_azimuth_deg: float = parameter(
        1.0, title="Azimuth error", unit="°", symbol="σ_β", group="stations", gt=0, le=28
    )
    """Standard deviation of an azimuth."""
    second_sigma_range_m: float | None = parameter(
        None, title="Range error of the second radar", unit="m", group="stations", gt=0, le=1e4
    )
    """Where it differs from that of the others."""
    second_sigma_azimuth_deg: float | None = parameter(
        None, title="Azimuth error of the second radar", unit="°", group="stations", gt=0, le=28
    )
    """Where it differs from that of the others."""
    target_range_m: float = parameter(150_000.0, title="Range of target 1", unit="m", group="targets", gt=0, le=1e6)
    """From the first radar."""
    target_azimuth_deg: float = parameter(45.0, title="Azimuth of target 1", unit="°", group="targets", ge=-360, le=360)
    """From the first radar, clockwise from north."""
    speed_mps: float = parameter(0.0, title="Speed", unit="m/s", group="targets", ge=0, le=3000)
    """Of all targets; matters where the second radar's clock is wrong, and between scans."""
    course_deg: float = parameter(45.0, title="Course", unit="°", group="targets", ge=-360, le=360)
    """Of all targets, clockwise from north."""
    height_m: float = parameter(0.0, title="Height that nobody knows", unit="m", group="targets", ge=0, le=30_000)
    """The radars measure slant ranges, and the algorithms take them for ground ranges."""
    detection_probability: float = parameter(
        1.0, title="Detection probability", unit="1", symbol="p_d", group="reception", gt=0, le=1
    )
    """That a radar has a plot of a target at a look."""
    false_plots: int = parameter(0, title="False plots", unit="1", group="reception", ge=0, le=200)
    """Number of a radar's plots that come from no target, at each look, anywhere in the region."""
    region_side_m: float = parameter(20_000.0, title="Side of the region", unit="m", group="reception", gt=0, le=1e6)
    """Square around target 1 in which false plots lie."""
    azimuth_bias_deg: float = parameter(
        0.0, title="Azimuth offset of the second radar", unit="°", group="disturbances", ge=-180, le=180
    )
    """Nobody tells the algorithms."""
    site_error_east_m: float = parameter(
        0.0, title="Site error of the second radar, east", unit="m", group="disturbances", ge=-1e5, le=1e5
    )
    """By how much its place in the site is too far east."""
    site_error_north_m: float = parameter(
        0.0, title="Site error of the second radar, north", unit="m", group="disturbances", ge=-1e5, le=1e5
    )
    """By how much its place in the site is too far north."""
    time_offset_s: float = parameter(
        0.0, title="Clock offset of the second radar", unit="s", group="disturbances", ge=-1000, le=1000
    )
    """By how much later it looks than it says."""


class TwoTargetsParameters(RadarScenario):
    """Two targets at one instant."""

    offset_along_m: float = parameter(
        1_060.0, title="Target 2 farther by", unit="m", symbol="dr", group="targets", ge=-1e5, le=1e5
    )
    """Along the first radar's line of sight to target 1."""
    offset_across_m: float = parameter(
        0.0, title="Target 2 to the left by", unit="m", symbol="dc", group="targets", ge=-1e5, le=1e5
    )
    """Across that line."""


class ClusterParameters(RadarScenario):
    """Targets at random in a square, anew at each look."""

    radars: int = parameter(2, title="Radars", unit="1", group="stations", ge=2, le=4)
    """The third and fourth stand on the base turned by 60 and 120 degrees."""
    targets: int = parameter(8, title="Targets", unit="1", group="targets", ge=1, le=50)
    """In the square around the place of target 1."""
    looks: int = parameter(20, title="Looks", unit="1", group="timing", ge=1, le=500)
    """Each with other places of the targets, the same in all trials."""
    period_s: float = parameter(10.0, title="Period", unit="s", group="timing", gt=0, le=1000)
    """Between looks."""
    placement_seed: int = parameter(1, title="Seed of the places", group="targets", advanced=True, ge=0, le=2**32 - 1)
    """Another seed gives other places."""


class TracksParameters(RadarScenario):
    """Two targets side by side, tracked by two radars."""

    offset_along_m: float = parameter(
        600.0, title="Target 2 farther by", unit="m", symbol="dr", group="targets", ge=-1e5, le=1e5
    )
    """Along the first radar's line of sight to target 1, at the end."""
    offset_across_m: float = parameter(
        0.0, title="Target 2 to the left by", unit="m", symbol="dc", group="targets", ge=-1e5, le=1e5
    )
    """Across that line."""
    speed_mps: float = parameter(150.0 * 2**0.5, title="Speed", unit="m/s", group="targets", ge=0, le=3000)
    """Of both targets."""
    course_deg: float = parameter(315.0, title="Course", unit="°", group="targets", ge=-360, le=360)
    """Of both targets, clockwise from north."""
    scans: int = parameter(10, title="Scans", unit="1", group="timing", ge=3, le=500)
    """Of both radars at the same instants; the last one finds target 1 at its place."""
    period_s: float = parameter(10.0, title="Period", unit="s", symbol="T", group="timing", gt=0, le=1000)
    """Between scans."""
    acceleration_density_m2ps3: float = parameter(
        0.0, title="Manoeuvres", unit="m²/s³", symbol="q", group="targets", ge=0, le=1e4
    )
    """Density of a white acceleration by which each target leaves its line, in each trial another way. The true path
    stays the line."""


class TurningParameters(RadarScenario):
    """Radars that turn by themselves, and targets on straight lines."""

    radars: int = parameter(2, title="Radars", unit="1", group="stations", ge=2, le=4)
    """The third and fourth stand on the base turned by 60 and 120 degrees."""
    rotation_s: float = parameter(10.0, title="Turn of the first radar", unit="s", group="timing", ge=0.1, le=1000)
    """How long a turn of its antenna takes; it begins anywhere."""
    rotation_step_s: float = parameter(
        1.3, title="Further radars turn slower by", unit="s", group="timing", ge=0, le=1000
    )
    """Each than the one before it; with 0 they keep their distance in time."""
    looks: int = parameter(20, title="Turns", unit="1", group="timing", ge=4, le=500)
    """Of the first radar; one of them is one look."""
    targets: int = parameter(6, title="Targets", unit="1", group="targets", ge=1, le=50)
    """In the middle of the time at random in the square around the place of target 1."""
    speed_mps: float = parameter(200.0, title="Speed", unit="m/s", group="targets", ge=0, le=3000)
    """Of all targets; each has a course of its own."""
    target_range_m: float = parameter(60_000.0, title="Range of target 1", unit="m", group="targets", gt=0, le=1e6)
    """From the first radar: the middle of the square."""
    sigma_azimuth_deg: float = parameter(
        0.2, title="Azimuth error", unit="°", symbol="σ_β", group="stations", gt=0, le=28
    )
    """Standard deviation of an azimuth."""
    region_side_m: float = parameter(40_000.0, title="Side of the region", unit="m", group="reception", gt=0, le=1e6)
    """Square in which the targets are, and false plots lie."""
    placement_seed: int = parameter(1, title="Seed of the places", group="targets", advanced=True, ge=0, le=2**32 - 1)
    """Another seed gives other places, courses and phases."""
