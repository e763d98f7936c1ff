"""Parameters of the trackers, each declared once."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from algorithms.spec import Parameters, parameter

CLASSES = {
    "airliner": "airliner, up to 350 m/s",
    "fast_jet": "fast jet, up to 1,000 m/s",
    "paper": "the paper's, up to 1,000 m/s",
    "helicopter": "helicopter, up to 120 m/s",
    "boat": "boat, up to 30 m/s",
}
"""Performance classes: largest speed, acceleration along and across the path."""
LIMITS: dict[str, tuple[float, float, float]] = {
    "airliner": (350.0, 4.0, 6.0),
    "fast_jet": (1000.0, 10.0, 80.0),
    "paper": (1000.0, 10.0, 15.0),
    "helicopter": (120.0, 4.0, 8.0),
    "boat": (30.0, 3.0, 5.0),
}


REQUIREMENTS = {
    "rms_horizontal_m": "required_rms_m",
    "tracked_share": "required_tracked_share",
    "switches": "allowed_switches",
    "false_tracks": "allowed_false_tracks",
}
"""What may be asked of a tracker, and the parameter that holds the threshold."""


class RadarAccuracy(Parameters):
    """What the plots are worth, and when they come."""

    sigma_range_m: float | None = parameter(
        None, title="Range error", unit="m", symbol="σ_r", gt=0, le=100_000, group="measurement"
    )
    """Standard deviation of every radar's range. Empty = each radar's own value in the site."""
    sigma_azimuth_deg: float | None = parameter(
        None, title="Azimuth error", unit="°", symbol="σ_θ", gt=0, le=28, group="measurement"
    )
    """Standard deviation of every radar's azimuth. Empty = each radar's own value in the site."""
    sigma_east_m: float | None = parameter(
        None, title="East error", unit="m", symbol="σ_x", gt=0, le=100_000, group="measurement", advanced=True
    )
    """Of plots that are given in east and north. Empty = each radar's own value in the site."""
    sigma_north_m: float | None = parameter(
        None, title="North error", unit="m", symbol="σ_y", gt=0, le=100_000, group="measurement", advanced=True
    )
    """Of plots that are given in east and north. Empty = each radar's own value in the site."""
    least_across_m: float = parameter(
        50.0, title="Least error across the ray", unit="m", ge=0, le=10_000, group="measurement", advanced=True
    )
    """Near the radar an azimuth loses its meaning: the error across the ray is never taken smaller."""
    period_s: float | None = parameter(
        None, title="Antenna period", unit="s", symbol="T", gt=0, le=3600, group="measurement", advanced=True
    )
    """Empty = the site's, else the median time between scans."""


class TrackerParameters(RadarAccuracy):
    """Speeds, and the life of a track."""

    performance: Literal["airliner", "fast_jet", "paper", "helicopter", "boat"] = parameter(
        "paper", title="Performance class", group="motion", choices=CLASSES
    )
    """What the targets can do: limits of speed and acceleration."""
    max_speed_mps: float | None = parameter(
        None, title="Largest speed", unit="m/s", symbol="V_max", gt=0, le=20_000, group="motion"
    )
    """Sets the size of the start gate. Empty = that of the performance class."""
    confirm_plots: int = parameter(4, title="Plots that confirm", unit="1", ge=3, le=20, group="start")
    """A track with so many plots is confirmed."""

    registration_m: float = parameter(
        0.0, title="Radars against each other", unit="m", ge=0, le=10_000, group="association", advanced=True
    )
    """Standard deviation of the places of several radars against each other, in east and in north: joins of their
    tracks allow for it."""

    required_rms_m: float | None = parameter(
        None, title="Required position error", unit="m", gt=0, le=1e6, group="output", advanced=True
    )
    """Rms error of each target in each segment; the table of requirements says which exceed it. Empty = not asked."""
    required_tracked_share: float | None = parameter(
        None, title="Required continuity", unit="1", gt=0, le=1, group="output", advanced=True
    )
    """Share of its scans in which each target has a track. Empty = not asked."""
    allowed_switches: int | None = parameter(
        None, title="Allowed switches", unit="1", ge=0, le=1000, group="output", advanced=True
    )
    """Changes of the track's number, of each target in each segment. Empty = not asked."""
    allowed_false_tracks: int | None = parameter(
        None, title="Allowed false tracks", unit="1", ge=0, le=100_000, group="output", advanced=True
    )
    """Confirmed tracks of no target, in the whole recording. Empty = not asked."""

    @property
    def limits(self) -> tuple[float, float, float]:
        """Largest speed in m/s, and accelerations along and across the path in m/s2."""
        speed, along, across = LIMITS[self.performance]
        return self.max_speed_mps or speed, along, across


class ImmParameters(TrackerParameters):
    """The recommended tracker, and a single filter for comparison."""

    performance: Literal["airliner", "fast_jet", "paper", "helicopter", "boat"] = parameter(
        "airliner", title="Performance class", group="motion", choices=CLASSES
    )
    """What the targets can do: the largest speed sets the size of the start gate."""
    association: Literal["nearest", "joint"] = parameter(
        "joint",
        title="Association",
        group="association",
        choices={
            "nearest": "each track its plot, together the nearest",
            "joint": "every plot in a gate with its probability",
        },
    )
    """The nearest for formations and few false plots, joint probabilities for crossings in clutter."""
    motion: Literal["imm", "constant_velocity"] = parameter(
        "imm",
        title="Motion models",
        group="motion",
        choices={
            "imm": "straight flight and turn, interacting",
            "constant_velocity": "straight flight alone: a single Kalman filter",
        },
    )
    """What the filters believe of the targets."""
    sd_straight_mps2: float = parameter(
        0.8, title="Acceleration in straight flight", unit="m/s²", gt=0, le=100, group="motion"
    )
    """Standard deviation of an acceleration that is constant between plots; of the single filter it is the only one."""
    sd_turn_mps2: float = parameter(
        3.0, title="Acceleration in a turn", unit="m/s²", gt=0, le=1000, group="motion", advanced=True
    )
    """The same beside the coordinated turn."""
    sd_turn_rate_deg_s: float = parameter(
        3.0, title="Turn rate", unit="°/s", gt=0, le=90, group="motion", advanced=True
    )
    """Standard deviation that is expected of it."""
    sd_turn_rate_step_deg_s: float = parameter(
        0.4, title="Change of the turn rate", unit="°/s", gt=0, le=90, group="motion", advanced=True
    )
    """Standard deviation of its change in an antenna period."""
    stay_straight: float = parameter(
        0.95, title="Stays straight", unit="1", ge=0.5, lt=1, group="motion", advanced=True
    )
    """Probability that a target in straight flight is so a period later."""
    stay_turning: float = parameter(0.9, title="Stays turning", unit="1", ge=0.5, lt=1, group="motion", advanced=True)
    """Probability that a turning target turns a period later."""
    gate_probability: float = parameter(0.998, title="Gate", unit="1", symbol="P_g", ge=0.5, lt=1, group="association")
    """Share of a target's plots that its gate holds."""
    coasting_gate: float = parameter(
        2.0, title="Gate while coasting", unit="1", ge=1, le=10, group="association", advanced=True
    )
    """So many times wider is the gate of a track that missed a scan."""
    detection_probability: float = parameter(
        0.9, title="Detection probability", unit="1", symbol="P_d", gt=0, le=1, group="association"
    )
    """That a scan has a target's plot; for joint probabilities, at most 0.999."""
    largest_cluster: int = parameter(
        10, title="Largest cluster", unit="1", ge=1, le=14, group="association", advanced=True
    )
    """Tracks or plots, whichever are fewer, up to which probabilities are exact; beyond, the nearest are taken."""
    use_identity: bool = parameter(True, title="Use addresses and altitudes", group="association")
    """A contradiction of addresses, callsigns or altitudes excludes a pair, an agreement makes it more likely."""
    drop_after: int = parameter(8, title="Missed periods that drop", unit="1", ge=1, le=100, group="start")
    """A confirmed track without a plot for so many antenna periods ends."""


class CurvatureParameters(TrackerParameters):
    """The paper's tracker and everything about it that can be chosen."""

    gate: Literal["paper", "sqrt", "exact"] = parameter(
        "paper",
        title="Tracking gate",
        group="association",
        choices={
            "paper": "the plot's errors times K_Q, as printed",
            "sqrt": "times the root of K_Q, right for straight lines",
            "exact": "from the covariance of the fit",
        },
    )
    """How large the three ellipses are."""
    predictor: Literal["ml6", "map6", "base_points", "line"] = parameter(
        "ml6",
        title="Trajectory",
        group="motion",
        choices={
            "ml6": "constant acceleration and curvature, six free parameters",
            "map6": "the same, with moderate acceleration and curvature expected",
            "base_points": "the same as the free one, fitted in the coordinates of three base plots",
            "line": "straight line",
        },
    )
    """What is fitted to the plots of a track's memory."""
    on_miss: Literal["reset", "keep"] = parameter(
        "reset",
        title="After a missed scan",
        group="association",
        choices={"reset": "the gate is that of Q = 2", "keep": "Q stays, the gate grows with time"},
    )
    """The paper does not say; kept literally, half of all turning aircraft are lost."""
    cost: Literal["likelihood_ratio", "distance_determinant"] = parameter(
        "likelihood_ratio",
        title="Cost of a pair",
        group="association",
        choices={
            "likelihood_ratio": "the paper's likelihood ratio",
            "distance_determinant": "squared distance plus the logarithm of the gate's determinant",
        },
    )
    """What the assignment makes small."""
    confidence_inner: float = parameter(0.65, title="Inner ellipse", unit="1", gt=0, lt=1, group="association")
    """Probability that it holds a plot in straight flight; inside it Q grows."""
    confidence_middle: float = parameter(0.95, title="Middle ellipse", unit="1", gt=0, lt=1, group="association")
    """Between it and the inner one Q stays."""
    confidence_outer: float = parameter(0.998, title="Outer ellipse", unit="1", gt=0, lt=1, group="association")
    """Between it and the middle one lies a manoeuvre, beyond it another target."""
    kept_plots: int = parameter(4, title="Plots kept at a manoeuvre", unit="1", ge=2, le=6, group="motion")
    """With the plot that showed it; the paper's text allows 3 or 4."""
    history_plots: int = parameter(13, title="Longest memory", unit="1", ge=4, le=40, group="motion", advanced=True)
    """Plots to which the trajectory is fitted at most; the paper bounds Q alone."""
    sd_acceleration_mps2: float = parameter(
        1.5, title="Expected acceleration", unit="m/s²", symbol="s_a", gt=0, le=100, group="motion", advanced=True
    )
    """Of the penalised trajectory, and where the free one is absurd."""
    sd_normal_mps2: float = parameter(
        3.0,
        title="Expected normal acceleration",
        unit="m/s²",
        symbol="s_n",
        gt=0,
        le=100,
        group="motion",
        advanced=True,
    )
    """Of the penalised trajectory, and where the free one is absurd."""

    @model_validator(mode="after")
    def _nested(self) -> CurvatureParameters:
        if not self.confidence_inner < self.confidence_middle < self.confidence_outer:
            raise ValueError("the confidences of the three ellipses must grow from the inner to the outer one")
        return self
