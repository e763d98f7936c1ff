"""Error over trials at each instant, of one axis or of all, with the bound that is given beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, counted, figure, log_axis, not_applicable, time_axis, trace
from backend.charts.trial_curves import Series, band, leg_shapes, line, series_of
from backend.charts.view import ChartOptions, Figure, RunView


@dataclass(frozen=True)
class Axis:
    """Which curve is drawn: its column, its bound's, and the words for it."""

    title: str
    axis: str
    column: str
    bounds: tuple[str, ...]
    """Columns of the axes' bounds; of several the root of the sum of squares counts."""
    unit: str


def draw_axis(view: RunView, options: ChartOptions, which: Axis) -> Figure:
    """Draw root mean squares with their intervals; the bound once, dotted."""
    found = [s for s in series_of(view) if np.isfinite(s.numbers(which.column)).any()]
    if not found:
        return not_applicable(which.title, "no_curves")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in found:
        traces += band(series, series.numbers(f"{which.column}_low"), series.numbers(f"{which.column}_high"))
    for series in found:
        hover = f"rms %{{y:,.3~r}} {which.unit}"
        traces.append(line(series, series.name, series.numbers(which.column), options, picked, hover, width=2))
        _add_bound(series, which, traces)
    trials = counted(min(s.trials for s in found), "trial")
    text = f"Root mean square over {trials}; bands are 95 % intervals. The bound knows when the object manoeuvres."
    return figure(
        which.title,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("trials", text)],
        xaxis=time_axis(view.recording),
        yaxis=log_axis(which.axis, [t for t in traces if t["meta"]["role"] == "series"]),
        **leg_shapes(view.legs),
    )


def _add_bound(series: Series, which: Axis, traces: list[Trace]) -> None:
    bound = np.sqrt(sum(series.numbers(name) ** 2 for name in which.bounds))
    known = [t for t in traces if t["meta"]["role"] == "bound"]
    if not np.isfinite(bound).any():
        return
    if any(len(t["y"]) == bound.size and np.allclose(t["y"], bound, rtol=1e-6, equal_nan=True) for t in known):
        return
    look = {"color": theme.BOUND, "dash": "dot", "width": 1}
    traces.append(trace("bound", series.time_s, bound, name="bound, manoeuvre known", mode="lines", line=look))
