"""How far each plot lay from the middle of its track's gate, as a share of the gate's radius, by what was decided."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import numbers, row_numbers, words
from backend.charts.decimate import Picked, thin
from backend.charts.figure import (
    Trace,
    axis,
    crowd_opacity,
    figure,
    hover,
    not_applicable,
    time_axis,
    trace,
)
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Plots in their gates"
SYMBOLS = {"updated": "circle", "updated_middle": "circle-open", "manoeuvre": "diamond", "shared": "x"}
BEGINNING = "triangle-up-open"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a point for each plot that lay in a gate."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    for entry in view.entries:
        traces += _points(entry, options, picked)
    if not traces:
        return not_applicable(TITLE, "no_decisions")
    finite = view.time_s[np.isfinite(view.time_s)]
    ends = np.array([finite.min(), finite.max()]) if finite.size else np.zeros(2)
    edge = {"color": theme.BOUND, "dash": "dot", "width": 1}
    traces.append(trace("bound", ends, np.ones(2), name="edge of the gate", mode="lines", line=edge))
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        xaxis=time_axis(view.recording),
        yaxis=axis("Share of the gate's radius", rangemode="tozero"),
    )


def _points(entry: Entry, options: ChartOptions, picked: list[Picked]) -> list[Trace]:
    table = entry.table("decisions")
    share = numbers(table, "distance") / numbers(table, "threshold")
    known = np.flatnonzero(np.isfinite(share) & (words(table, "gate") != ""))
    if not known.size:
        return []
    points = thin(known, options.marks)
    picked.append(points)
    decision = words(table, "decision")
    time, row = numbers(table, "time_s"), row_numbers(table)
    out = []
    for word in dict.fromkeys(decision[points.positions].tolist()):
        mine = points.positions[decision[points.positions] == word]
        part = Picked(mine, int(mine.size), int(mine.size))
        marker = {
            "color": theme.series_color(entry.index),
            "symbol": SYMBOLS.get(word, BEGINNING),
            "size": 5,
            "opacity": max(crowd_opacity(known.size), 0.3),
        }
        out.append(
            trace(
                "series",
                part.take(time),
                options.number(part.take(share)),
                entry=entry,
                name=f"{entry.label}, {word.replace('_', ' ')}",
                showlegend=False,
                mode="markers",
                marker=marker,
                customdata=part.take(row),
                **hover(
                    part,
                    f"{entry.label}, {word.replace('_', ' ')}",
                    "%{y:.2f} of the radius<br>%{x:.3f} s, row %{customdata}",
                    [
                        ("track", words(table, "track")),
                        ("gate", words(table, "gate")),
                        ("also in gates of", words(table, "competing")),
                        ("target", words(table, "target")),
                    ],
                ),
            )
        )
    return out


CHART = Chart(
    name="plot_distances",
    title=TITLE,
    source="run",
    needs=("decisions",),
    draw=draw,
    kinds=("polar_plots",),
    overlay="time",
)
