"""What a longer base costs and brings: association against the accuracy of the fused position."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.identification.fused_bound import bound_over
from backend.charts.identification.samples import measured, swept_names
from backend.charts.identification.trials_probability import line_of_metric, ticks_of
from backend.charts.swept import title_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Association against fused accuracy"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the probability of a correct association (left) and the error of the fused position (right)."""
    traces: list[Trace] = []
    names: list[str] = []
    for entry in view.entries:
        traces += [line_of_metric(entry, one, "correct", "solid") for one in measured(entry, "probability_correct")]
        known = [one for one in measured(entry, "rms_horizontal_m") if np.isfinite(one.value).any()]
        traces += [line_of_metric(entry, one, "fused error", "dot", yaxis="y2") for one in known]
        names += swept_names(entry.table("metrics"))
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    x = np.unique(np.concatenate([np.asarray(t["x"], float) for t in traces]))
    limit = bound_over(view, names[0], x)
    if limit is not None:
        line = {"color": theme.BOUND, "width": 1.2, "dash": "dash"}
        traces.append(trace("bound", x, limit, name="bound of the fused error", mode="lines", line=line, yaxis="y2"))
    text = (
        "Solid, left: share of correct associations; dotted, right: rms error of the positions fused from correct "
        "pairs, dashed its Cramer-Rao bound. A longer base makes the one worse and the other better."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("base_tradeoff", text)],
        xaxis=axis(title_of(names[0], view), **ticks_of(names[0], x, view)),
        yaxis=axis("Probability of a correct association", range=[0, 1.02]),
        yaxis2=axis("Error of the fused position (rms), m", overlaying="y", side="right", rangemode="tozero",
                    showgrid=False),
    )  # fmt: skip


CHART = Chart(
    name="trials_base", title=TITLE, source="run", needs=("metrics",), draw=draw, kinds=("polar_plots",), least_sweeps=1
)
