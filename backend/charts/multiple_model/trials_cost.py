"""Vertical error of each stage against the arithmetic operations that a mark costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from algorithms.multiple_model.chains import operations_of
from algorithms.result import Table
from backend.charts import theme
from backend.charts.columns import Floats, numbers, texts, words
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, not_applicable, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Vertical error against operations"
METRIC = "rms_up_m"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a marker for each algorithm and stage; lines join the best of each cost."""
    costs = {entry.label: operations_of(entry.algorithm, entry.parameters) for entry in view.entries}
    found = {e.label: _errors(e.table("metrics")) for e in view.entries if costs[e.label] is not None}
    stages = list(dict.fromkeys(stage for errors in found.values() for stage in errors.stage))
    traces = [
        _markers(entry, float(costs[entry.label] or 0), stages, found[entry.label])
        for entry in view.entries
        if entry.label in found and found[entry.label].stage
    ]
    if not traces:
        return not_applicable(TITLE, "no_operations")
    if all(errors.words == errors.stage for errors in found.values()):
        traces += _joined(traces, stages)
    notes = [
        ChartNote("operations", "Operations of a mark as the method's page counts them; branches would save some.")
    ]
    if len(found) < len(view.entries):
        notes.append(ChartNote("not_counted", "Operations are counted for the paper's own sets of models only."))
    return figure(
        TITLE,
        traces,
        recording=None,
        notes=notes,
        legend=True,
        xaxis=axis("Number of operations of a mark", type="log", tickvals=sorted({float(t["x"][0]) for t in traces})),
        yaxis=log_axis("Vertical error (rms), m", traces),
    )


@dataclass(frozen=True)
class Errors:
    """Errors of an algorithm's stages with their 95 % intervals; of a sweep a stage stands once for each value."""

    stage: list[str]
    words: list[str]
    value: Floats
    low: Floats
    high: Floats


def _errors(table: Table) -> Errors:
    if not len(table):
        return Errors([], [], np.empty(0), np.empty(0), np.empty(0))
    stage = words(table, "segment")
    here = texts(table, "metric").are(METRIC) & (stage != "") & texts(table, "target").are("")
    rows = np.flatnonzero(here & np.isfinite(numbers(table, "value")))
    value, low, high = (numbers(table, name)[rows] for name in ("value", "ci95_low", "ci95_high"))
    swept = [(name, numbers(table, name)[rows]) for name in swept_columns(table)]
    said = [", ".join(f"{name.rpartition('.')[2]} = {column[k]:g}" for name, column in swept) for k in range(rows.size)]
    names = stage[rows].tolist()
    return Errors(names, [f"{n}, {s}" if s else n for n, s in zip(names, said, strict=True)], value, low, high)


def _markers(entry: Entry, cost: float, stages: list[str], errors: Errors) -> Trace:
    color = theme.series_color(entry.index)
    symbols = [theme.series_symbol(stages.index(stage)) for stage in errors.stage]
    return trace(
        "series",
        np.full(errors.value.size, cost),
        errors.value,
        entry=entry,
        name=entry.label,
        mode="markers",
        marker={"color": color, "size": 8, "symbol": symbols},
        error_y={"type": "data", "symmetric": False, "array": np.nan_to_num(errors.high - errors.value),
                 "arrayminus": np.nan_to_num(errors.value - errors.low), "color": color, "thickness": 1, "width": 3},
        text=errors.words,
        hovertemplate=f"<b>{entry.label}</b><br>%{{text}}: %{{y:,.4~r}} m<br>%{{x:,.0f}} operations<extra></extra>",
    )  # fmt: skip


def _joined(markers: list[Trace], stages: list[str]) -> list[Trace]:
    """A line for each stage through the best algorithm of each cost."""
    out = []
    for k, stage in enumerate(stages):
        points = sorted(
            (one["x"][i], one["y"][i]) for one in markers for i, said in enumerate(one["text"]) if said == stage
        )
        if not points:
            continue
        x, y = np.array([min(p for p in points if p[0] == cost) for cost in dict(points)], float).T
        look = {"color": theme.BOUND, "width": 1, "dash": theme.series_dash(k)}
        out.append(trace("bound", x, y, name=stage, mode="lines", line=look))
    return out


CHART = Chart(name="trials_cost", title=TITLE, source="run", needs=("metrics",), draw=draw,
              kinds=("antenna_plots",))  # fmt: skip
