"""Vertical velocity error over trials."""

from __future__ import annotations

from backend.charts.multiple_model.trials_axes import Axis, draw_axis
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Vertical velocity error over trials"
AXIS = Axis(
    TITLE, "Vertical velocity error (rms), m/s", "rms_velocity_up_mps", ("bound_velocity_up_mps",), "m/s"
)  # fmt: skip


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the vertical velocity's root mean square at each instant."""
    return draw_axis(view, options, AXIS)


CHART = Chart(name="trials_velocity_up", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time",
              kinds=("antenna_plots",))  # fmt: skip
