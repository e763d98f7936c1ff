"""What each further scan brings: correct, wrong and undecided tracks, and the most likely matching, over time."""

from __future__ import annotations

import numpy as np

from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, time_axis
from backend.charts.identification.samples import line_over_scans
from backend.charts.identification.trials_probability import METRICS
from backend.charts.trial_curves import leg_shapes, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Probabilities after each scan"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the shares of every algorithm at each instant."""
    traces: list[Trace] = []
    for series in series_of(view):
        for metric, word, dash in METRICS:
            values = series.numbers(metric)
            if series.time_s.size > 1 and np.isfinite(values).any():
                traces.append(line_over_scans(series, f"{series.name}, {word}", values, "%{y:.4~f}", dash=dash))
    if not traces:
        return not_applicable(TITLE, "no_curves")
    text = "Solid: correct; dotted: wrong; dashed: undecided; long dashes: most likely matching correct."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("scans", text)],
        xaxis=time_axis(view.recording),
        yaxis=axis("Probability", range=[-0.01, 1.02]),
        **leg_shapes(view.legs),
    )


CHART = Chart(name="trials_scans", title=TITLE, source="run", needs=("curves",), draw=draw, kinds=("polar_plots",))
