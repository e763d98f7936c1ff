"""How far the set of all tracks lies from the set of all targets, scan by scan: OSPA, GOSPA, and GOSPA's parts.

Above the two distances; below the targets without a track (solid) and the tracks without a target (dotted). Of several
radars each scan tells of its own radar's tracks.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts.columns import Floats, numbers
from backend.charts.decimate import Picked, curve
from backend.charts.figure import ChartNote, Trace, axis, figure, line_of, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "OSPA and GOSPA"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw two panels over one axis of time."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    for entry in view.entries:
        table = entry.table("set_distances")
        if not len(table):
            continue
        time = numbers(table, "time_s")
        order = np.argsort(time, kind="stable")
        for column, word, panel, unit, look in (
            ("gospa_m", "GOSPA", "y", "m", {}),
            ("ospa_m", "OSPA", "y", "m", {"dash": "dot"}),
            ("missed", "missed", "y2", "", {}),
            ("false", "false", "y2", "", {"dash": "dot"}),
        ):
            values = numbers(table, column)[order]
            traces.append(
                _line(entry, f"{entry.label}, {word}", time[order], values, panel, unit, look, options, picked)
            )
    if not traces:
        return not_applicable(TITLE, "no_truth")
    layout: dict[str, Any] = {
        "yaxis": axis("Distance, m", domain=[0.45, 1.0], rangemode="tozero"),
        "yaxis2": axis("Number of errors", domain=[0.0, 0.35], rangemode="tozero"),
    }
    note = ChartNote(
        "cut_at",
        "Distances are cut at ten errors of a plot, 2 km at most. Dotted above: OSPA; dotted below: tracks without a "
        "target.",
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[note],
        xaxis=time_axis(view.recording, anchor="y2"),
        **layout,
    )


def _line(
    entry: Entry, name: str, time: Floats, values: Floats, panel: str, unit: str, look: dict[str, str],
    options: ChartOptions, picked: list[Picked],
) -> Trace:  # fmt: skip
    starts = np.zeros(time.size, bool)
    starts[:1] = True
    points = curve(time, (values,), starts, options.curve_points)
    picked.append(points)
    return trace(
        "series",
        points.take(time),
        options.number(points.take(values)),
        entry=entry,
        name=name,
        showlegend=panel == "y",
        mode="lines",
        line=line_of(entry) | look,
        yaxis=panel,
        hovertemplate=f"<b>{name}</b><br>%{{y:.4~g}} {unit}<br>%{{x:.5~g}} s<extra></extra>",
    )


CHART = Chart(
    name="track_sets",
    title=TITLE,
    source="run",
    needs=("set_distances",),
    draw=draw,
    kinds=("polar_plots",),
    overlay="time",
)
