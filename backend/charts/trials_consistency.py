"""NEES and NIS over trials at each instant, per degree of freedom, with the 95 % chi-square band of so many."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, counted, figure, log_axis, not_applicable, time_axis, trace
from backend.charts.trial_curves import leg_shapes, line, means_over_targets, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Honesty of the claims over trials (NEES, NIS)"
STATISTICS = {"nees": "NEES", "nis": "NIS"}


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw both statistics: within the band the claims are honest, above it they are too small."""
    found = series_of(view)
    traces: list[Trace] = []
    picked: list[Picked] = []
    for statistic, word in STATISTICS.items():
        for series in found:
            values = series.numbers(statistic)
            if np.isfinite(values).any():
                look = {"width": 2} if statistic == "nees" else {"width": 1, "dash": "dot"}
                traces.append(line(series, f"{series.name}, {word}", values, options, picked, "%{y:,.3~r}", **look))
    if not traces:
        return not_applicable(TITLE, "no_curves")
    for side in ("low", "high"):
        limit = found[0].numbers(f"nees_{side}")
        if np.isfinite(limit).any():
            look = {"color": theme.BOUND, "dash": "dot", "width": 1}
            traces.append(
                trace("bound", found[0].time_s, limit, name=f"95 % band of NEES, {side}", mode="lines", line=look)
            )
    text = (
        f"Per degree of freedom over {counted(min(s.trials for s in found), 'trial')}: 1 is honest, above the band the "
        "algorithm claims smaller errors than it makes. NIS is dotted; the grey band is that of NEES."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("honesty", text), *means_over_targets(found)],
        xaxis=time_axis(view.recording),
        yaxis=log_axis("NIS, NEES / dof", traces),
        **leg_shapes(view.legs),
    )


CHART = Chart(name="trials_consistency", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time")
