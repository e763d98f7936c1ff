"""Stacked bars: correct, wrong and both kinds of undecided, by algorithm and target, beside the printed table."""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.identification.samples import numbers, rows_of, swept_names
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Correct, wrong, undecided"
PRINTED_UNDECIDED = "printed"
# Metric, word, colour, pattern. The two kinds of undecided share a colour and differ in their hatching.
PARTS = (
    ("probability_correct", "correct", "#009E73", ""),
    ("probability_wrong", "wrong", "#D55E00", ""),
    ("probability_undecided_none", "undecided, none inside", "#8a929b", "/"),
    ("probability_undecided_several", "undecided, several or too uncertain", "#8a929b", "x"),
    # The paper does not tell the two kinds apart.
    (PRINTED_UNDECIDED, "undecided, as printed", "#c4c9cf", ""),
)
# Table 1 of the paper: correct, wrong, undecided of targets 1 and 2.
PRINTED = {
    "lin": ((0.674, 0.010, 0.316), (0.342, 0.008, 0.650)),
    "paper": ((0.631, 0.009, 0.360), (0.649, 0.004, 0.347)),
}
MOST_BARS = 40
# So many have room for the name of each.
NAMED_BARS = 14


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a bar for each algorithm, swept value and target."""
    names: list[str] = []
    values: dict[str, list[float]] = {metric: [] for metric, *_ in PARTS}
    intervals: list[tuple[float, float]] = []
    targets = sorted({t for e in view.entries for t in e.table("metrics").columns.get("target", ()) if t})
    bars = sum(rows_of(e.table("metrics"), "probability_correct", t).size for e in view.entries for t in targets)
    if not 0 < len(targets) <= 2 or bars > MOST_BARS:
        # Of many targets, or of many swept values, only all targets together.
        targets = [""]
    one_look = len(view.recording) > 0 and np.ptp(view.recording.time_s) == 0
    for entry in view.entries:
        table = entry.table("metrics")
        # The paper's numbers are of its test on single plots.
        beside = one_look and entry.algorithm == "pairwise_test"
        for target in targets:
            correct = rows_of(table, "probability_correct", target)
            swept = swept_names(table)
            for i in correct.tolist():
                words = "".join(f", {n.rpartition('.')[2]} = {numbers(table, n)[i]:g}" for n in swept)
                names.append(f"{entry.label}{words}" + (f", target {target}" if target else ""))
                intervals.append((numbers(table, "ci95_low")[i], numbers(table, "ci95_high")[i]))
                same = {n: numbers(table, n)[i] for n in swept}
                for metric, *_ in PARTS:
                    values[metric].append(_value(table, metric, target, same))
            if beside and entry.label in PRINTED and target in ("1", "2") and not swept:
                right, wrong, undecided = PRINTED[entry.label][int(target) - 1]
                names.append(f"{entry.label}, target {target}, printed")
                intervals.append((np.nan, np.nan))
                for (metric, *_), share in zip(PARTS, (right, wrong, 0.0, 0.0, undecided), strict=True):
                    values[metric].append(share)
    if not names or len(names) > MOST_BARS:
        return not_applicable(TITLE, "no_decisions" if not names else "too_many_bars")
    notes = [ChartNote("decisions", "Whiskers are 95 % intervals of the share of correct decisions.")]
    if any(name.endswith("printed") for name in names):
        text = (
            "The printed row of the linearised method for target 2 does not come about for any placement; with its "
            "first and last number exchanged it would fit. That is a hypothesis, not a proof."
        )
        notes.append(ChartNote("printed_table", text))
    traces: list[Trace] = []
    for metric, word, color, shape in PARTS:
        if metric == PRINTED_UNDECIDED and not any(values[metric]):
            continue
        marker: dict[str, Any] = {"color": color}
        if shape:
            # Over the bar's own colour, or nothing of it would be seen on a dark page.
            marker["pattern"] = {
                "shape": shape,
                "fillmode": "overlay",
                "fgcolor": "#ffffff",
                "size": 5,
                "solidity": 0.2,
            }
        bar = trace("series", np.array(values[metric]), names, name=word, type="bar", orientation="h", marker=marker)
        if metric == "probability_correct":
            correct_share = np.array(values[metric])
            low, high = (np.array([pair[k] for pair in intervals]) for k in (0, 1))
            bar["error_x"] = {
                "type": "data",
                "symmetric": False,
                "array": np.nan_to_num(high - correct_share),
                "arrayminus": np.nan_to_num(correct_share - low),
                "thickness": 1.2,
                "width": 3,
            }
        traces.append(bar | {"hovertemplate": f"%{{y}}<br>{word}: %{{x:.3f}}<extra></extra>"})
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        barmode="stack",
        xaxis=axis("Share of the plots", range=[0, 1.001]),
        yaxis=axis("Algorithm and target", autorange="reversed", **({"dtick": 1} if len(names) <= NAMED_BARS else {})),
    )


def _value(table: Any, metric: str, target: str, same: dict[str, float]) -> float:
    for i in rows_of(table, metric, target).tolist():
        if all(numbers(table, n)[i] == v for n, v in same.items()):
            return float(np.nan_to_num(numbers(table, "value")[i]))
    if metric == "probability_undecided_none" and not rows_of(table, metric, target).size:
        return _value(table, "probability_undecided", target, same)
    return 0.0


CHART = Chart(name="trials_decisions", title=TITLE, source="run", needs=("metrics",), draw=draw, kinds=("polar_plots",))
