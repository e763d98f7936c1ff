"""Mean probability of each motion model over trials at each instant."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked
from backend.charts.figure import Trace, axis, figure, not_applicable, time_axis
from backend.charts.trial_curves import leg_shapes, line, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Probabilities of the models over trials"
PREFIX = "mode_probability_"
DASHES = ("solid", "dash", "dot", "dashdot")


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a line for each algorithm and model: the label gives the colour, the model the dash."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in series_of(view):
        names = [n for n in series.columns if n.startswith(PREFIX) and not n.endswith(("_low", "_high"))]
        for m, name in enumerate(names):
            values = series.numbers(name)
            if np.isfinite(values).any():
                model = name.removeprefix(PREFIX)
                look = {"dash": DASHES[m % len(DASHES)], "color": theme.series_color(series.entry.index + m)}
                traces.append(
                    line(series, f"{series.name}, {model}", values, options, picked, "probability %{y:.3f}", **look)
                )
    if not traces:
        return not_applicable(TITLE, "no_models")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        xaxis=time_axis(view.recording),
        yaxis=axis("Mean probability", range=[0, 1]),
        **leg_shapes(view.legs),
    )


CHART = Chart(name="trials_modes", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time",
              kinds=("antenna_plots",))  # fmt: skip
