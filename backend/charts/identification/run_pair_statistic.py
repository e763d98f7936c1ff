"""Squared distances of the pairs that were accepted or are most likely, against the chi-square law."""

from __future__ import annotations

import numpy as np
from scipy import stats

from backend.charts import theme
from backend.charts.columns import numbers, words
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, line_of, not_applicable, trace
from backend.charts.identification.trials_statistic import DOF
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Statistic of the pairs"
UPPER = 20.0
BINS = 40


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the density of the statistic of the pairs that were not rejected."""
    edges = np.linspace(0, UPPER, BINS + 1)
    middle = (edges[:-1] + edges[1:]) / 2
    traces: list[Trace] = []
    drawn: list[Entry] = []
    for entry in view.entries:
        table = entry.table("associations")
        decision = words(table, "decision")
        values = numbers(table, "statistic")[decision == "accepted"]
        values = values[np.isfinite(values)]
        if not values.size:
            continue
        drawn.append(entry)
        density = np.histogram(values, edges)[0] / values.size / (edges[1] - edges[0])
        traces.append(
            trace(
                "series",
                middle,
                density,
                entry=entry,
                name=f"{entry.label}, {counted(values.size, 'pair')}",
                mode="lines",
                line=line_of(entry) | {"shape": "hvh"},
                hovertemplate=f"<b>{entry.label}</b><br>%{{x:.3g}}: %{{y:.3~g}}<extra></extra>",
            )
        )
    if not traces:
        return not_applicable(TITLE, "no_pairs")
    # Tracks have a velocity too, so their distances follow another law than those of plots.
    for dof, dash in zip(sorted({DOF.get(entry.algorithm, 2) for entry in drawn}), ("solid", "dash"), strict=False):
        line = {"color": theme.BOUND, "width": 1.2, "dash": dash}
        law = stats.chi2.pdf(middle, dof)
        traces.append(
            trace("bound", middle, law, name=f"chi-square, {dof} degrees of freedom", mode="lines", line=line)
        )
    text = (
        "Of accepted pairs; to the right of the law (grey) the accuracies are claimed too good, or the radars "
        "disagree. Plots have two degrees of freedom, tracks four."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("pair_statistic", text)],
        xaxis=axis("Squared normalised distance", range=[0, UPPER]),
        yaxis=axis("Probability density", rangemode="tozero"),
    )


CHART = Chart(
    name="pair_statistic", title=TITLE, source="run", needs=("associations",), draw=draw, kinds=("polar_plots",)
)
