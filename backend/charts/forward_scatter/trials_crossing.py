"""Error of the crossing distance over trials at each instant: mean, spread and rms, and both Cramer-Rao bounds."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, counted, figure, log_axis, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import passes_begin, since_begin
from backend.charts.trial_curves import Series, band, line, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Error of the crossing distance over trials"
# Moments of the closed form do not exist for few measurements: the estimate is a ratio.
WORDS = (
    ("crossing_distance_rms_m", "rms", {"width": 2}),
    ("crossing_distance_sd_m", "standard deviation", {"width": 1, "dash": "dash"}),
    ("crossing_distance_mean_m", "mean, absolute", {"width": 1, "dash": "dot"}),
)
BOUNDS = (
    ("crossing_distance_bound_4_m", "course unknown", "dot"),
    ("crossing_distance_bound_3_m", "course known", "dash"),
)
FIRST_S = 6.0
# Of more series than these only the rms error is drawn: three curves of each could not be told apart.
MOST_SERIES = 4


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw every series on a logarithmic axis, from six seconds after the first instant of a pass on."""
    found = [s for s in series_of(view) if np.isfinite(s.numbers("crossing_distance_rms_m")).any()]
    if not found:
        return not_applicable(TITLE, "no_curves")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in found:
        low, high = (_settled(series, f"crossing_distance_rms_m_{end}") for end in ("low", "high"))
        traces += band(series, low, high)
    for series in found:
        for column, word, look in WORDS if len(found) <= MOST_SERIES else WORDS[:1]:
            values = np.abs(_settled(series, column))
            if np.isfinite(values).any():
                traces.append(line(series, f"{series.name}, {word}", values, options, picked, "%{y:,.3~r} m", **look))
        _add_bounds(series, traces)
    trials = counted(min(s.trials for s in found), "trial")
    text = (
        f"Over {trials}, from {FIRST_S:g} s after the first instant of a pass: before, mean and spread of a ratio do "
        "not exist. The table of metrics has medians and the share of answers."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("moments", text)],
        xaxis=time_axis(view.recording),
        yaxis=log_axis("Error of the crossing distance, m", [t for t in traces if t["meta"]["role"] == "series"]),
    )


def _settled(series: Series, column: str) -> np.ndarray:
    values = series.numbers(column)
    since = since_begin(series.time_s, passes_begin(series.time_s))
    return np.where(since >= FIRST_S, values, np.nan) if since.max(initial=0.0) > FIRST_S else values


def _add_bounds(series: Series, traces: list[Trace]) -> None:
    """Each bound once: methods on the same scenario share it."""
    known = [t for t in traces if t["meta"]["role"] == "bound"]
    for column, word, dash in BOUNDS:
        bound = _settled(series, column)
        if not np.isfinite(bound).any():
            continue
        if any(len(t["y"]) == bound.size and np.allclose(t["y"], bound, rtol=1e-3, equal_nan=True) for t in known):
            continue
        traces.append(
            trace(
                "bound",
                series.time_s,
                bound,
                name=f"bound, {word}",
                mode="lines",
                line={"color": theme.BOUND, "dash": dash, "width": 1},
            )
        )


CHART = Chart(
    name="trials_crossing",
    title=TITLE,
    source="run",
    needs=("curves",),
    draw=draw,
    kinds=("doppler_pairs",),
    overlay="time",
)
