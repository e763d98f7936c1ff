"""What a sweep shows: the rms horizontal error of all instants against the swept value, with 95 % intervals."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts.columns import texts
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, marker_of, not_applicable, trace
from backend.charts.swept import title_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Error against the swept value"
METRIC = "rms_horizontal_m"
# Share of the axis between two ticks at least.
APART = 0.06
# Errors within this factor stand on a linear axis.
LINEAR_UP_TO = 10
VALUES = ("value", "ci95_low", "ci95_high")

Floats = NDArray[np.float64]


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the metric against the first swept name that an algorithm has; the others make lines of their own."""
    traces: list[Trace] = []
    names: list[str] = []
    for entry in view.entries:
        table = _wanted(entry.table("metrics"))
        swept = swept_columns(table)
        names += [name for name in swept if name not in names]
        if len(table) and swept:
            traces += lines_over(entry, table, swept)
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    values = np.concatenate([np.asarray(t["x"], float) for t in traces])
    traces += [t for entry in view.entries for t in _level(entry, _wanted(entry.table("metrics")), values)]
    log = is_logarithmic(values)
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("sweep", "Root mean square over all instants and trials; bars are 95 % intervals.")],
        xaxis=axis(title_of(names[0], view), type="log" if log else "linear", **ticks(values, log=log)),
        yaxis=_error_axis(traces),
    )


def is_logarithmic(values: Floats) -> bool:
    """Whether values over a decade or more lie better apart on a logarithmic axis."""
    swept = np.unique(values)
    if swept.size < 2 or swept[0] <= 0 or swept[-1] < 10 * swept[0]:
        return False
    gaps = [np.diff(places).min() / (places[-1] - places[0]) for places in (np.log10(swept), swept)]
    return bool(gaps[0] >= gaps[1])


def _error_axis(traces: list[Trace]) -> dict[str, Any]:
    """Logarithmic where the errors differ much; within a few times a linear axis has the ticks to read them by."""
    title = "Horizontal error (rms), m"
    values = np.concatenate([np.asarray(t["y"], float) for t in traces])
    positive = values[values > 0]
    if positive.size and positive.max() < LINEAR_UP_TO * positive.min():
        return axis(title, rangemode="tozero")
    return log_axis(title, traces)


def ticks(values: Floats, *, log: bool) -> dict[str, Any]:
    """A tick at every swept value that has room: on a logarithmic axis plotly.js writes bare digits otherwise."""
    swept = np.unique(values[np.isfinite(values)])
    places = np.log10(swept) if log else swept
    shown: list[int] = []
    for i, place in enumerate(places):
        if not shown or place - places[shown[-1]] >= APART * (places[-1] - places[0]):
            shown.append(i)
    chosen = swept[shown]
    return {"tickmode": "array", "tickvals": chosen.tolist(), "ticktext": [f"{v:g}" for v in chosen]}


def _wanted(table: Table) -> Table:
    """Rows of the metric over everything."""
    if not len(table):
        return table
    over_all = texts(table, "segment").are(None) & texts(table, "target").are(None)
    return table.take(texts(table, "metric").are(METRIC) & over_all)


def _numbers(table: Table, name: str) -> Floats:
    column = table.columns[name]
    return np.asarray(column, float) if isinstance(column, np.ndarray) else np.full(len(table), np.nan)


def _level(entry: Entry, table: Table, swept: Floats) -> list[Trace]:
    """An algorithm that is not swept itself and ran once stands as a level beside those that are."""
    if len(table) != 1 or any(np.isfinite(_numbers(table, name)).any() for name in swept_columns(table)):
        return []
    ends = np.array([swept.min(), swept.max()])
    return [_trace(entry, entry.label, ends, [np.repeat(_numbers(table, n), 2) for n in VALUES], "m", mode="lines")]


def lines_over(entry: Entry, table: Table, swept: list[str], unit: str = "m") -> list[Trace]:
    """Lines of `value` (bars from `ci95_low` to `ci95_high`) over the first swept number that the entry has.

    There is one line for each combination of the other swept values.
    """
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
        marker = marker_of(entry, 6) | {"color": look["color"]}
        found = [_numbers(table, n)[rows] for n in VALUES]
        out.append(_trace(entry, f"{entry.label}{words}", x[rows], found, unit, line=look, marker=marker))
    return out


def _trace(entry: Entry, name: str, x: Floats, found: list[Floats], unit: str, **look: Any) -> Trace:
    value, low, high = found
    bars: dict[str, Any] = {
        "type": "data",
        "symmetric": False,
        "array": np.nan_to_num(high - value),
        "arrayminus": np.nan_to_num(value - low),
        "width": 4,
    }
    more = {"error_y": bars} if np.isfinite(high - low).any() else {}
    line = {"mode": "lines+markers", "line": line_of_variant(entry, 0, 1)} | look
    hover = f"<b>{name}</b><br>%{{x:g}}: %{{y:,.4~r}} {unit}<extra></extra>"
    return trace("series", x, value, entry=entry, name=name, hovertemplate=hover, **more, **line)


CHART = Chart(name="trials_sweep", title=TITLE, source="run", needs=("metrics",), draw=draw, least_sweeps=1)
