"""Map of the bound along the base line: the least error of the distance for the last pass moved to each place."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import numbers
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, not_applicable, trace
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Bound along the base line"
CURVES = (
    ("crossing_unknown_m", "at the crossing, course unknown", "solid", 0),
    ("end_unknown_m", "at the end, course unknown", "solid", 1),
    ("crossing_known_m", "at the crossing, course known", "dot", 0),
    ("end_known_m", "at the end, course known", "dot", 1),
)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the bound of the first algorithm that has one: it depends on site and pass, not on the method."""
    traces: list[Trace] = []
    for entry in view.entries:
        table = entry.table("base_bounds")
        if not len(table):
            continue
        x = numbers(table, "distance_m") / 1000
        for column, name, dash, color in CURVES:
            y = numbers(table, column)
            if np.isfinite(y).any():
                traces.append(
                    trace(
                        "series",
                        x,
                        y,
                        name=name,
                        mode="lines",
                        line={"color": theme.series_color(color), "dash": dash, "width": 1.5},
                        hovertemplate=f"<b>{name}</b><br>%{{y:.0f}} m<br>at %{{x:.1f}} km<extra></extra>",
                    )
                )
        if traces:
            break
    if not traces:
        return not_applicable(TITLE, "no_base_bounds")
    notes = [
        ChartNote("base_bound", "Cramer-Rao bound for the last pass's speed, course and instants, moved to each place.")
    ]
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=axis("Distance from the receivers, km"),
        yaxis=log_axis("Standard deviation of the distance, m", traces),
    )


CHART = Chart(name="base_bound", title=TITLE, source="run", needs=("base_bounds",), draw=draw, kinds=("doppler_pairs",))
