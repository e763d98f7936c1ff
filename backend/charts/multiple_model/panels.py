"""Panels under each other in which probabilities of models are stacked, one for each algorithm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.figure import Trace, axis, trace
from backend.charts.view import Entry

MOST = 4
"""More could not be read."""
POINTS = 2000
"""Of a long recording every so many points the first one is drawn."""
OPACITY = 0.55
# Shares of the height: the names above a panel, and those of legs above all.
NAME, LEGS = 0.09, 0.1


def panels(names: Sequence[str], models: Sequence[Sequence[str]], quantity: str, *, legs: bool) -> dict[str, Any]:
    """Return axes `yaxis`, `yaxis2`, ... from the top down, and as `annotations` names, models in their colours."""
    top = 1 - (LEGS if legs else 0.0)
    height = top / len(names)
    out: dict[str, Any] = {"annotations": []}
    # Models come first: of a name too long for the panel the end is cut off.
    for i, (name, own) in enumerate(zip(names, models, strict=True)):
        bottom = top - (i + 1) * height
        end = bottom + height - NAME
        title = quantity if len(names) == 1 else "Share"
        more = {"tickvals": [0, 1]} if len(names) > 1 else {}
        out[f"yaxis{'' if i == 0 else i + 1}"] = axis(title, range=[0, 1], domain=[bottom, end], **more)
        said = [f'<span style="color:{theme.series_color(m)}">\u25a0</span> {model}' for m, model in enumerate(own)]
        out["annotations"].append(
            {"text": "  ".join([*said, f"<b>{name}</b>"]), "x": 0, "xref": "paper", "xanchor": "left", "y": end,
             "yref": "paper", "yanchor": "bottom", "showarrow": False, "font": {"size": 11}}
        )  # fmt: skip
    return out


def area(entry: Entry, name: str, panel: int, model: int, words: str, time_s: Floats, shares: Floats) -> Trace:
    """Area of one model in a panel (from 0), stacked on those of the models before it; `name` is whose it is."""
    color = theme.series_color(model)
    return trace(
        "series",
        time_s,
        shares,
        entry=entry,
        name=f"{name}, {words}",
        mode="lines",
        line={"width": 0.5, "color": color},
        fillcolor=theme.faint(color, OPACITY),
        stackgroup=f"models{panel}",
        yaxis=f"y{'' if panel == 0 else panel + 1}",
        hovertemplate=f"<b>{words}</b><br>%{{y:.3f}}<br>%{{x:.5~g}} s<extra>{name}</extra>",
    )
