"""Parameters of the identification algorithms, each declared once."""

from __future__ import annotations

from typing import Literal

from algorithms.spec import Parameters, parameter
from algorithms.toolbox.association.exact import EXACT_COLUMNS, LARGEST_EXACT

PointConversion = Literal["lin", "paper", "paper_literal", "dcm", "ucm", "mucm"]
PlotConversion = Literal["lin", "paper", "paper_literal", "dcm", "ucm", "mucm", "polar"]
TrackConversion = Literal["lin", "paper", "paper_literal", "dcm", "ucm", "mucm", "ducm", "ekf", "polar"]

_CONVERSIONS = {
    "lin": "plain point, covariance of first order",
    "paper": "the paper's correction with its misprint mended",
    "paper_literal": "the paper's correction as printed; only shows what the misprint does",
    "dcm": "debiased, given the truth",
    "ucm": "unbiased given the truth, covariance given the measurement",
    "mucm": "exact mean and covariance given the measurement",
}
PLOT_CONVERSIONS = _CONVERSIONS | {"polar": "none: the exact likelihood in range and azimuth"}
TRACK_CONVERSIONS = _CONVERSIONS | {
    "ducm": "unbiased given the truth, covariance from the track's prediction",
    "ekf": "none: range and azimuth linearised at the track's prediction",
    "polar": "none: straight flights fitted to ranges and azimuths",
}


class RadarParameters(Parameters):
    """What the plots are worth, and which belong to one look."""

    sigma_range_m: float | None = parameter(
        None, title="Range error", unit="m", symbol="σ_r", gt=0, le=100_000, group="measurement"
    )
    """Standard deviation of every radar's range. Empty = each radar's own value in the site."""
    sigma_azimuth_deg: float | None = parameter(
        None, title="Azimuth error", unit="°", symbol="σ_β", gt=0, le=180, group="measurement"
    )
    """Standard deviation of every radar's azimuth. Empty = each radar's own value in the site."""
    frame_s: float | None = parameter(
        None, title="Length of a look", unit="s", gt=0, le=86_400, group="measurement", advanced=True
    )
    """Plots of all radars within so long are compared with each other. Empty = by scan number, else by gaps in time."""
    alpha: float = parameter(0.01, title="Tail of the gate", unit="1", symbol="α", ge=1e-6, le=0.5, group="association")
    """Share of true pairs that the threshold rejects."""


class TwoRadarParameters(RadarParameters):
    """Which two of the radars."""

    first_radar: str = parameter("", title="First radar", group="measurement", advanced=True, max_length=80)
    """Name of the radar that is compared with the second one. Empty = the first of the site."""
    second_radar: str = parameter("", title="Second radar", group="measurement", advanced=True, max_length=80)
    """Name of the other radar. Empty = the next one of the site."""


class InstantParameters(Parameters):
    """Plots that were not measured at one instant."""

    extrapolate: bool = parameter(True, title="Bring plots to one instant", group="measurement", advanced=True)
    """Plots of one look that were not measured at one instant are moved to its middle, each by the velocity that the
    track of its own radar tells."""


class PairParameters(InstantParameters, TwoRadarParameters):
    """Plots of two radars."""

    conversion: PlotConversion = parameter("mucm", title="Conversion", group="measurement", choices=PLOT_CONVERSIONS)
    """How a plot becomes a point with a covariance."""
    reading: Literal["A", "B"] = parameter(
        "A",
        title="Who looks for a partner",
        group="association",
        choices={"A": "plots of the first radar", "B": "plots of the second radar"},
    )
    """Whose plots are counted as correct, wrong or undecided."""


class DetectionParameters(Parameters):
    """What may be missing and what may be too many."""

    p_min: float = parameter(
        0.95, title="Least probability", unit="1", symbol="p_min", ge=0.5, le=0.9999, group="association"
    )
    """A pair of the most likely matching below it is left undecided."""
    decision: Literal["posterior", "most_likely"] = parameter(
        "posterior",
        title="Decision",
        group="association",
        choices={
            "posterior": "pairs that are probable enough, else undecided",
            "most_likely": "every pair of the most likely matching",
        },
    )
    """What is accepted of the most likely matching."""
    detection_probability: float = parameter(
        1.0, title="Detection probability", unit="1", symbol="p_d", ge=0.01, le=1, group="association"
    )
    """Of every radar. With 1 and no false plots as many pairs as can be are made."""
    clutter_per_radar: float = parameter(0.0, title="False plots", unit="1", ge=0, le=10_000, group="association")
    """Mean number of a radar's plots in the region that come from no target, at each look."""
    region_area_m2: float = parameter(4e8, title="Area of the region", unit="m²", gt=0, le=1e14, group="association")
    """Where targets and false plots are expected."""
    target_count: float | None = parameter(
        None, title="Targets expected", unit="1", gt=0, le=10_000, group="association", advanced=True
    )
    """In the region. Empty = plots less false plots, over the detection probability."""


class ExactParameters(Parameters):
    """How far probabilities are sums over all matchings."""

    exact_plots: int = parameter(
        EXACT_COLUMNS,
        title="Plots summed exactly",
        unit="1",
        ge=1,
        le=LARGEST_EXACT,
        group="association",
        advanced=True,
    )
    """Up to so many plots (or tracks) on the shorter side probabilities are sums over all matchings; twice the time for
    one more. Beyond, groups that no gate joins are summed by themselves, and larger ones over their most likely
    matchings."""


class ManyRadarParameters(DetectionParameters, InstantParameters, RadarParameters):
    """Two radars and more."""

    conversion: PointConversion = parameter("mucm", title="Conversion", group="measurement", choices=_CONVERSIONS)
    """How a plot becomes a point with a covariance."""
    gate_tail: float = parameter(
        1e-4, title="Tail of the pairs' gate", unit="1", ge=1e-12, le=0.5, group="association", advanced=True
    )
    """Plots of which a pair lies outside this gate are not tried as one target."""
    most_candidates: int = parameter(
        20_000, title="Most candidates", unit="1", ge=1, le=1_000_000, group="association", advanced=True
    )
    """Sets of plots up to which the best choice is found exactly; beyond, radar by radar."""


class TrackParameters(ExactParameters, TwoRadarParameters):
    """Tracks of two radars."""

    conversion: TrackConversion = parameter("mucm", title="Conversion", group="measurement", choices=TRACK_CONVERSIONS)
    """How a plot becomes a point with a covariance."""
    acceleration_density_m2ps3: float = parameter(
        0.0, title="Manoeuvres", unit="m²/s³", symbol="q", ge=0, le=1e6, group="motion"
    )
    """Density of the white acceleration that the tracks allow for."""
    cross_covariance: bool = parameter(False, title="Cross-covariance", group="motion")
    """Whether the tracks' common manoeuvres are allowed for when they are compared."""
    decision: Literal["threshold", "posterior", "most_likely"] = parameter(
        "threshold",
        title="Decision",
        group="association",
        choices={
            "threshold": "the only track inside the gate",
            "posterior": "pairs that are probable enough, else undecided",
            "most_likely": "every pair of the most likely matching",
        },
    )
    """What makes two tracks one target."""
    p_min: float = parameter(
        0.95, title="Least probability", unit="1", symbol="p_min", ge=0.5, le=0.9999, group="association"
    )
    """A pair of the most likely matching below it is left undecided."""
    max_speed_mps: float = parameter(
        1000.0, title="Largest speed", unit="m/s", gt=0, le=20_000, group="motion", advanced=True
    )
    """Where the recording names no targets, plots of one radar are joined to tracks below this speed."""
