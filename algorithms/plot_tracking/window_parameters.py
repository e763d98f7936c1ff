"""Parameters of the estimator of one window."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from algorithms.plot_tracking.parameters import RadarAccuracy
from algorithms.spec import parameter

LEAST_PLOTS = {"line": 2, "quadratic": 3, "cubic": 4}
"""That determine a trajectory; a curve needs four."""


class WindowParameters(RadarAccuracy):
    """What is fitted to the last plots of a known target, and how its minimum is looked for."""

    window_plots: int = parameter(8, title="Plots in the window", unit="1", symbol="n", ge=2, le=40, group="motion")
    """Each estimate is from so many plots, the newest and those before it."""
    trajectory: Literal["ml6", "map6", "line", "quadratic", "cubic"] = parameter(
        "ml6",
        title="Trajectory",
        group="motion",
        choices={
            "ml6": "constant acceleration and curvature, six free parameters",
            "map6": "the same, with moderate acceleration and curvature expected",
            "line": "straight line",
            "quadratic": "quadratic polynomials of time in east and in north",
            "cubic": "cubic polynomials of time in east and in north",
        },
    )
    """What is fitted."""
    descent: Literal["damped", "centre", "quadratic", "three_points", "base_points"] = parameter(
        "damped",
        title="Descent",
        group="motion",
        choices={
            "damped": "damped steps from two starts, the lower minimum",
            "centre": "full steps in the circle's centre and radius",
            "quadratic": "full steps in course, speed and curvature, from a quadratic",
            "three_points": "the same, from the curve through three plots",
            "base_points": "full steps in the polar coordinates of three plots",
        },
    )
    """Of `ml6`: in which coordinates, and from where."""
    compare_minima: bool = parameter(False, title="Look for a lower minimum", group="output", advanced=True)
    """Fit every window in every other way too, and say whether this one found the lowest minimum."""
    sd_acceleration_mps2: float = parameter(
        1.5, title="Expected acceleration", unit="m/s²", symbol="s_a", gt=0, le=100, group="motion", advanced=True
    )
    """Of the penalised trajectory."""
    sd_normal_mps2: float = parameter(
        3.0, title="Expected normal acceleration", unit="m/s²", symbol="s_n", gt=0, le=100, group="motion",
        advanced=True,
    )  # fmt: skip
    """Of the penalised trajectory."""
    series_order: int = parameter(3, title="Order of the series", unit="1", ge=2, le=12, group="output", advanced=True)
    """The paper's power series of the trajectory is cut behind this term to say what the cut costs."""
    series_ahead_s: float = parameter(20.0, title="Series ahead", unit="s", ge=0, le=600, group="output", advanced=True)
    """So long after the newest plot."""

    @model_validator(mode="after")
    def _enough(self) -> WindowParameters:
        least = LEAST_PLOTS.get(self.trajectory, 4)
        if self.window_plots < least:
            raise ValueError(f"this trajectory needs at least {least} plots in the window")
        return self
