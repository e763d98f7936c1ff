"""Vertical position error over trials."""

from __future__ import annotations

from backend.charts.multiple_model.trials_axes import Axis, draw_axis
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Vertical error over trials"
AXIS = Axis(TITLE, "Vertical error (rms), m", "rms_up_m", ("bound_up_m",), "m")


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the vertical position's root mean square at each instant."""
    return draw_axis(view, options, AXIS)


CHART = Chart(name="trials_up", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time",
              kinds=("antenna_plots",))  # fmt: skip
