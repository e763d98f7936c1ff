"""Mean probability of each motion model over trials at each instant, stacked, for each algorithm with several."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, figure, not_applicable, time_axis, trace
from backend.charts.multiple_model.panels import MOST, panels
from backend.charts.trial_curves import Series, leg_shapes, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Probabilities of the models over trials"
PREFIX = "mode_probability_"
POINTS = 2000
OPACITY = 0.55


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a panel for each algorithm (and swept value), probabilities stacked from the first model up."""
    found = [series for series in series_of(view) if _names(series)]
    if not found:
        return not_applicable(TITLE, "no_models")
    shown = found if options.full else found[:MOST]
    traces: list[Trace] = []
    for i, series in enumerate(shown):
        traces += _areas(series, "" if i == 0 else str(i + 1), i, options)
    layout = panels([s.name for s in shown], [_models(s) for s in shown], "Mean probability", legs=bool(view.legs))
    shaded = leg_shapes(view.legs)
    layout["annotations"] += shaded.pop("annotations")
    notes = [ChartNote("stacked", "Stacked from the first model of the list; the sum is one.")]
    if len(shown) < len(found):
        notes.append(ChartNote("panels", f"{MOST} panels of {len(found)} are drawn; the table of curves has all."))
    last = "y" if len(shown) == 1 else f"y{len(shown)}"
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=time_axis(view.recording, anchor=last),
        **layout,
        **shaded,
    )


def _names(series: Series) -> list[str]:
    names = [n for n in series.columns if n.startswith(PREFIX) and not n.endswith(("_low", "_high"))]
    return [n for n in names if np.isfinite(series.numbers(n)).any()]


def _models(series: Series) -> list[str]:
    return [name.removeprefix(PREFIX) for name in _names(series)]


def _areas(series: Series, suffix: str, panel: int, options: ChartOptions) -> list[Trace]:
    step = 1 if options.full else max(1, series.time_s.size // POINTS)
    out = []
    for m, name in enumerate(_names(series)):
        model, color = name.removeprefix(PREFIX), theme.series_color(m)
        out.append(
            trace(
                "series",
                series.time_s[::step],
                options.number(series.numbers(name)[::step]),
                entry=series.entry,
                name=f"{series.name}, {model}",
                mode="lines",
                line={"width": 0.5, "color": color},
                fillcolor=theme.faint(color, OPACITY),
                stackgroup=f"models{panel}",
                yaxis=f"y{suffix}",
                hovertemplate=f"<b>{model}</b><br>%{{y:.3f}}<br>%{{x:.5~g}} s<extra>{series.name}</extra>",
            )
        )
    return out


CHART = Chart(name="trials_modes", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time",
              kinds=("antenna_plots",))  # fmt: skip
