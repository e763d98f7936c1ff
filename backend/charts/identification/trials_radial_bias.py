"""Which conversion pulls tracks towards the radar or away from it: their mean error along the line of sight."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, time_axis, trace
from backend.charts.identification.samples import line_over_scans
from backend.charts.trial_curves import leg_shapes, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Mean error of tracks along the line of sight"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the mean radial error of every algorithm after each scan."""
    traces: list[Trace] = []
    found = series_of(view)
    for series in found:
        values = series.numbers("radial_bias_m")
        if np.isfinite(values).any():
            traces.append(line_over_scans(series, series.name, values, "%{y:,.2f} m"))
    if not traces:
        return not_applicable(TITLE, "no_curves")
    ends = np.array([min(s.time_s[0] for s in found), max(s.time_s[-1] for s in found)])
    zero = {"color": theme.BOUND, "width": 1.2, "dash": "dash"}
    traces.append(trace("bound", ends, np.zeros(2), name="no bias", mode="lines", line=zero))
    text = (
        f"Over {counted(min(s.trials for s in found), 'trial')}, of the tracks of the radar that looks for a partner; "
        "above zero tracks lie too far from it."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("radial_bias", text)],
        xaxis=time_axis(view.recording),
        yaxis=axis("Mean error along the line of sight, m"),
        **leg_shapes(view.legs),
    )


CHART = Chart(
    name="trials_radial_bias", title=TITLE, source="run", needs=("curves",), draw=draw, kinds=("polar_plots",)
)
