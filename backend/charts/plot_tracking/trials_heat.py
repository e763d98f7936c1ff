"""How tracking holds out over two swept values, such as detection probability and false plots: a map for each tracker.

The value is OSPA; where there are no targets, confirmed tracks of nothing. One swept value makes a strip.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.result import Table
from backend.charts import theme
from backend.charts.columns import Floats, numbers, texts
from backend.charts.figure import ChartNote, Trace, axis, figure, meta, not_applicable
from backend.charts.forward_scatter.panels import axis_number, stacked_axes
from backend.charts.swept import title_of
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Trackers over two swept values"
METRICS = {
    "ospa_m": "Mean OSPA in metres, cut at ten errors of a plot, 2 km at most; the strongest colour is the worst.",
    "false_tracks_per_scan": "Confirmed tracks of nothing in a scan; the strongest colour is the worst.",
}
# More numbers than these in a map would lie over each other.
MOST_WORDS = 60
# Above each map stands its tracker.
ROOM_FOR_NAME = 0.07


class _Map(NamedTuple):
    """Values z (rows of y, columns of x) of one tracker."""

    entry: Entry
    swept: list[str]
    x: Floats
    y: Floats
    z: Floats


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the maps under each other, in one scale of colours."""
    for metric, note in METRICS.items():
        maps = [found for entry in view.entries if (found := _map_of(entry, metric)) is not None]
        if maps:
            return _figure(view, maps, note, digits=".0f" if metric.endswith("_m") else ".3~g")
    return not_applicable(TITLE, "no_sweep")


def _map_of(entry: Entry, metric: str) -> _Map | None:
    table = entry.table("metrics")
    if not len(table):
        return None
    over_all = texts(table, "segment").are(None) & texts(table, "target").are(None)
    table = table.take(over_all & texts(table, "metric").are(metric))
    swept = [name for name in swept_columns(table) if np.unique(_known(table, name)).size > 1]
    if not len(table) or not 1 <= len(swept) <= 2 or not np.isfinite(numbers(table, "value")).any():
        return None
    # The value with more steps goes to the right.
    swept.sort(key=lambda name: -np.unique(_known(table, name)).size)
    x = numbers(table, swept[0])
    y = numbers(table, swept[1]) if len(swept) == 2 else np.zeros(len(table))
    xs, ys = np.unique(x[np.isfinite(x)]), np.unique(y[np.isfinite(y)])
    z = np.full((ys.size, xs.size), np.nan)
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    z[np.searchsorted(ys, y[known]), np.searchsorted(xs, x[known])] = numbers(table, "value")[known]
    return _Map(entry, swept, xs, ys, z)


def _known(table: Table, name: str) -> Floats:
    values = numbers(table, name)
    return values[np.isfinite(values)]


def _figure(view: RunView, maps: list[_Map], note: str, digits: str) -> Figure:
    low, high = (float(f([f(m.z[np.isfinite(m.z)]) for m in maps])) for f in (np.min, np.max))
    panels = stacked_axes([title_of(m.swept[-1], view) for m in maps], type="category")
    traces: list[Trace] = []
    names = []
    for i, one in enumerate(maps):
        number = axis_number(i)
        bottom, top = panels[f"yaxis{number}"]["domain"]
        panels[f"yaxis{number}"]["domain"] = [bottom, top - ROOM_FOR_NAME]
        steps = [f"{v:g}" for v in one.y] if len(one.swept) == 2 else [one.entry.label]
        panels[f"yaxis{number}"] |= {"categoryorder": "array", "categoryarray": steps}
        if len(one.swept) == 1:
            panels[f"yaxis{number}"]["title"]["text"] = "Algorithm"
        traces.append(
            {
                "type": "heatmap",
                "x": _edges(one.x),
                "y": steps,
                "yaxis": f"y{number}",
                "z": one.z,
                "zmin": low,
                "zmax": high,
                "colorscale": [[k / 5, c] for k, c in enumerate(theme.SEQUENCE)],
                "showscale": i == 0,
                "colorbar": {"thickness": 12},
                "name": one.entry.label,
                "meta": meta("series", one.entry),
                "texttemplate": f"%{{z:{digits}}}" if one.z.size <= MOST_WORDS else "",
                "hovertemplate": f"<b>{one.entry.label}</b><br>%{{x:g}}, %{{y}}: %{{z:.4~g}}<extra></extra>",
            }
        )
        names.append(
            {"text": one.entry.label, "x": 0, "xref": "paper", "xanchor": "left", "yanchor": "bottom",
             "y": panels[f"yaxis{number}"]["domain"][1], "yref": "paper", "showarrow": False}
        )  # fmt: skip
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("map", note)],
        xaxis=axis(title_of(maps[0].swept[0], view), tickmode="array", tickvals=maps[0].x,
                   ticktext=[f"{v:g}" for v in maps[0].x], anchor=f"y{axis_number(len(maps) - 1)}"),
        annotations=names,
        **panels,
    )  # fmt: skip


def _edges(values: Floats) -> Floats:
    """Edges of cells around swept values."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[:-1] + values[1:]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


CHART = Chart(
    name="trials_heat", title=TITLE, source="run", needs=("metrics",), draw=draw, kinds=("polar_plots",), least_sweeps=1
)
