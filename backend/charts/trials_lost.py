"""Share of trials without an estimate at each instant after the track's start."""

from __future__ import annotations

import numpy as np

from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, time_axis
from backend.charts.trial_curves import leg_shapes, line, means_over_targets, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Lost tracks over trials"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the share of lost tracks; an instant without an estimate after the start counts as lost."""
    found = [s for s in series_of(view) if np.isfinite(s.numbers("lost_share")).any()]
    if not found:
        return not_applicable(TITLE, "no_curves")
    if not any((s.numbers("lost_share") > 0).any() for s in found):
        return not_applicable(TITLE, "nothing_lost")
    picked: list[Picked] = []
    traces: list[Trace] = [
        line(series, series.name, 100 * series.numbers("lost_share"), options, picked, "%{y:.3~r} % lost")
        for series in found
    ]
    trials = counted(min(s.trials for s in found), "trial")
    text = f"Of {trials}: an instant without an estimate after the track's start counts as lost."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("lost_rule", text), *means_over_targets(found)],
        xaxis=time_axis(view.recording),
        yaxis=axis("Trials without an estimate, %", rangemode="tozero"),
        **leg_shapes(view.legs),
    )


CHART = Chart(name="trials_lost", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time")
