"""Are stated probabilities true? How many of the pairs of each stated probability are right."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, marker_of, not_applicable, trace
from backend.charts.identification.samples import cells_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Reliability of the stated probabilities"
EDGES = np.array([0, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0 + 1e-9])
FEWEST = 5


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the observed share of right pairs against the mean stated probability of each bin."""
    traces: list[Trace] = []
    for entry in view.entries:
        for cell in cells_of(entry):
            stated, right = cell.get("stated_probability", "stated_right")
            which = np.digitize(stated, EDGES) - 1
            count = np.bincount(which, minlength=EDGES.size - 1)
            keep = np.flatnonzero(count >= FEWEST)
            if not keep.size:
                continue
            mean = np.array([stated[which == k].mean() for k in keep])
            share = np.array([right[which == k].mean() for k in keep])
            half = 1.96 * np.sqrt(np.maximum(share * (1 - share), 0.25 / count[keep]) / count[keep])
            look = line_of_variant(entry, cell.variant, cell.variants)
            traces.append(
                trace(
                    "series",
                    mean,
                    share,
                    entry=entry,
                    name=cell.name,
                    mode="lines+markers",
                    line=look,
                    marker=marker_of(entry, 6) | {"color": look["color"]},
                    error_y={"type": "data", "array": half, "width": 3},
                    hovertext=[f"{n} pairs" for n in count[keep]],
                    hovertemplate=f"<b>{cell.name}</b><br>stated %{{x:.4f}}, right %{{y:.4f}}<br>%{{hovertext}}"
                    "<extra></extra>",
                )
            )
    if not traces:
        return not_applicable(TITLE, "no_probabilities")
    line = {"color": theme.BOUND, "width": 1.2, "dash": "dash"}
    traces.append(trace("bound", np.array([0.0, 1.0]), np.array([0.0, 1.0]), name="honest", mode="lines", line=line))
    note = ChartNote("reliability", "Below the dashed line probabilities are stated too high; bars are 95 % intervals.")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[note],
        xaxis=axis("Probability as stated", range=[0.25, 1.02]),
        yaxis=axis("Share of right pairs", range=[0, 1.05]),
    )


CHART = Chart(name="trials_reliability", title=TITLE, source="run", needs=(), draw=draw, kinds=("polar_plots",))
