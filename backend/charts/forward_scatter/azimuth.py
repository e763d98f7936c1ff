"""One receiver: azimuths from the base line with what the estimate gives, and the angular velocity's fit."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked, curve, thin
from backend.charts.figure import Trace, axis, figure, line_of, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import rows_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Azimuth from the base line"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw measured azimuths once, and of each method atan(omega (t - tau)) of every row."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    for entry in view.entries:
        rows = rows_of(entry, "crossings")
        if rows is None or not np.isfinite(rows.numbers("azimuth_deg")).any():
            continue
        measured = rows.numbers("azimuth_deg")
        if not any(t["meta"]["role"] == "measurement" for t in traces):
            points = thin(np.flatnonzero(np.isfinite(measured)), options.marks)
            picked.append(points)
            traces.append(
                trace(
                    "measurement",
                    points.take(rows.time_s),
                    options.number(points.take(measured)),
                    name="azimuth",
                    mode="markers",
                    marker={"color": theme.MEASUREMENT, "size": 5},
                    customdata=points.take(rows.row),
                    hovertemplate="<b>azimuth</b><br>%{y:.3f} deg<br>%{x:.3f} s, row %{customdata}<extra></extra>",
                )
            )
        fitted = np.degrees(np.arctan(rows.numbers("omega_rad_s") * (rows.time_s - rows.numbers("crossing_s"))))
        points = curve(rows.time_s, (fitted,), rows.breaks, options.curve_points)
        if points.of:
            picked.append(points)
            traces.append(
                trace(
                    "series",
                    points.take(rows.time_s),
                    options.number(points.take(fitted)),
                    entry=entry,
                    name=entry.label,
                    mode="lines",
                    line=line_of(entry),
                    hovertemplate=f"<b>{entry.label}</b><br>%{{y:.3f}} deg<br>%{{x:.3f}} s<extra></extra>",
                )
            )
    if not traces:
        return not_applicable(TITLE, "no_angular_velocity")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        xaxis=time_axis(view.recording),
        yaxis=axis("Azimuth from the base line, deg"),
    )


CHART = Chart(name="azimuth", title=TITLE, source="run", needs=("crossings",), draw=draw, kinds=("doppler_pairs",))
