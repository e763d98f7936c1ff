"""Absolute acceleration over time."""

from __future__ import annotations

from backend.charts.multiple_model.motion import Quantity, draw_motion
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Absolute acceleration"
ACCELERATION = Quantity(
    TITLE, "Acceleration, m/s²", "acceleration", "mps2", "m/s²", "no_acceleration", derivative=True
)  # fmt: skip


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the length of the acceleration; the truth is the slope of its velocity."""
    return draw_motion(view, options, ACCELERATION)


CHART = Chart(name="acceleration", title=TITLE, source="run", needs=("states",), draw=draw,
              kinds=("antenna_plots",))  # fmt: skip
