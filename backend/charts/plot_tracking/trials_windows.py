"""What a window of more and more plots is worth, target by target: how often its descent ends in the lowest minimum.

Where no algorithm looked for lower minima it is the error of the place one period ahead.
"""

from __future__ import annotations

from backend.charts.figure import ChartNote, figure, not_applicable
from backend.charts.plot_tracking.target_panels import panels_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Windows of more and more plots"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a panel for each target."""
    traces, panels = panels_of(view, "lowest_share", "window_plots", "Share")
    note = "Share of windows whose descent ended in the lowest minimum that any way finds."
    if not traces:
        traces, panels = panels_of(view, "rms_ahead_m", "window_plots", "Error ahead, m", log=True)
        note = "Error of the place one period ahead of the newest plot, rms."
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("windows", note)],
        **panels,
    )


CHART = Chart(
    name="trials_windows",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("polar_plots",),
    swept="window_plots",
)
