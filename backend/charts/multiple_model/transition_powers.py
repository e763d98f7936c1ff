"""How likely each model is kept over an interval: the diagonal of P(dt), and where it ends."""

from __future__ import annotations

import numpy as np

from algorithms.multiple_model.chains import model_set_of
from algorithms.multiple_model.tracker import ModelSet
from algorithms.toolbox.filters.transition import transition_over
from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Probability to keep a model"
SHORTEST_S, LONGEST_S = 0.01, 100.0
POINTS = 161
DASHES = ("solid", "dash", "dot", "dashdot")


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a line for each model of each algorithm that has several; the level after endless time is dotted."""
    traces: list[Trace] = []
    notes: list[ChartNote] = []
    drawn: dict[ModelSet, str] = {}
    for entry in view.entries:
        chosen = model_set_of(entry.algorithm, entry.parameters)
        if chosen is None or len(chosen.models) < 2:
            continue
        # Rules and structures change nothing here.
        chain = ModelSet(chosen.models, chosen.transition, chosen.step_s, regions=chosen.regions)
        if chain in drawn:
            notes.append(ChartNote("same_chain", f"The same as of {drawn[chain]}.", entry.label))
            continue
        drawn[chain] = entry.label
        _add(entry, chain, traces, notes)
    if not traces:
        return not_applicable(TITLE, "no_models")
    return figure(
        TITLE,
        traces,
        recording=None,
        notes=notes,
        legend=True,
        xaxis=axis("Interval, s", type="log", range=np.log10([SHORTEST_S, LONGEST_S]).tolist()),
        yaxis=axis("Probability", range=[0, 1.02]),
    )


def _add(entry: Entry, chosen: ModelSet, traces: list[Trace], notes: list[ChartNote]) -> None:
    interval = np.geomspace(SHORTEST_S, LONGEST_S, POINTS)
    columns = np.array(chosen.transition).T
    kept = np.full((POINTS, len(chosen.models)), np.nan)
    for k, dt in enumerate(interval):
        matrix, clip = transition_over(columns, round(dt / chosen.step_s, 9))
        if np.isfinite(clip):
            kept[k] = np.diag(matrix)
    last = np.diag(transition_over(columns, 2**30)[0])
    for m, name in enumerate(chosen.names):
        color = theme.series_color(entry.index + m)
        look = {"color": color, "width": 1.5, "dash": DASHES[m % len(DASHES)]}
        words = f"<b>{entry.label}</b>, {name}<br>%{{y:.4f}} after %{{x:.3~g}} s<extra></extra>"
        if np.isfinite(kept[:, m]).any():
            traces.append(
                trace("series", interval, kept[:, m], entry=entry, name=f"{entry.label}, {name}", mode="lines",
                      line=look, hovertemplate=words)
            )  # fmt: skip
        traces.append(
            trace("bound", np.array([SHORTEST_S, LONGEST_S]), np.full(2, last[m]), entry=entry,
                  name=f"{entry.label}, {name}, in the end", mode="lines", showlegend=False,
                  line={"color": color, "width": 1, "dash": "dot"})
        )  # fmt: skip
    if np.isnan(kept[:, 0]).any():
        text = "Left out where the matrix has no power: its whole powers alone are probabilities."
        notes.append(ChartNote("no_power", text, entry.label))
    if chosen.regions:
        notes.append(ChartNote("regions", "Of the matrix outside all regions; a region has its own.", entry.label))


CHART = Chart(name="transition_powers", title=TITLE, source="run", needs=(), draw=draw,
              kinds=("antenna_plots", "polar_plots"), overlay="frame")  # fmt: skip
