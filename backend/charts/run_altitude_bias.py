"""What the decoded altitude differs by from the geometric height, as a filter estimates it, with its 95 % band."""

from __future__ import annotations

import numpy as np

from algorithms.recording import ToaMarks
from algorithms.toolbox.frames.earth import altitude_from_position, sphere, wgs84
from backend.charts import theme
from backend.charts.decimate import Picked, curve, thin
from backend.charts.estimates import estimates_of
from backend.charts.figure import ChartNote, Trace, axis, figure, hover, line_of, not_applicable, time_axis, trace
from backend.charts.run_altitude import MARK, SIGMAS, outline
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Altimeter bias"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the estimated bias of each track, and decoded less true altitude where the truth is known."""
    recording = view.recording
    if not isinstance(recording, ToaMarks):
        return not_applicable(TITLE, "other_kind")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for entry in view.entries:
        states = estimates_of(entry)
        bias, sd = states.numbers("altitude_bias_m"), states.numbers("altitude_bias_sd_m")
        reach = SIGMAS * sd
        band = curve(states.time_s, (bias - reach, bias + reach), states.starts, options.curve_points)
        if band.of == 0:
            continue
        x, y = outline(band, states.time_s, bias - reach, bias + reach)
        fill = theme.faint(theme.series_color(entry.index), theme.INTERVAL_OPACITY)
        traces.append(
            trace(
                "interval", x, options.number(y), entry=entry, name=f"{entry.label}, 95 % band", mode="lines",
                line={"width": 0}, fill="toself", fillcolor=fill, showlegend=False, hoverinfo="skip",
            )
        )  # fmt: skip
        points = curve(states.time_s, (bias,), states.starts, options.curve_points)
        picked.append(points)
        words = [("target", states.words_at("target"))]
        traces.append(
            trace(
                "series", points.take(states.time_s), options.number(points.take(bias)), entry=entry, name=entry.label,
                mode="lines", line=line_of(entry), customdata=points.take(states.row),
                **hover(points, entry.label, f"%{{y:.0f}} m<br>{MARK}", words),
            )
        )  # fmt: skip
    if not traces:
        return not_applicable(TITLE, "no_bias")
    traces = _true(recording, options, picked) + traces
    return figure(
        TITLE,
        traces,
        recording=recording,
        picked=picked,
        notes=[ChartNote("bias_of_altitude", "Decoded altitude less geometric height; the band holds 95 %.")],
        xaxis=time_axis(recording),
        yaxis=axis("Bias, m", zeroline=True, zerolinecolor=theme.AXIS),
    )


def _true(recording: ToaMarks, options: ChartOptions, picked: list[Picked]) -> list[Trace]:
    """Decoded less true altitude of each mark."""
    origin = None if recording.site is None else recording.site.frame_origin()
    height = altitude_from_position(recording.truth_m, sphere() if origin is None else wgs84(origin))
    off = recording.altitude_m[:, 0] - height
    points = thin(np.flatnonzero(np.isfinite(off)), options.marks)
    if points.of == 0:
        return []
    picked.append(points)
    name = "decoded less true"
    return [
        trace(
            "measurement", points.take(recording.time_s), options.number(points.take(off)), name=name, mode="markers",
            marker={"color": theme.MEASUREMENT, "size": 4}, customdata=points.take(recording.row),
            **hover(points, name, f"%{{y:.0f}} m<br>{MARK}"),
        )
    ]  # fmt: skip


CHART = Chart(
    name="altitude_bias", title=TITLE, source="run", needs=("states",), draw=draw, kinds=("toa_marks",)
)  # fmt: skip
