"""Parameters that the multiple-model algorithms share, each declared once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from algorithms.errors import ParameterError
from algorithms.multiple_model.polygon import fault_of
from algorithms.spec import Parameters, parameter

SIGMA_RANGE_M = 2.5
SIGMA_ANGLE_DEG = 0.1
SIGMA_AZIMUTH_DEG = 0.5
SIGMA_PLAN_M = 20.0
SIGMA_HEIGHT_M = 50.0

WAYS: dict[str, str] = {
    "converted": "as a position, with the covariance at the measurement (the paper)",
    "converted_at_prediction": "as a position, with the covariance at the prediction",
    "ekf": "in its own coordinates, linearised at the prediction",
    "ukf": "in its own coordinates, by six sigma points of the position",
}
NOISE_FORMS: dict[str, str] = {
    "step": "one random number for each measurement (the paper); above the long interval as `rate`",
    "rate": "white noise over the elapsed time",
    "substeps": "as `step`; above the long interval in steps of the base interval",
}
RULES: dict[str, str] = {
    "moment": "all hypotheses by their probabilities",
    "max": "the most probable hypothesis",
    "combined": "the unchanged model alone where it is the most probable, else all",
    "modified": "the unchanged model alone where it is the most probable, else it and the best other one",
    "combined_sum": "as combined, but it must outweigh all others together",
    "modified_pair": "as modified, with the probability of the pair only",
}
ANSWERS: dict[str, str] = {
    "max": "of the most probable model (the paper)",
    "moment": "mean of all models, which never jumps",
}

Sd = Annotated[float, Field(gt=0, le=1e6)]
Probability = Annotated[float, Field(ge=0, le=1)]
Place = Annotated[float, Field(ge=-1e7, le=1e7)]


class MeasurementParameters(Parameters):
    """How accurate measurements are, and how they enter."""

    sigma_range_m: float | None = parameter(
        None, title="Range error", unit="m", symbol="σ_r", from_site="sigma_range_m", fallback=SIGMA_RANGE_M,
        gt=0, le=1e5,
    )  # fmt: skip
    """Standard deviation; none = the site's."""
    sigma_bicone_elevation_deg: float | None = parameter(
        None, title="Bicone elevation error", unit="°", symbol="σ_ε", from_site="sigma_bicone_elevation_deg",
        fallback=SIGMA_ANGLE_DEG, gt=0, le=20,
    )  # fmt: skip
    """Of an antenna's plots; none = the site's."""
    sigma_bicone_azimuth_deg: float | None = parameter(
        None, title="Bicone azimuth error", unit="°", symbol="σ_α", from_site="sigma_bicone_azimuth_deg",
        fallback=SIGMA_ANGLE_DEG, gt=0, le=20,
    )  # fmt: skip
    """Of an antenna's plots; none = the site's."""
    sigma_azimuth_deg: float | None = parameter(
        None, title="Azimuth error", unit="°", symbol="σ_β", advanced=True, from_site="sigma_azimuth_deg",
        fallback=SIGMA_AZIMUTH_DEG, gt=0, le=20,
    )  # fmt: skip
    """Of a scanning radar's plots; none = the site's."""
    sigma_elevation_deg: float | None = parameter(
        None, title="Elevation error", unit="°", advanced=True, from_site="sigma_elevation_deg",
        fallback=SIGMA_AZIMUTH_DEG, gt=0, le=20,
    )  # fmt: skip
    """Of a scanning radar's plots; none = the site's."""
    sigma_east_m: float | None = parameter(
        None, title="Error east", unit="m", advanced=True, from_site="sigma_east_m", fallback=SIGMA_PLAN_M, gt=0, le=1e5
    )
    """Of plots given as east and north; none = the site's."""
    sigma_north_m: float | None = parameter(
        None, title="Error north", unit="m", advanced=True, from_site="sigma_north_m", fallback=SIGMA_PLAN_M,
        gt=0, le=1e5,
    )  # fmt: skip
    """Of plots given as east and north; none = the site's."""
    sigma_height_m: float = parameter(SIGMA_HEIGHT_M, title="Height error", unit="m", advanced=True, gt=0, le=1e5)
    """Of a height that a plot in the plane does not measure: of its decoded altitude, or of the assumed height."""
    assumed_height_m: float = parameter(0.0, title="Assumed height", unit="m", advanced=True, ge=-1e4, le=1e5)
    """Height in the local frame of plots in the plane without an altitude."""
    measurement: Literal["converted", "converted_at_prediction", "ekf", "ukf"] = parameter(
        "ekf",
        title="Measurement enters",
        group="measurement",
        choices=WAYS,
    )
    """In its own coordinates the thin direction of the error ellipsoid is not turned by the measurement's noise."""


class MotionParameters(MeasurementParameters):
    """What all filters of the family share beyond their models."""

    noise_form: Literal["step", "rate", "substeps"] = parameter(
        "rate",
        title="Process noise",
        group="motion",
        choices=NOISE_FORMS,
    )
    """Noise of a step means something else at each rate; noise of the rate form depends on the elapsed time only."""
    long_interval_s: float = parameter(
        5.0, title="Long interval", unit="s", group="motion", advanced=True, gt=0, le=1e5
    )
    """Above it noise is no longer that of one step; the decisions say so."""
    start_velocity_sd_mps: float = parameter(
        1000.0, title="Velocity at the start", unit="m/s", symbol="σ_v0", group="start", gt=0, le=1e4
    )
    """Standard deviation of the unknown velocity when a track starts."""
    start_acceleration_sd_mps2: float = parameter(
        30.0, title="Acceleration at the start", unit="m/s²", symbol="σ_a0", group="start", gt=0, le=1e3
    )
    """Standard deviation of the unknown acceleration when a track starts."""
    track_timeout_s: float = parameter(60.0, title="Longest gap", unit="s", group="association", gt=0, le=1e5)
    """A track without measurements for longer is closed, and a new one started."""
    association: Literal["auto", "all", "nearest"] = parameter(
        "auto",
        title="Plots of a scan",
        group="association",
        choices={
            "auto": "nearest where a scan holds several plots of one target, else all",
            "all": "every measurement is the target's",
            "nearest": "the plot nearest to the prediction, inside a gate",
        },
    )
    """Whose the measurements of a target are."""
    gate_probability: float = parameter(
        0.9999, title="Gate probability", unit="1", group="association", ge=0.5, le=0.999999
    )
    """Share of the target's own plots inside the gate; it is used where the nearest plot is chosen."""
    coasting_gate: float = parameter(
        2.0, title="Gate while coasting", unit="1", group="association", advanced=True, ge=1, le=10
    )
    """So many times as wide after 2.5 intervals without a plot."""


def check_rule(structure: str, merging: str) -> None:
    """Refuse a rule that needs a main hypothesis where there is none."""
    if structure == "gpb1" and merging not in ("moment", "max"):
        raise ParameterError(
            f"The merging rule {merging} needs a main hypothesis, and the structure gpb1 has none.",
            pointer="/merging",
            remedy="Choose moment or max, or the structure imm or gpb2.",
            code="merging_structure",
        )


class MergingParameters(MotionParameters):
    """How hypotheses are merged and which answer is given."""

    structure: Literal["gpb1", "imm", "gpb2"] = parameter(
        "imm",
        title="Structure",
        group="motion",
        choices={
            "gpb1": "one common state (MMA1)",
            "imm": "a state for each model, merged before the prediction (MMA2)",
            "gpb2": "a state for each pair of models, merged after the measurement (MMA3)",
        },
    )
    """How many hypotheses live through a step."""
    merging: Literal["moment", "max", "combined", "modified", "combined_sum", "modified_pair"] = parameter(
        "moment",
        title="Merging",
        group="motion",
        choices=RULES,
    )
    """How hypotheses become one."""
    output: Literal["max", "moment"] = parameter(
        "moment",
        title="Answer",
        group="output",
        choices=ANSWERS,
    )
    """It does not feed back."""

    @model_validator(mode="after")
    def _rule_fits(self) -> Self:
        check_rule(self.structure, self.merging)
        return self


class PaperParameters(MergingParameters):
    """The same with the paper's defaults: converted marks, noise of a step, combined merging, most probable model."""

    measurement: Literal["converted", "converted_at_prediction", "ekf", "ukf"] = parameter(
        "converted",
        title="Measurement enters",
        choices=WAYS,
    )
    """The paper converts marks to positions, with the covariance at the mark."""
    noise_form: Literal["step", "rate", "substeps"] = parameter(
        "step",
        title="Process noise",
        group="motion",
        choices=NOISE_FORMS,
    )
    """The paper has one random number for each mark; above the long interval the rate form is taken."""
    merging: Literal["moment", "max", "combined", "modified", "combined_sum", "modified_pair"] = parameter(
        "combined",
        title="Merging",
        group="motion",
        choices=RULES,
    )
    """The paper recommends its combined rule."""
    output: Literal["max", "moment"] = parameter(
        "max",
        title="Answer",
        group="output",
        choices=ANSWERS,
    )
    """The paper shows the most probable model."""


class PaperKalmanParameters(MotionParameters):
    """Parameters of the paper's Kalman filters with one model: nothing is merged."""

    measurement: Literal["converted", "converted_at_prediction", "ekf", "ukf"] = parameter(
        "converted",
        title="Measurement enters",
        choices=WAYS,
    )
    """The paper converts marks to positions, with the covariance at the mark."""
    noise_form: Literal["step", "rate", "substeps"] = parameter(
        "step",
        title="Process noise",
        group="motion",
        choices=NOISE_FORMS,
    )
    """The paper has one random number for each mark; above the long interval the rate form is taken."""


class ModelChoice(Parameters):
    """One motion model."""

    kind: Literal["cv", "ca", "ct", "gv", "gd"] = parameter(
        title="Kind",
        group="motion",
        choices={
            "cv": "constant velocity",
            "ca": "constant acceleration",
            "ct": "coordinated turn",
            "gv": "constant velocity but for gravity",
            "gd": "constant velocity but for gravity and drag",
        },
    )
    """What the target is thought to do."""
    sigma_mps2: float = parameter(title="Noise", unit="m/s²", symbol="σ_A", group="motion", ge=0, le=1000)
    """Of the step form at the base interval of the transition matrix; converted for the rate form."""


def check_polygons(regions: Sequence[Region]) -> None:
    """Refuse a region whose polygon is none, with its number and name."""
    for i, region in enumerate(regions):
        fault = fault_of(region.corners) if region.corners else ""
        if fault:
            name = f" {region.name!r}" if region.name else ""
            raise ParameterError(
                f"Region {i + 1}{name}: {fault}.",
                pointer=f"/regions/{i}/corners",
                remedy=(
                    "Give the corners in order around the region, make two regions of it, "
                    "or leave the corners out for everywhere."
                ),
                code="region_polygon",
            )


class Region(Parameters):
    """Where another transition matrix holds."""

    name: str = parameter("", title="Name", group="motion", max_length=80)
    """For you."""
    corners: tuple[tuple[Place, Place], ...] = parameter((), title="Corners", unit="m", group="motion", max_length=200)
    """East and north of a polygon's corners; none = everywhere."""
    lowest_up_m: float = parameter(-1e6, title="From height", unit="m", group="motion", ge=-1e6, le=1e6)
    """In the local frame."""
    highest_up_m: float = parameter(1e6, title="To height", unit="m", group="motion", ge=-1e6, le=1e6)
    """In the local frame."""
    transition: tuple[tuple[float, ...], ...] = parameter(
        title="Transition probabilities", group="motion", max_length=10, labels_from="models", row_sum=1
    )
    """Row = from, as the matrix that holds elsewhere."""

    @model_validator(mode="after")
    def _sound(self) -> Self:
        if self.highest_up_m <= self.lowest_up_m:
            raise ValueError("a region's highest_up_m must lie above its lowest_up_m")
        return self
