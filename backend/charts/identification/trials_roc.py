"""How well the squared distance tells true pairs from false ones, whatever the threshold: the operating curve."""

from __future__ import annotations

import numpy as np
from scipy import stats

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, marker_of, not_applicable, trace
from backend.charts.identification.known_plots import tail_of
from backend.charts.identification.samples import Floats, cells_of
from backend.charts.identification.trials_statistic import DOF
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "True pairs accepted against false pairs accepted"
POINTS = 200


def operating_curve(same: Floats, other: Floats) -> tuple[Floats, Floats, float]:
    """Shares of false and of true pairs below each threshold, and the area under the curve."""
    ordered = np.sort(other)
    # The share of false pairs below each true one, ties counted half, is one less the area (Mann and Whitney).
    below = (np.searchsorted(ordered, same, "left") + np.searchsorted(ordered, same, "right")) / (2 * other.size)
    thresholds = np.quantile(np.concatenate([same, other]), np.linspace(0, 1, POINTS))
    true = np.searchsorted(np.sort(same), thresholds, "right") / same.size
    false = np.searchsorted(ordered, thresholds, "right") / other.size
    return np.concatenate([[0.0], false]), np.concatenate([[0.0], true]), float(1 - below.mean())


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a curve for each algorithm and swept value, with the point of its gate."""
    traces: list[Trace] = []
    for entry in view.entries:
        threshold = float(stats.chi2.isf(tail_of(entry), DOF.get(entry.algorithm, 2)))
        for cell in cells_of(entry):
            same, other = cell.get("statistic_same", "statistic_other")
            if not same.size:
                continue
            false, true, area = operating_curve(same, other)
            look = line_of_variant(entry, cell.variant, cell.variants)
            name = f"{cell.name}, area {area:.4f}"
            traces.append(
                trace(
                    "series",
                    false,
                    true,
                    entry=entry,
                    name=name,
                    mode="lines",
                    line=look,
                    hovertemplate=f"<b>{cell.name}</b><br>false %{{x:.4f}}, true %{{y:.4f}}<extra></extra>",
                )
            )
            at = np.array([[(other <= threshold).mean()], [(same <= threshold).mean()]])
            traces.append(
                trace(
                    "series",
                    at[0],
                    at[1],
                    entry=entry,
                    name=f"{cell.name}, its gate",
                    mode="markers",
                    marker=marker_of(entry, 8) | {"color": look["color"]},
                    showlegend=False,
                    hovertemplate=f"<b>{cell.name}</b><br>false %{{x:.4f}}, true %{{y:.4f}}<extra></extra>",
                )
            )
    if not traces:
        return not_applicable(TITLE, "no_single_values")
    line = {"color": theme.BOUND, "width": 1.2, "dash": "dash"}
    ends = np.array([0.0, 1.0])
    traces.append(trace("bound", ends, ends, name="no better than chance", mode="lines", line=line))
    text = "Up and to the left is better; the marker is the gate of the run. False: the nearest plot of another target."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("operating_curve", text)],
        xaxis=axis("Share of false pairs accepted", range=[-0.01, 1.01]),
        yaxis=axis("Share of true pairs accepted", range=[-0.01, 1.02]),
    )


CHART = Chart(name="trials_roc", title=TITLE, source="run", needs=(), draw=draw, kinds=("polar_plots",))
