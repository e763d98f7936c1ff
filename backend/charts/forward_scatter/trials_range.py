"""Middle of the errors of the crossing distance over trials, where their moments do not exist, and how many answered.

Before about six seconds of a pass the closed form is a ratio without mean or spread (specification 8.1); its median and
the range that holds the middle 68 % of the trials always exist.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked, curve
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import axis_number, passes_begin
from backend.charts.trial_curves import Series, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Middle of the errors over trials"
NAME = "crossing_distance_error_m"
LOW, MIDDLE, HIGH = (f"{q}_{NAME}" for q in ("p16", "median", "p84"))
# The first view holds this share of the ends of the bands: the first instants can be wild.
VIEW = 92
# Shares of the height: errors, and trials without an answer.
UPPER, LOWER = 0.7, 0.22


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw median and 16 to 84 % range of the signed error, and below the share of trials without an answer."""
    found = [s for s in series_of(view) if np.isfinite(s.numbers(MIDDLE)).any()]
    if not found:
        return not_applicable(TITLE, "no_curves")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in found:
        traces += _band(series)
    for series in found:
        traces.append(_curve(series, MIDDLE, 1.0, "y", "%{y:,.3~r} m", options, picked))
    below = f"y{axis_number(1)}"
    for series in found:
        lost = _curve(series, "answered_share", 100.0, below, "%{y:.1f} % without an answer", options, picked)
        traces.append(lost | {"y": 100 - np.asarray(lost["y"]), "showlegend": False})
    ends = np.concatenate([np.abs(s.numbers(c)) for s in found for c in (LOW, HIGH)])
    reach = 1.1 * float(np.nanpercentile(ends, VIEW)) + 1e-6
    axes: dict[str, Any] = {
        "yaxis": axis("Error, m", domain=[1 - UPPER, 1], range=[-reach, reach]),
        f"yaxis{axis_number(1)}": axis("Lost, %", domain=[0, LOWER], rangemode="tozero"),
    }
    trials = counted(min(s.trials for s in found), "trial")
    text = f"Over {trials}: lines are medians, bands hold the middle 68 % of the answers; below, trials without one."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("middle", text)],
        xaxis=time_axis(view.recording, anchor=below),
        **axes,
    )


def _curve(
    series: Series, column: str, scale: float, yaxis: str, hover: str, options: ChartOptions, picked: list[Picked]
) -> Trace:
    values = scale * series.numbers(column)
    starts = passes_begin(series.time_s)
    points = curve(series.time_s, (values,), starts, options.curve_points)
    picked.append(points)
    return trace(
        "series",
        points.take(series.time_s),
        options.number(points.take(values)),
        entry=series.entry,
        name=series.name,
        mode="lines",
        yaxis=yaxis,
        line=series.look,
        hovertemplate=f"<b>{series.name}</b><br>{hover}<br>%{{x:.5~g}} s<extra></extra>",
    )


def _band(series: Series) -> list[Trace]:
    low, high = series.numbers(LOW), series.numbers(HIGH)
    fill = theme.faint(theme.series_color(series.entry.index), theme.INTERVAL_OPACITY)
    out: list[Trace] = []
    for piece in np.split(np.arange(low.size), np.flatnonzero(passes_begin(series.time_s))[1:]):
        known = piece[np.isfinite(low[piece]) & np.isfinite(high[piece])]
        if known.size < 2:
            continue
        out.append(
            trace(
                "interval",
                np.concatenate([series.time_s[known], series.time_s[known][::-1]]),
                np.concatenate([high[known], low[known][::-1]]).astype(np.float32),
                entry=series.entry,
                name=f"{series.name}, middle 68 %",
                mode="lines",
                line={"width": 0},
                fill="toself",
                fillcolor=fill,
                showlegend=False,
                hoverinfo="skip",
            )
        )
    return out


CHART = Chart(
    name="trials_range",
    title=TITLE,
    source="run",
    needs=("curves",),
    draw=draw,
    kinds=("doppler_pairs",),
    overlay="time",
)
