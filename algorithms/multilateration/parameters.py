"""Parameters that the multilateration algorithms share, each declared once."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from algorithms.spec import Parameters, parameter

SIGMA_TOA_NS = 10.0
SIGMA_ALTITUDE_M = 100.0

# A fix whose range residuals (rms) exceed this many times c sigma_toa is taken for a wrong branch or a wrong
# reception: 60 m at 90 ns, which keeps all but a few per thousand of real Mode S marks.
RESIDUAL_GATE_IN_SIGMA = 2.25

EARTHS = {
    "sphere": "sphere; 6 371 km in the article's profile, else the origin's local radius",
    "wgs84": "WGS-84 ellipsoid; needs the site's origin",
}
PROCESS_NOISES = {
    "paper": "only the acceleration is disturbed",
    "pwc": "jerk constant between marks",
    "white": "white jerk: depends on elapsed time only",
}
UPDATES = {
    "ekf": "linearised at the prediction (extended Kalman filter)",
    "iekf": "linearised again at its own solution (iterated)",
    "ukf": "over 19 points (unscented)",
    "ckf": "over 18 points (cubature)",
}
SMOOTHINGS = {
    "none": "estimate after each mark, from the marks up to it",
    "fixed_interval": "estimate from all marks of the track, for work after the flight",
}
Bounded = Annotated[float, Field(ge=-1e9, le=1e9)]


class Start(Parameters):
    """Where a filter starts: from the data, from a given state, or around the truth of a scenario."""

    mode: Literal["auto", "given", "truth"] = "auto"
    """auto = a one-mark fix, or several marks together; given = `state` with `covariance` or `sd`; truth = drawn around
    the truth (scenarios)."""
    state: tuple[Bounded, ...] | None = None
    """Nine components in the order x vx ax y vy ay z vz az (m, m/s, m/s2)."""
    covariance: tuple[tuple[Bounded, ...], ...] | None = None
    """Nine by nine, symmetric positive definite."""
    sd: tuple[Annotated[float, Field(gt=0, le=1e9)], ...] | None = None
    """Standard deviations: nine, or three (position, velocity, acceleration) for all axes."""

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.mode == "given":
            if self.state is None or len(self.state) != 9:
                raise ValueError("mode 'given' needs `state` with nine components x vx ax y vy ay z vz az")
            if (self.covariance is None) == (self.sd is None):
                raise ValueError("mode 'given' needs either `covariance` (9 x 9) or `sd`, not both")
        if self.mode == "truth" and self.sd is None:
            raise ValueError("mode 'truth' needs `sd`: nine standard deviations, or three for all axes")
        if self.sd is not None and len(self.sd) not in (3, 9):
            raise ValueError(f"`sd` has {len(self.sd)} values; give nine, or three for all axes")
        if self.covariance is not None and (len(self.covariance) != 9 or any(len(r) != 9 for r in self.covariance)):
            raise ValueError("`covariance` must be nine rows of nine values")
        return self


class MarkParameters(Parameters):
    """What describes the measurement of a mark."""

    sigma_toa_ns: float | None = parameter(
        None,
        title="Time-of-arrival error",
        unit="ns",
        symbol="σ_n",
        gt=0,
        le=1e6,
        from_site="sigma_toa_ns",
        fallback=SIGMA_TOA_NS,
    )
    """Standard deviation of one time of arrival. Empty = the station's, then the site's value."""
    earth: Literal["sphere", "wgs84"] | None = parameter(
        None,
        title="Earth",
        group="measurement",
        advanced=True,
        choices=EARTHS,
    )
    """Shape of the Earth under the altitude. Empty = WGS-84 (the article's profile: sphere)."""
    residual_gate_m: float | None = parameter(
        None,
        title="Residual gate",
        unit="m",
        group="association",
        advanced=True,
        gt=0,
        le=1e6,
    )
    """Largest rms range residual of an accepted one-mark fix. Empty = 2.25 c σ_n (61 m at 90 ns)."""


class AltitudeParameters(MarkParameters):
    """The same with the altitude as an observation."""

    sigma_altitude_m: float | None = parameter(
        None,
        title="Altitude error",
        unit="m",
        symbol="σ_h",
        gt=0,
        le=1e5,
        from_site="sigma_altitude_m",
        fallback=SIGMA_ALTITUDE_M,
    )
    """Standard deviation of the altitude observation. Pressure altitude differs from the geometric height by
    50-300 m; the reader of real recordings therefore proposes 125 m. Empty = the site's value."""


class EmitterAltitude(Parameters):
    """Altitude of emitters of a type."""

    emitter_type: str = parameter(title="Type", group="measurement", min_length=1, max_length=80)
    """As in the recording's column `emitter_type`."""
    altitude_m: float = parameter(title="Altitude", unit="m", group="measurement", ge=-1e3, le=4e4)
    """Where emitters of this type usually are."""
    sigma_m: float = parameter(title="Its error", unit="m", group="measurement", gt=0, le=1e5)
    """Standard deviation of that."""


class MissingAltitudeParameters(Parameters):
    """What stands in for an altitude where none is decoded."""

    missing_altitude: Literal["unused", "held", "type", "class"] = parameter(
        "unused",
        title="Where no altitude is decoded",
        group="measurement",
        choices={
            "unused": "the mark has none",
            "held": "the last decoded one, less certain with every second",
            "type": "the last decoded one, or that of the emitter's type",
            "class": "the last decoded one, that of the type, or the assumed altitude",
        },
    )
    """Of several the most certain one is taken."""
    emitter_altitudes: tuple[EmitterAltitude, ...] = parameter(
        (), title="Altitudes of emitter types", group="measurement", advanced=True, max_length=100
    )
    """What is known of emitters by their type alone (ship, glider, airliner)."""
    held_altitude_growth_mps: float = parameter(
        3.0, title="Climb while nothing is decoded", unit="m/s", group="measurement", advanced=True, ge=0, le=1e3
    )
    """Standard deviation of climb and descent, by which an altitude held grows uncertain."""
    missing_altitude_time_s: float = parameter(
        30.0, title="Time of a stand-in", unit="s", group="measurement", advanced=True, ge=0, le=1e6
    )
    """Altitudes that were not decoded have a common error: those within this time weigh together as one. 0 = each
    counts as if its error were its own."""


class StartParameters(MarkParameters):
    """What describes where a track starts."""

    emitters: Literal["given", "separate"] = parameter(
        "given",
        title="Marks without an address",
        group="association",
        choices={
            "given": "all are of one emitter",
            "separate": "emitters are told apart by where their marks can come from",
        },
    )
    """Whether a recording may hold several emitters whose marks do not say whose they are."""
    start: Start = parameter(Start(), title="Start", group="start", advanced=True)
    """Where the filter starts."""
    start_marks: int = parameter(
        30, title="Marks for a start together", unit="1", group="start", advanced=True, ge=0, le=200
    )
    """How many marks, none of which can start a track, are kept to start one together. 0 = never (the article's
    profile: never)."""
    start_window_s: float = parameter(
        60.0, title="Window for a start together", unit="s", group="start", advanced=True, gt=0, le=600
    )
    """How old a mark may be that helps to start a track; the flight must be straight so long."""
    start_altitude_m: float = parameter(
        6000.0, title="Assumed altitude", unit="m", group="start", advanced=True, ge=-1e3, le=4e4
    )
    """Altitude of the class of emitters, for a start together where no altitude is decoded."""
    start_altitude_sd_m: float = parameter(
        3500.0, title="Error of the assumed altitude", unit="m", group="start", advanced=True, gt=0, le=1e5
    )
    """Its standard deviation: 3500 m = anywhere from the ground to 12 km."""


class FilterParameters(StartParameters):
    """What describes a range-difference filter."""

    profile: Literal["article", "robust"] = parameter(
        "robust",
        title="Profile",
        group="motion",
        choices={
            "robust": "white jerk, WGS-84, emission time, noise scaled on surprise, loss and restart",
            "article": "as printed: paper's process noise, sphere, gate time, no outlier rule",
        },
    )
    """Which set of rules: `article` reproduces the paper's tables, `robust` is for recordings."""
    sigma_jerk_mps3: float = parameter(
        0.1,
        title="Jerk",
        unit="m/s³",
        symbol="σ_ξ",
        group="motion",
        gt=0,
        le=1e4,
    )
    """Standard deviation of the jerk that disturbs the motion."""
    process_noise: Literal["paper", "pwc", "white"] | None = parameter(
        None,
        title="Process noise",
        group="motion",
        advanced=True,
        choices=PROCESS_NOISES,
    )
    """Form of the process noise. Empty = white (the article's profile: paper)."""
    smoothing: Literal["none", "fixed_interval"] = parameter(
        "none",
        title="Smoothing",
        group="motion",
        choices=SMOOTHINGS,
    )
    """Whether the whole track is smoothed afterwards (Rauch-Tung-Striebel)."""


class FilterWithAltitudeParameters(MissingAltitudeParameters, FilterParameters, AltitudeParameters):
    """A range-difference filter with altitude."""


class UpdateParameters(Parameters):
    """How a mark enters the estimate."""

    update: Literal["ekf", "iekf", "ukf", "ckf"] = parameter(
        "ekf",
        title="Update",
        group="measurement",
        advanced=True,
        choices=UPDATES,
    )
    """How a mark enters the estimate. The others are for comparison: with an altitude all give the same."""
    printed: Literal["corrected", "sign", "gradient", "variance"] = parameter(
        "corrected",
        title="Formulas",
        group="measurement",
        advanced=True,
        choices={
            "corrected": "as they must be",
            "sign": "(19) as printed: the correction is subtracted",
            "gradient": "(26) as printed: z in place of R + z in the altitude's gradient",
            "variance": "(13) as printed: the altitude has the variance of the times of arrival",
        },
    )
    """Three misprints of the article that matter, to see what they do; the first two with the update `ekf` only."""
