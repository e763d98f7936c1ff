"""OSPA and GOSPA over trials at each instant: the mean distance between the sets of all tracks and of all targets."""

from __future__ import annotations

import numpy as np

from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, time_axis
from backend.charts.trial_curves import leg_shapes, line, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "OSPA and GOSPA over trials"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw GOSPA solid and OSPA dotted."""
    # A set has no target: its distances stand with the first one.
    found = [s for s in series_of(view) if np.isfinite(s.numbers("gospa_m")).any()]
    if not found:
        return not_applicable(TITLE, "no_curves")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in found:
        name = ", ".join(part for part in series.name.split(", ") if not part.startswith("target = "))
        for column, word, look in (("gospa_m", "GOSPA", {"width": 2}), ("ospa_m", "OSPA", {"width": 1, "dash": "dot"})):
            values = series.numbers(column)
            traces.append(line(series, f"{name}, {word}", values, options, picked, "%{y:,.3~r} m", **look))
    trials = counted(min(s.trials for s in found), "trial")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("trials", f"Mean over {trials}, cut at ten errors of a plot, 2 km at most; dotted is OSPA.")],
        xaxis=time_axis(view.recording),
        yaxis=axis("Distance, m", rangemode="tozero"),
        **leg_shapes(view.legs),
    )


CHART = Chart(
    name="trials_sets",
    title=TITLE,
    source="run",
    needs=("curves",),
    draw=draw,
    kinds=("polar_plots",),
    overlay="time",
)
