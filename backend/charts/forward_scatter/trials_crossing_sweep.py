"""Error of the crossing distance at the crossing and at the end of the pass against the first swept value."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import Floats, numbers, words
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, not_applicable, trace
from backend.charts.swept import title_of
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Crossing distance against the swept value"
METRIC = "crossing_distance_rms_m"
SEGMENTS = (("crossing", "solid"), ("end", "dash"))


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the rms error with its 95 % interval; other swept values are different curves."""
    traces: list[Trace] = []
    first = ""
    for entry in view.entries:
        table = entry.table("metrics")
        swept = swept_columns(table)
        if not len(table) or not swept:
            continue
        first = first or swept[0]
        traces += _lines(entry, words(table, "metric"), words(table, "segment"), numbers(table, swept[0]),
                         *(numbers(table, n) for n in ("value", "ci95_low", "ci95_high")))  # fmt: skip
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[
            ChartNote("crossing_sweep", "Rms over the trials at the crossing and at the end; bars are 95 % intervals.")
        ],
        xaxis=axis(title_of(first, view)),
        yaxis=log_axis("Error of the crossing distance, m", traces),
    )


def _lines(
    entry: Entry, metric: np.ndarray, segment: np.ndarray, x: Floats, value: Floats, low: Floats, high: Floats
) -> list[Trace]:
    out: list[Trace] = []
    for name, dash in SEGMENTS:
        own = np.flatnonzero((metric == METRIC) & (segment == name) & np.isfinite(x) & np.isfinite(value))
        own = own[np.argsort(x[own], kind="stable")]
        if not own.size:
            continue
        color = theme.series_color(entry.index)
        out.append(
            trace(
                "series",
                x[own],
                value[own],
                entry=entry,
                name=f"{entry.label}, {name}",
                mode="lines+markers",
                line={"color": color, "dash": dash, "width": 1.5},
                marker={"color": color, "size": 6},
                error_y={
                    "type": "data",
                    "array": np.nan_to_num(high[own] - value[own]),
                    "arrayminus": np.nan_to_num(value[own] - low[own]),
                    "color": color,
                    "thickness": 1,
                },
                hovertemplate=f"<b>{entry.label}, {name}</b><br>%{{y:,.3~r}} m<br>%{{x}}<extra></extra>",
            )
        )
    return out


CHART = Chart(
    name="trials_crossing_sweep",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("doppler_pairs",),
    overlay="time",
)
