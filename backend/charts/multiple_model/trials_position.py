"""Position error in space over trials."""

from __future__ import annotations

from backend.charts.multiple_model.trials_axes import Axis, draw_axis
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Error in space over trials"
BOUNDS = ("bound_east_m", "bound_north_m", "bound_up_m")
AXIS = Axis(TITLE, "Error in space (rms), m", "rms_position_m", BOUNDS, "m")


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the root mean square of the distance from the truth at each instant."""
    return draw_axis(view, options, AXIS)


CHART = Chart(name="trials_position", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time",
              kinds=("antenna_plots",))  # fmt: skip
