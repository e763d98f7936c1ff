"""What a sweep shows: the rms horizontal error of all instants against the swept value, with 95 % intervals."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts.figure import ChartNote, Trace, axis, figure, line_of, log_axis, marker_of, not_applicable, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Error against the swept value"
METRIC = "rms_horizontal_m"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the metric against the first swept name that an algorithm has; the others make lines of their own."""
    traces: list[Trace] = []
    names: list[str] = []
    for entry in view.entries:
        table = _wanted(entry.table("metrics"))
        swept = [name for name in table.names if "." in name]
        names += [name for name in swept if name not in names]
        if len(table) and swept:
            traces += _lines(entry, table, swept, len(traces))
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    first = names[0]
    notes = [ChartNote("sweep", "Root mean square over all instants and trials; bars are 95 % intervals.")]
    words = first.rpartition(".")[2].replace("_", " ")
    values = np.concatenate([np.asarray(t["x"], float) for t in traces])
    positive = values.size > 0 and bool((values > 0).all()) and values.max() / values.min() >= 10
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=axis(words, type="log" if positive else "linear", dtick="D2" if positive else None),
        yaxis=log_axis("Horizontal error, m (rms)", traces),
    )


def _wanted(table: Table) -> Table:
    """Rows of the metric over everything."""
    if not len(table):
        return table
    keep = [
        i
        for i, (m, s, t) in enumerate(
            zip(table.columns["metric"], table.columns["segment"], table.columns["target"], strict=True)
        )
        if m == METRIC and not s and not t
    ]
    return Table({n: c[keep] if isinstance(c, np.ndarray) else [c[i] for i in keep] for n, c in table.columns.items()})


def _numbers(table: Table, name: str) -> NDArray[np.float64]:
    column = table.columns[name]
    return np.asarray(column, float) if isinstance(column, np.ndarray) else np.full(len(table), np.nan)


def _lines(entry: Entry, table: Table, swept: list[str], count: int) -> list[Trace]:
    """One line for each combination of the other swept values."""
    own = [n for n in swept if np.isfinite(_numbers(table, n)).any()]
    if not own:
        return []
    x = _numbers(table, own[0])
    others = [tuple(_numbers(table, n)[i] for n in own[1:]) for i in range(len(table))]
    out: list[Trace] = []
    for values in dict.fromkeys(others):
        rows = np.array([i for i, o in enumerate(others) if o == values and np.isfinite(x[i])])
        if not rows.size:
            continue
        rows = rows[np.argsort(x[rows])]
        words = "".join(f", {n.rpartition('.')[2]} = {v:g}" for n, v in zip(own[1:], values, strict=True))
        look = Entry(entry.label, count + len(out), entry.algorithm, entry.table, entry.arrays)
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
                entry=look,
                name=f"{entry.label}{words}",
                mode="lines+markers",
                line=line_of(look),
                marker=marker_of(look, 6),
                error_y=bars,
                hovertemplate=f"<b>{entry.label}{words}</b><br>%{{x:g}}: %{{y:,.4~r}} m<extra></extra>",
            )
        )
    return out


CHART = Chart(name="trials_sweep", title=TITLE, source="run", needs=("metrics",), draw=draw)
