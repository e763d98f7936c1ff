"""The squared distance of true pairs and of the nearest false ones over trials, against their laws."""

from __future__ import annotations

import numpy as np
from scipy import stats

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, trace
from backend.charts.identification.known_plots import tail_of
from backend.charts.identification.samples import cells_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Statistic of true and false pairs"
UPPER = 40.0
BINS = 80
DOF = {"track_association": 4}


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw densities: true pairs solid, the nearest false ones dotted, laws in grey."""
    edges = np.linspace(0, UPPER, BINS + 1)
    middle = (edges[:-1] + edges[1:]) / 2
    traces: list[Trace] = []
    most = 0
    for entry in view.entries:
        for cell in cells_of(entry):
            look = line_of_variant(entry, cell.variant, cell.variants)
            for name, word, dash in (("statistic_same", "true pairs", None), ("statistic_other", "false pairs", "dot")):
                (values,) = cell.get(name)
                if not values.size:
                    continue
                most = max(most, values.size)
                density = np.histogram(values, edges)[0] / values.size / (edges[1] - edges[0])
                line = look if dash is None else look | {"dash": dash}
                traces.append(
                    trace(
                        "series",
                        middle,
                        density,
                        entry=entry,
                        name=f"{cell.name}, {word}",
                        mode="lines",
                        line=line | {"shape": "hvh"},
                        hovertemplate=f"<b>{cell.name}, {word}</b><br>%{{x:.3g}}: %{{y:.3~g}}<extra></extra>",
                    )
                )
            traces += _law(cell.get("statistic_other")[0], middle, DOF.get(entry.algorithm, 2), cell.name)
    if not traces:
        return not_applicable(TITLE, "no_single_values")
    dof = DOF.get(view.entries[0].algorithm, 2)
    law = trace("bound", middle, stats.chi2.pdf(middle, dof), name=f"chi-square, {dof} degrees of freedom")
    lines = [
        trace(
            "bound",
            np.full(2, float(stats.chi2.isf(tail, dof))),
            np.array([0.0, 0.55]),
            name=f"threshold at alpha = {tail:g}",
        )
        for tail in sorted({tail_of(entry) for entry in view.entries})
    ]
    for one, dash in ((law, "solid"), *((line, "dash") for line in lines)):
        one |= {"mode": "lines", "line": {"color": theme.BOUND, "width": 1.2, "dash": dash}}
        traces.append(one)
    text = (
        f"Densities over {counted(most, 'value')}. Solid: the pair of one target; dotted: the nearest plot of another "
        "target, with the noncentral chi-square law of the same mean in grey."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("statistic", text)],
        xaxis=axis("Squared normalised distance", range=[0, UPPER]),
        yaxis=axis("Probability density", rangemode="tozero"),
    )


def _law(values: np.ndarray, middle: np.ndarray, dof: int, name: str) -> list[Trace]:
    """Noncentral chi-square with the mean of the values."""
    if not values.size:
        return []
    away = max(float(values.mean()) - dof, 0.0)
    if not 0 < away < 10 * UPPER:
        return []
    law = stats.ncx2.pdf(middle, dof, away)
    return [
        trace(
            "bound",
            middle,
            law,
            name=f"noncentral law of {name}",
            mode="lines",
            line={"color": theme.BOUND, "width": 1, "dash": "dot"},
            showlegend=False,
        )
    ]


CHART = Chart(name="trials_statistic", title=TITLE, source="run", needs=(), draw=draw, kinds=("polar_plots",))
