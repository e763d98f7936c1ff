"""Probabilities of the pairs of one look as a matrix, with a column and a row for "none" (∅) and the accepted pairs."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import numbers, words
from backend.charts.figure import ChartNote, Trace, axis, figure, meta, not_applicable, trace
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Probabilities of the pairs of one look"
# Larger looks are cut: labels could not be read.
MOST_PLOTS = 60
# Also for who reads no English.
NONE = "∅"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the look with the most doubt of the first algorithm that states probabilities."""
    for entry in view.entries:
        table = entry.table("associations")
        probability = numbers(table, "probability")
        if not np.isfinite(probability).any():
            continue
        look = numbers(table, "look")
        decision = words(table, "decision")
        # Of three radars and more each two have a matrix of their own.
        both = zip(words(table, "radar_1"), words(table, "radar_2"), strict=True)
        radars = [f"{one} | {other}" for one, other in both]
        names, number = np.unique(radars, return_inverse=True)
        which = look * names.size + number
        chosen = _most_doubtful(which, probability)
        rows = np.flatnonzero((which == chosen) & np.isfinite(probability))
        one, other = (str(words(table, f"radar_{side}")[rows[0]]) for side in (1, 2))
        first, second = numbers(table, "row_1")[rows], numbers(table, "row_2")[rows]
        a, b = np.unique(first)[:MOST_PLOTS], np.unique(second)[:MOST_PLOTS]
        z = np.zeros((a.size + 1, b.size + 1))
        for i, j, p in zip(first, second, probability[rows], strict=True):
            if i in a and j in b:
                z[np.searchsorted(a, i), np.searchsorted(b, j)] = p
        z[:-1, -1] = np.clip(1 - z[:-1, :-1].sum(axis=1), 0, 1)
        z[-1, :-1] = np.clip(1 - z[:-1, :-1].sum(axis=0), 0, 1)
        z[-1, -1] = np.nan
        y = [f"{int(v)}" for v in a] + [NONE]
        traces: list[Trace] = [
            {
                "type": "heatmap",
                "x": np.arange(b.size + 2) - 0.5,
                "y": y,
                "z": z,
                "zmin": 0,
                "zmax": 1,
                "colorscale": [[i / 5, c] for i, c in enumerate(theme.SEQUENCE)],
                "colorbar": {"title": {"text": "P"}, "thickness": 12},
                "name": entry.label,
                "meta": meta("series", entry),
                "hovertemplate": "%{y}: %{z:.4f}<extra></extra>",
            }
        ]
        taken = [k for k in rows if decision[k] == "accepted"]
        pairs = [(i, j) for i, j in zip(numbers(table, "row_1")[taken], numbers(table, "row_2")[taken], strict=True)
                 if i in a and j in b]  # fmt: skip
        if pairs:
            marker = {"color": theme.SERIES[1], "size": 9, "symbol": "circle-open", "line": {"width": 2}}
            x = np.searchsorted(b, [j for _, j in pairs]).astype(float)
            traces.append(
                trace("truth", x, [f"{int(i)}" for i, _ in pairs], name="accepted", mode="markers", marker=marker)
            )
        text = (
            f"Of {entry.label}, look {int(look[rows[0]])}, the one with the most doubt; rows are plots of radar {one}, "
            f"columns those of radar {other}, by their row numbers."
        )
        return figure(
            TITLE,
            traces,
            recording=view.recording,
            notes=[ChartNote("most_doubtful_look", text)],
            xaxis=axis("Plot of the second radar", tickmode="array", tickvals=np.arange(b.size + 1),
                       ticktext=[f"{int(v)}" for v in b] + [NONE]),
            yaxis=axis("Plot of the first radar", type="category", autorange="reversed"),
        )  # fmt: skip
    return not_applicable(TITLE, "no_probabilities")


def _most_doubtful(look: np.ndarray, probability: np.ndarray) -> float:
    """The number with the largest entropy of its pairs."""
    p = np.clip(np.nan_to_num(probability), 1e-300, 1.0)
    entropy = -p * np.log(p)
    numbers_of, which = np.unique(look, return_inverse=True)
    return float(numbers_of[np.argmax(np.bincount(which, entropy))])


CHART = Chart(
    name="association_matrix", title=TITLE, source="run", needs=("associations",), draw=draw, kinds=("polar_plots",)
)
