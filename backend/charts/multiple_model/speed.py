"""Speed over time."""

from __future__ import annotations

from backend.charts.multiple_model.motion import Quantity, draw_motion
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Speed"
SPEED = Quantity(TITLE, "Speed, m/s", "velocity", "mps", "m/s", "no_velocity", derivative=False)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the length of the velocity."""
    return draw_motion(view, options, SPEED)


CHART = Chart(name="speed", title=TITLE, source="run", needs=("states",), draw=draw,
              kinds=("antenna_plots",))  # fmt: skip
