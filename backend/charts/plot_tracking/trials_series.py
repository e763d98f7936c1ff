"""What the power series of a curved trajectory errs by: against time, a line for each order, target by target."""

from __future__ import annotations

from backend.charts.figure import ChartNote, figure, not_applicable
from backend.charts.plot_tracking.target_panels import panels_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Error of the power series"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a panel for each target."""
    traces, panels = panels_of(view, "rms_series_m", "series_ahead_s", "Error, m", log=True)
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("series", "Distance of the series, cut behind its order, from the exact trajectory.")],
        **panels,
    )


CHART = Chart(
    name="trials_series",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("polar_plots",),
    swept="series_ahead_s",
)
