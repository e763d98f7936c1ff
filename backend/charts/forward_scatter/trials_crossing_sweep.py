"""Error of the crossing distance at the crossing and at the end of the pass against the first swept value."""

from __future__ import annotations

import numpy as np

from algorithms.result import Table
from backend.charts.columns import numbers, words
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, not_applicable, trace
from backend.charts.swept import title_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Crossing distance against the swept value"
METRIC = "crossing_distance_rms_m"
SEGMENTS = (("crossing", "solid", "circle"), ("end", "dash", "circle-open"))


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
        traces += _lines(entry, table, swept)
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


def _lines(entry: Entry, table: Table, swept: list[str]) -> list[Trace]:
    """One line for each segment and combination of the other swept values, against the first one."""
    metric, segment = words(table, "metric"), words(table, "segment")
    x, value, low, high = (numbers(table, n) for n in (swept[0], "value", "ci95_low", "ci95_high"))
    others = list(zip(*(_words(table, name) for name in swept[1:]), strict=True)) if swept[1:] else [()] * len(table)
    wanted = (metric == METRIC) & np.isfinite(x) & np.isfinite(value)
    different = list(dict.fromkeys(others[i] for i in np.flatnonzero(wanted)))
    out: list[Trace] = []
    for k, same in enumerate(different):
        named = "".join(f", {n.rpartition('.')[2]} = {v}" for n, v in zip(swept[1:], same, strict=True))
        look = line_of_variant(entry, k, len(different))
        for name, dash, symbol in SEGMENTS:
            own = np.array([i for i in np.flatnonzero(wanted & (segment == name)) if others[i] == same], np.int64)
            own = own[np.argsort(x[own], kind="stable")]
            if not own.size:
                continue
            out.append(
                trace(
                    "series",
                    x[own],
                    value[own],
                    entry=entry,
                    name=f"{entry.label}{named}, {name}",
                    mode="lines+markers",
                    line=look | {"dash": dash},
                    marker={"color": look["color"], "size": 6, "symbol": symbol},
                    error_y={
                        "type": "data",
                        "array": np.nan_to_num(high[own] - value[own]),
                        "arrayminus": np.nan_to_num(value[own] - low[own]),
                        "color": look["color"],
                        "thickness": 1,
                    },
                    hovertemplate=f"<b>{entry.label}{named}, {name}</b><br>%{{y:,.3~r}} m<br>%{{x}}<extra></extra>",
                )
            )
    return out


def _words(table: Table, name: str) -> list[str]:
    """A swept column as words; numbers short."""
    column = table.columns[name]
    return [f"{v:g}" for v in column] if isinstance(column, np.ndarray) else [v or "" for v in column]


CHART = Chart(
    name="trials_crossing_sweep",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("doppler_pairs",),
    overlay="time",
    least_sweeps=1,
)
