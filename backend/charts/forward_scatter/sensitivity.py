"""How many metres of the crossing distance a calibration error costs; residuals do not show such errors."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import numbers, words
from backend.charts.figure import ChartNote, Trace, axis, figure, meta, not_applicable
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "What calibration errors cost"
NAMES = {
    "clock": "clock of the second receiver",
    "frequency_offset": "frequency of the second receiver",
    "common_offset": "frequency of both",
    "spacing": "spacing",
    "base": "base line",
    "wavelength": "wavelength",
}


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a bar for each error and algorithm."""
    traces: list[Trace] = []
    for entry in view.entries:
        table = entry.table("sensitivities")
        if not len(table):
            continue
        error = numbers(table, "error_m")
        step = numbers(table, "step")
        labels = [
            f"{NAMES.get(q, q)}, {s:g} {u}"
            for q, s, u in zip(words(table, "quantity"), step, words(table, "step_unit"), strict=True)
        ]
        known = np.flatnonzero(np.isfinite(error))
        if not known.size:
            continue
        traces.append(
            {
                "type": "bar",
                "orientation": "h",
                "x": error[known].astype(np.float32),
                "y": [labels[i] for i in known],
                "name": entry.label,
                "legendgroup": entry.label,
                "marker": {"color": theme.series_color(entry.index)},
                "meta": meta("series", entry),
                "hovertemplate": f"<b>{entry.label}</b><br>%{{y}}: %{{x:.0f}} m<extra></extra>",
            }
        )
    if not traces:
        return not_applicable(TITLE, "no_sensitivities")
    text = (
        "Error of the crossing distance at the end of the last pass, as it was estimated. One pass cannot tell these "
        "errors from the target."
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("sensitivity", text)],
        xaxis=axis("Error, m", zeroline=True, zerolinecolor=theme.AXIS),
        yaxis=axis("Calibration error", autorange="reversed"),
        barmode="group",
    )


CHART = Chart(
    name="sensitivity", title=TITLE, source="run", needs=("sensitivities",), draw=draw, kinds=("doppler_pairs",)
)
