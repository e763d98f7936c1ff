"""The memory of each track over time as steps: the counter Q above, the plots that its trajectory is fitted to below.

A manoeuvre sets Q to 2 and lets the memory forget all but the last plots.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import Trace, axis, figure, hover, line_of, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Memory of the tracks"
PANELS = (("q", "Q", "y"), ("window_plots", "plots", "y2"))


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw two panels over one axis of time."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    for entry in view.entries:
        states = estimates_of(entry)
        if not np.isfinite(states.numbers("q")).any():
            continue
        for column, word, panel in PANELS:
            traces.append(_steps(entry, states, states.numbers(column), word, panel, options, picked))
    if not traces:
        return not_applicable(TITLE, "no_memory")
    layout: dict[str, Any] = {
        "yaxis": axis("Counter Q", domain=[0.55, 1.0], rangemode="tozero"),
        "yaxis2": axis("Number of plots", domain=[0.0, 0.45], rangemode="tozero"),
    }
    return figure(
        TITLE, traces, recording=view.recording, picked=picked, xaxis=time_axis(view.recording, anchor="y2"), **layout
    )


def _steps(
    entry: Entry, states: Estimates, values: Floats, word: str, panel: str, options: ChartOptions, picked: list[Picked]
) -> Trace:
    points = curve(states.time_s, (values,), states.starts, options.curve_points)
    picked.append(points)
    return trace(
        "series",
        points.take(states.time_s),
        options.number(points.take(values)),
        entry=entry,
        name=entry.label,
        showlegend=panel == "y",
        mode="lines",
        line=line_of(entry) | {"shape": "hv"},
        yaxis=panel,
        customdata=points.take(states.row),
        **hover(
            points,
            entry.label,
            f"%{{y:.0f}} {word}<br>%{{x:.3f}} s, row %{{customdata}}",
            [("track", states.words_at("track")), ("target", states.words_at("target"))],
        ),
    )


CHART = Chart(
    name="track_memory",
    title=TITLE,
    source="run",
    needs=("states",),
    draw=draw,
    kinds=("polar_plots",),
    overlay="time",
)
