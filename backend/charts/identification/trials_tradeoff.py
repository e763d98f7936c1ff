"""Undecided against wrong: the rule of probabilities over its least one, beside the threshold rule over its tail."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import stats

from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.identification.samples import Floats, cells_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Undecided against wrong"
LEAST = np.concatenate([[0.5], np.linspace(0.52, 0.98, 24), [0.99, 0.995, 0.999]])
TAILS = np.geomspace(1e-5, 0.5, 40)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw both rules of every algorithm."""
    traces: list[Trace] = []
    for entry in view.entries:
        for cell in cells_of(entry):
            look = line_of_variant(entry, cell.variant, cell.variants)
            stated, right = cell.get("stated_probability", "stated_right")
            if stated.size:
                wrong = np.array([((stated >= p) & (right < 0.5)).mean() for p in LEAST])
                undecided = np.array([(stated < p).mean() for p in LEAST])
                name = f"{cell.name}, least probability"
                traces.append(_line(entry, name, undecided, wrong, LEAST, look, "p_min"))
            same, other = cell.get("statistic_same", "statistic_other")
            if same.size and entry.algorithm != "track_association":
                wrong, undecided = _threshold(same, other)
                name = f"{cell.name}, threshold rule"
                traces.append(_line(entry, name, undecided, wrong, TAILS, look | {"dash": "dot"}, "alpha"))
    if not traces:
        return not_applicable(TITLE, "no_single_values")
    text = (
        "Each line runs over the least probability that is accepted, from 0.5 to 0.999, or over the tail of the gate, "
        "from 0.5 to 0.00001; down and to the left is better. The threshold rule is that of two targets."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("tradeoff", text)],
        xaxis=axis("Share undecided", rangemode="tozero"),
        yaxis=axis("Share wrong", type="log"),
    )


def _threshold(same: Floats, other: Floats) -> tuple[Floats, Floats]:
    """Shares of wrong and undecided at each tail."""
    wrong, undecided = np.empty(TAILS.size), np.empty(TAILS.size)
    for k, threshold in enumerate(stats.chi2.isf(TAILS, 2)):
        inside, near = same <= threshold, other <= threshold
        wrong[k] = (~inside & near).mean()
        undecided[k] = (inside == near).mean()
    return wrong, undecided


def _line(
    entry: Entry, name: str, undecided: Floats, wrong: Floats, rule: Floats, look: dict[str, Any], word: str
) -> Trace:
    return trace(
        "series",
        undecided,
        np.where(wrong > 0, wrong, np.nan),
        entry=entry,
        name=name,
        mode="lines+markers",
        marker={"size": 3, "color": look["color"]},
        line=look,
        hovertext=[f"{word} = {value:.3g}" for value in rule],
        hovertemplate=f"<b>{name}</b><br>%{{hovertext}}<br>undecided %{{x:.4f}}, wrong %{{y:.2~g}}<extra></extra>",
    )


CHART = Chart(name="trials_tradeoff", title=TITLE, source="run", needs=(), draw=draw, kinds=("polar_plots",))
