"""What a sweep costs: time of computation of one trial against the swept value, a line for each algorithm."""

from __future__ import annotations

import numpy as np

from algorithms.result import GivenColumn, Table
from backend.charts.columns import numbers
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, not_applicable
from backend.charts.swept import title_of
from backend.charts.trials_sweep import is_logarithmic, lines_over, ticks
from backend.charts.view import Chart, ChartOptions, Figure, RunView, swept_columns

TITLE = "Computing time against the swept value"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the time against the first swept number of each algorithm; the others make lines of their own."""
    traces: list[Trace] = []
    names: list[str] = []
    tables = [entry.table("computing_times") for entry in view.entries]
    for entry, table in zip(view.entries, tables, strict=True):
        swept = swept_columns(table)
        names += swept
        if len(table):
            unknown = np.full(len(table), np.nan)
            columns: dict[str, GivenColumn] = {name: table.columns[name] for name in swept}
            columns |= {"value": numbers(table, "seconds_per_trial"), "ci95_low": unknown, "ci95_high": unknown}
            traces += lines_over(entry, Table(columns), swept, "s")
    if not traces:
        return not_applicable(TITLE, "no_sweep" if any(map(len, tables)) else "no_times")
    values = np.concatenate([np.asarray(t["x"], float) for t in traces])
    log = is_logarithmic(values)
    note = "Filtering and scoring on one processor, as it was in this run; other work of the machine counts."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("computing_time", note)],
        xaxis=axis(title_of(names[0], view), type="log" if log else "linear", **ticks(values, log=log)),
        yaxis=log_axis("Time of one trial, s", traces),
    )


CHART = Chart(name="trials_times", title=TITLE, source="run", needs=("computing_times",), draw=draw, least_sweeps=1)
