"""A metric of each target against the first swept value: panels under each other, one for each target."""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts.columns import numbers, texts
from backend.charts.figure import Trace, axis, log_axis, marker_of, trace
from backend.charts.forward_scatter.panels import axis_number, stacked_axes
from backend.charts.swept import title_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.trials_sweep import ticks
from backend.charts.view import Entry, RunView, swept_columns

# More panels than these are too low to be read.
MOST_PANELS = 6
# Above each panel stands its target.
ROOM_FOR_NAME = 0.05


def targets_of(view: RunView, metric: str) -> list[str]:
    """Targets that have the metric, in the order of the table; one without a name stands for all."""
    found: list[str] = []
    for entry in view.entries:
        table = entry.table("metrics")
        if len(table) and swept_columns(table):
            names = table.take(texts(table, "metric").are(metric) & texts(table, "segment").are(None))
            found += [t or "" for t in texts(names, "target")]
    different = list(dict.fromkeys(found))
    named = [t for t in different if t]
    return (named or different)[:MOST_PANELS]


def lines_of(entry: Entry, metric: str, target: str, panel: int, along: str) -> list[Trace]:
    """One line for each combination of the other swept values; x is the parameter `along`, or the first."""
    table = entry.table("metrics")
    if not len(table):
        return []
    table = table.take(
        texts(table, "metric").are(metric)
        & texts(table, "segment").are(None)
        & texts(table, "target").are(target or None)
    )
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
            panels[f"yaxis{axis_number(i)}"] = log_axis(heading, mine, domain=own["domain"])
        else:
            own["range"] = [-0.03, 1.03]
        annotations.append(
            {"text": target, "x": 0, "xref": "paper", "xanchor": "left", "yanchor": "bottom", "yref": "paper",
             "y": own["domain"][1], "showarrow": False}
        )  # fmt: skip
    names = [name for entry in view.entries for name in swept_columns(entry.table("metrics"))]
    first = next((name for name in names if name.rpartition(".")[2] == along), names[0])
    values = np.concatenate([t["x"] for t in traces])
    below = axis(title_of(first, view), anchor=f"y{axis_number(len(targets) - 1)}", **ticks(values, log=False))
    return traces, panels | {"annotations": [one for one in annotations if one["text"]], "xaxis": below}
