"""Probability plot: how much of the true pairs lies inside a gate that should hold a given share."""

from __future__ import annotations

import numpy as np
from scipy import stats

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.identification.samples import cells_of
from backend.charts.identification.trials_statistic import DOF
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Does the gate reject as many true pairs as it should?"
TAILS = np.geomspace(1e-3, 0.5, 60)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the share of rejected true pairs against the nominal tail; on the diagonal the claims are honest."""
    traces: list[Trace] = []
    for entry in view.entries:
        quantiles = stats.chi2.isf(TAILS, DOF.get(entry.algorithm, 2))
        for cell in cells_of(entry):
            (values,) = cell.get("statistic_same")
            if not values.size:
                continue
            beyond = 1 - np.searchsorted(np.sort(values), quantiles, side="right") / values.size
            traces.append(
                trace(
                    "series",
                    TAILS,
                    np.where(beyond > 0, beyond, np.nan),
                    entry=entry,
                    name=cell.name,
                    mode="lines",
                    line=line_of_variant(entry, cell.variant, cell.variants),
                    hovertemplate=f"<b>{cell.name}</b><br>%{{x:.3~g}}: %{{y:.3~g}}<extra></extra>",
                )
            )
    if not traces:
        return not_applicable(TITLE, "no_single_values")
    line = {"color": theme.BOUND, "width": 1.2, "dash": "dash"}
    traces.append(trace("bound", TAILS[[0, -1]], TAILS[[0, -1]], name="honest", mode="lines", line=line))
    note = ChartNote("gate_honesty", "Above the dashed line more true pairs are rejected than the tail says.")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[note],
        xaxis=axis("Probability in the tail, nominal", type="log"),
        yaxis=axis("Share of true pairs rejected", type="log"),
    )


CHART = Chart(name="trials_quantiles", title=TITLE, source="run", needs=(), draw=draw, kinds=("polar_plots",))
