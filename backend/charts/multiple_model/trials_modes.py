"""Mean probability of each motion model over trials at each instant, stacked, for each algorithm with several."""

from __future__ import annotations

import numpy as np

from backend.charts.figure import ChartNote, Trace, figure, not_applicable, time_axis
from backend.charts.multiple_model.panels import MOST, POINTS, area, panels
from backend.charts.trial_curves import Series, leg_shapes, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Probabilities of the models over trials"
PREFIX = "mode_probability_"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a panel for each algorithm (and swept value), probabilities stacked from the first model up."""
    found = [series for series in series_of(view) if _names(series)]
    if not found:
        return not_applicable(TITLE, "no_models")
    shown = found if options.full else found[:MOST]
    traces: list[Trace] = []
    for i, series in enumerate(shown):
        traces += _areas(series, i, options)
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


def _areas(series: Series, panel: int, options: ChartOptions) -> list[Trace]:
    step = 1 if options.full else max(1, series.time_s.size // POINTS)
    time_s = series.time_s[::step]
    return [
        area(
            series.entry,
            series.name,
            panel,
            m,
            name.removeprefix(PREFIX),
            time_s,
            options.number(series.numbers(name)[::step]),
        )
        for m, name in enumerate(_names(series))
    ]


CHART = Chart(name="trials_modes", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time",
              kinds=("antenna_plots",))  # fmt: skip
