"""What a sweep shows: the rms horizontal error of all instants against the swept value, with 95 % intervals."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts.columns import texts
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, marker_of, not_applicable, trace
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Error against the swept value"
METRIC = "rms_horizontal_m"
MOST_TICKS = 12
# Errors within this factor stand on a linear axis.
LINEAR_UP_TO = 10
# Ends of names of parameters.
UNITS = {
    "m": "m", "km": "km", "s": "s", "ns": "ns", "ppm": "ppm", "deg": "deg", "hz": "Hz",
    "mps": "m/s", "mps2": "m/s²", "mps3": "m/s³",
}  # fmt: skip


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the metric against the first swept name that an algorithm has; the others make lines of their own."""
    traces: list[Trace] = []
    names: list[str] = []
    for entry in view.entries:
        table = _wanted(entry.table("metrics"))
        swept = swept_columns(table)
        names += [name for name in swept if name not in names]
        if len(table) and swept:
            traces += _lines(entry, table, swept)
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    first = names[0]
    notes = [ChartNote("sweep", "Root mean square over all instants and trials; bars are 95 % intervals.")]
    values = np.concatenate([np.asarray(t["x"], float) for t in traces])
    positive = values.size > 0 and bool((values > 0).all()) and values.max() / values.min() >= 10
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=axis(_words(first), type="log" if positive else "linear", **_ticks(values)),
        yaxis=_error_axis(traces),
    )


def _words(name: str) -> str:
    """Title of the axis of a swept name: its words, and the unit that it ends with."""
    quantity, _, suffix = name.rpartition(".")[2].rpartition("_")
    if quantity and suffix in UNITS:
        return f"{quantity.replace('_', ' ')}, {UNITS[suffix]}"
    return name.rpartition(".")[2].replace("_", " ")


def _error_axis(traces: list[Trace]) -> dict[str, Any]:
    """Logarithmic where the errors differ much; within a few times a linear axis has the ticks to read them by."""
    title = "Horizontal error (rms), m"
    values = np.concatenate([np.asarray(t["y"], float) for t in traces])
    positive = values[values > 0]
    if positive.size and positive.max() < LINEAR_UP_TO * positive.min():
        return axis(title, rangemode="tozero")
    return log_axis(title, traces)


def _ticks(values: NDArray[np.float64]) -> dict[str, Any]:
    """A tick at every swept value where they are few: on a logarithmic axis plotly.js writes bare digits otherwise."""
    swept = np.unique(values[np.isfinite(values)])
    if swept.size > MOST_TICKS:
        return {}
    return {"tickmode": "array", "tickvals": swept, "ticktext": [f"{v:g}" for v in swept]}


def _wanted(table: Table) -> Table:
    """Rows of the metric over everything."""
    if not len(table):
        return table
    over_all = texts(table, "segment").are(None) & texts(table, "target").are(None)
    return table.take(texts(table, "metric").are(METRIC) & over_all)


def _numbers(table: Table, name: str) -> NDArray[np.float64]:
    column = table.columns[name]
    return np.asarray(column, float) if isinstance(column, np.ndarray) else np.full(len(table), np.nan)


def _lines(entry: Entry, table: Table, swept: list[str]) -> list[Trace]:
    """One line for each combination of the other swept values."""
    own = [n for n in swept if np.isfinite(_numbers(table, n)).any()]
    if not own:
        return []
    x = _numbers(table, own[0])
    others = [tuple(_numbers(table, n)[i] for n in own[1:]) for i in range(len(table))]
    out: list[Trace] = []
    different = list(dict.fromkeys(others))
    for k, values in enumerate(different):
        rows = np.array([i for i, o in enumerate(others) if o == values and np.isfinite(x[i])])
        if not rows.size:
            continue
        rows = rows[np.argsort(x[rows])]
        words = "".join(f", {n.rpartition('.')[2]} = {v:g}" for n, v in zip(own[1:], values, strict=True))
        look = line_of_variant(entry, k, len(different))
        value, low, high = (_numbers(table, n)[rows] for n in ("value", "ci95_low", "ci95_high"))
        bars: dict[str, Any] = {
            "type": "data",
            "symmetric": False,
            "array": np.nan_to_num(high - value),
            "arrayminus": np.nan_to_num(value - low),
            "width": 4,
        }
        out.append(
            trace(
                "series",
                x[rows],
                value,
                entry=entry,
                name=f"{entry.label}{words}",
                mode="lines+markers",
                line=look,
                marker=marker_of(entry, 6) | {"color": look["color"]},
                error_y=bars,
                hovertemplate=f"<b>{entry.label}{words}</b><br>%{{x:g}}: %{{y:,.4~r}} m<extra></extra>",
            )
        )
    return out


CHART = Chart(name="trials_sweep", title=TITLE, source="run", needs=("metrics",), draw=draw)
