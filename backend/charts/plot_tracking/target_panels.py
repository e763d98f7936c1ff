"""A metric of each target against the first swept value: panels under each other, one for each target."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.result import Table
from backend.charts.columns import numbers, texts
from backend.charts.figure import Trace, axis, marker_of, trace
from backend.charts.forward_scatter.panels import axis_number, stacked_axes
from backend.charts.swept import title_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.trials_sweep import ticks
from backend.charts.view import Entry, RunView, swept_columns

# More panels than these are too low to be read: the targets with the largest differences have them.
MOST_PANELS = 3
# Above each panel stands its target.
ROOM_FOR_NAME = 0.07
LEAST = 1e-3


def targets_of(view: RunView, metric: str) -> list[str]:
    """Targets that have the metric, in the order of the table; one without a name stands for all."""
    found: list[str] = []
    for entry in view.entries:
        table = entry.table("metrics")
        if len(table) and swept_columns(table):
            names = table.take(texts(table, "metric").are(metric) & texts(table, "segment").are(None))
            found += [t or "" for t in texts(names, "target")]
    different = list(dict.fromkeys(found))
    named = [t for t in different if t] or different
    spread = {t: _spread(view, metric, t) for t in named}
    named = [t for t in named if spread[t] > LEAST] or named
    largest = sorted(named, key=lambda t: -spread[t])[:MOST_PANELS]
    return [t for t in named if t in largest]


def _spread(view: RunView, metric: str, target: str) -> float:
    """Between the smallest and the largest value of a target's metric."""
    values = np.concatenate([numbers(_rows_of(entry, metric, target), "value") for entry in view.entries])
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size else 0.0


def _rows_of(entry: Entry, metric: str, target: str) -> Table:
    table = entry.table("metrics")
    if not len(table):
        return table
    over_all = texts(table, "segment").are(None) & texts(table, "target").are(target or None)
    return table.take(texts(table, "metric").are(metric) & over_all)


def _log_axis(heading: str, traces: list[Trace], domain: list[float]) -> dict[str, Any]:
    """Logarithmic with few ticks: a panel is low. What is below a thousandth of a unit is nothing."""
    values = np.concatenate([np.asarray(t["y"], float) for t in traces])
    values = values[values > LEAST]
    if not values.size:
        return axis(heading, domain=domain)
    low, high = np.floor(np.log10(values.min())), np.ceil(np.log10(values.max()))
    every = max(1, int(np.ceil((high - low) / 3)))
    ticks_at = np.arange(low, high + 1, every)
    return axis(heading, type="log", domain=domain, range=[low - 0.1, high + 0.1], tickvals=10.0**ticks_at,
                ticktext=[f"{10.0**t:g}" for t in ticks_at])  # fmt: skip


def lines_of(entry: Entry, metric: str, target: str, panel: int, along: str) -> list[Trace]:
    """One line for each combination of the other swept values; x is the parameter `along`, or the first."""
    table = _rows_of(entry, metric, target)
    swept = [name for name in swept_columns(table) if np.isfinite(numbers(table, name)).any()]
    if not swept:
        return []
    first = next((name for name in swept if name.rpartition(".")[2] == along), swept[0])
    others = [name for name in swept if name != first]
    rows_of: dict[tuple[float, ...], list[int]] = {}
    for i in range(len(table)):
        rows_of.setdefault(tuple(float(numbers(table, n)[i]) for n in others), []).append(i)
    out = []
    for k, (values, members) in enumerate(rows_of.items()):
        rows = np.array(members)
        rows = rows[np.argsort(numbers(table, first)[rows])]
        words = "".join(f", {n.rpartition('.')[2]} = {v:g}" for n, v in zip(others, values, strict=True))
        look = line_of_variant(entry, k, len(rows_of))
        name = f"{entry.label}{words}"
        out.append(
            trace(
                "series",
                numbers(table, first)[rows],
                numbers(table, "value")[rows],
                entry=entry,
                name=name,
                mode="lines+markers",
                line=look,
                marker=marker_of(entry, 6) | {"color": look["color"]},
                yaxis=f"y{axis_number(panel)}",
                showlegend=panel == 0,
                hovertemplate=f"<b>{name}</b><br>{target} %{{x:g}}: %{{y:.4~g}}<extra></extra>",
            )
        )
    return out


def panels_of(
    view: RunView, metric: str, along: str, heading: str, *, log: bool = False
) -> tuple[list[Trace], dict[str, Any]]:
    """Traces, and the layout of their panels with the x axis below the lowest; nothing where nothing is swept."""
    targets = targets_of(view, metric)
    traces = [
        line
        for i, target in enumerate(targets)
        for entry in view.entries
        for line in lines_of(entry, metric, target, i, along)
    ]
    if not traces:
        return [], {}
    panels = stacked_axes([heading for _ in targets])
    annotations = []
    for i, target in enumerate(targets):
        own = panels[f"yaxis{axis_number(i)}"]
        bottom, top = own["domain"]
        own["domain"] = [bottom, top - ROOM_FOR_NAME]
        if log:
            mine = [t for t in traces if t["yaxis"] == f"y{axis_number(i)}"]
            panels[f"yaxis{axis_number(i)}"] = _log_axis(heading, mine, own["domain"])
        else:
            own |= {"range": [-0.03, 1.03], "tickvals": [0, 0.5, 1]}
        annotations.append(
            {"text": target, "x": 0, "xref": "paper", "xanchor": "left", "yanchor": "bottom", "yref": "paper",
             "y": own["domain"][1], "showarrow": False}
        )  # fmt: skip
    names = [name for entry in view.entries for name in swept_columns(entry.table("metrics"))]
    first = next((name for name in names if name.rpartition(".")[2] == along), names[0])
    values = np.concatenate([t["x"] for t in traces])
    below = axis(title_of(first, view), anchor=f"y{axis_number(len(targets) - 1)}", **ticks(values, log=False))
    return traces, panels | {"annotations": [one for one in annotations if one["text"]], "xaxis": below}
