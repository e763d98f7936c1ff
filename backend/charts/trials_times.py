"""What a sweep costs: time of computation of one trial against the swept value, a line for each algorithm."""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts.columns import Floats, numbers
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, marker_of, not_applicable, trace
from backend.charts.swept import title_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.trials_sweep import is_logarithmic, ticks
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Computing time against the swept value"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the time against the first swept number of each algorithm; the others make lines of their own."""
    traces: list[Trace] = []
    names: list[str] = []
    for entry in view.entries:
        swept = _numbers_swept(entry)
        names += swept[:1]
        traces += _lines(entry, swept) if swept else []
    if not traces:
        timed = any(len(entry.table("computing_times")) for entry in view.entries)
        return not_applicable(TITLE, "no_sweep" if timed else "no_times")
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


def _numbers_swept(entry: Entry) -> list[str]:
    """Swept names whose values are numbers, more than one of them."""
    table = entry.table("computing_times")
    columns = {name: table.columns[name] for name in swept_columns(table)}
    found = {name: np.unique(c[np.isfinite(c)]) for name, c in columns.items() if isinstance(c, np.ndarray)}
    return [name for name, values in found.items() if values.size > 1]


def _lines(entry: Entry, swept: list[str]) -> list[Trace]:
    """One line for each combination of the swept values but the first."""
    table = entry.table("computing_times")
    x, seconds = numbers(table, swept[0]), numbers(table, "seconds_per_trial")
    others: Floats = np.array([numbers(table, name) for name in swept[1:]]).reshape(len(swept) - 1, len(table))
    different = np.unique(others, axis=1).T if len(swept) > 1 else np.empty((1, 0))
    out = []
    for k, values in enumerate(different):
        rows = np.flatnonzero((others == values[:, None]).all(axis=0) & np.isfinite(x))
        rows = rows[np.argsort(x[rows])]
        words = "".join(f", {n.rpartition('.')[2]} = {v:g}" for n, v in zip(swept[1:], values, strict=True))
        look: dict[str, Any] = line_of_variant(entry, k, len(different))
        out.append(
            trace(
                "series",
                x[rows],
                seconds[rows],
                entry=entry,
                name=f"{entry.label}{words}",
                mode="lines+markers",
                line=look,
                marker=marker_of(entry, 6) | {"color": look["color"]},
                hovertemplate=f"<b>{entry.label}{words}</b><br>%{{x:g}}: %{{y:.3~r}} s<extra></extra>",
            )
        )
    return out


CHART = Chart(name="trials_times", title=TITLE, source="run", needs=("computing_times",), draw=draw, least_sweeps=1)
