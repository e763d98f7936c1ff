"""Shares of plots in the three ellipses of the tracking gate and just outside, beside 65, 30, 4.8 and 0.2 %.

Too many in the outer ring and the radar is worse than believed: 8 % at 1.25 times the errors, 15 % at twice. Plots of
`imm_tracker` are put into the ellipses by their distances. Those are of the nearer of two models that allow for
manoeuvres, so that with right accuracies 83, 17 and less than 1 % lie there (simulated: straight and manoeuvring
aircraft alike), 70, 27 and 3 % at 1.25 times the errors, 41, 39 and 20 % at twice.
"""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import Floats, numbers, words
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, meta, not_applicable
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Calibration of the gates"
CLASSES = ("inner", "middle", "outer ring", "outside")
EXPECTED = (0.65, 0.30, 0.048, 0.002)
EXPECTED_OF_MODELS = (0.83, 0.164, 0.006, 0.0)
# Probabilities of the inner two ellipses as distances of a two-dimensional Gaussian.
RADII = np.sqrt(-2.0 * np.log1p(-np.array([0.65, 0.95])))
DECIDED = {"updated": 0, "updated_middle": 1, "manoeuvre": 2}


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a group of bars for each entry and one for what is expected."""
    traces: list[Trace] = []
    notes: list[ChartNote] = []
    for entry in view.entries:
        shares, count = _shares(entry)
        if not count:
            continue
        notes.append(ChartNote("plots_counted", f"Of {counted(count, 'plot')} in tracking gates.", entry.label))
        bar = {
            "type": "bar",
            "x": list(CLASSES),
            "y": shares,
            "name": entry.label,
            "meta": meta("series", entry),
            "legendgroup": entry.label,
            "marker": {"color": theme.series_color(entry.index)},
            "hovertemplate": f"<b>{entry.label}</b><br>%{{x}}: %{{y:.3f}}<extra></extra>",
        }
        traces.append(bar)
    if not traces:
        return not_applicable(TITLE, "no_decisions")
    models = [entry for entry in view.entries if entry.algorithm == "imm_tracker"]
    if len(models) < len(view.entries):
        traces.append(_expected("expected", EXPECTED, theme.BOUND))
    if models:
        traces.append(_expected("expected of interacting models", EXPECTED_OF_MODELS, theme.BOUND, pattern="/"))
    return figure(
        TITLE,
        traces,
        recording=None,
        notes=notes,
        xaxis=axis("Plot of which ellipse", type="category"),
        yaxis=axis("Share", range=[0, 1]),
        barmode="group",
    )


def _expected(name: str, shares: tuple[float, ...], color: str, pattern: str = "") -> Trace:
    """Bars of right accuracies."""
    return {
        "type": "bar",
        "x": list(CLASSES),
        "y": np.array(shares),
        "name": name,
        "meta": meta("bound"),
        "marker": {"color": color, "pattern": {"shape": pattern}},
        "hovertemplate": f"<b>{name}</b><br>%{{x}}: %{{y:.3f}}<extra></extra>",
    }


def _shares(entry: Entry) -> tuple[Floats, int]:
    """Shares of the four classes, and of how many plots."""
    table = entry.table("decisions")
    decision, gate = words(table, "decision"), words(table, "gate")
    tracking = (gate == "tracking") & np.isin(decision, tuple(DECIDED))
    if not tracking.any():
        return np.zeros(4), 0
    if (decision == "updated_middle").any():
        classes = np.array([DECIDED[word] for word in decision[tracking].tolist()])
    else:
        classes = np.searchsorted(RADII, numbers(table, "distance")[tracking])
    outside = int(np.isfinite(numbers(table, "outside")).sum())
    count = int(tracking.sum()) + outside
    return np.append(np.bincount(classes, minlength=3)[:3], outside) / count, count


CHART = Chart(
    name="gate_calibration",
    title=TITLE,
    source="run",
    needs=("decisions",),
    draw=draw,
    kinds=("polar_plots",),
)
