"""One receiver: azimuths from the base line with what the estimate gives, and the angular velocity's fit."""

from __future__ import annotations

import numpy as np

from algorithms.recording import Recording
from algorithms.toolbox.frames.forward_scatter import scatter_frame
from backend.charts import theme
from backend.charts.decimate import Picked, curve, thin
from backend.charts.figure import Trace, axis, figure, line_of, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import broken, rows_of
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
    traces += _truth(view.recording)
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        xaxis=time_axis(view.recording),
        yaxis=axis("Azimuth from the base line, deg"),
    )


def _truth(recording: Recording) -> list[Trace]:
    """The true azimuths from the base line of the first receiver, which is the one that measures."""
    site = recording.site
    if not recording.has_truth or site is None or not site.transmitters or not site.receivers:
        return []
    places = site.terminal_positions()
    count = len(site.transmitters)
    frame = scatter_frame(places[:1], places[count : count + 1])
    place = frame.from_enu(recording.truth_m)
    true = np.degrees(np.arctan2(place[:, 1], place[:, 0]))
    known = np.flatnonzero(np.isfinite(true))
    if not known.size:
        return []
    # Within a pass the azimuth goes one way; another flight begins where it jumps.
    step = np.abs(np.diff(true[known]))
    begins = np.append(True, step > 5 * max(float(np.median(step)) if step.size else 0.0, 1e-9))
    return [
        trace(
            "truth",
            broken(recording.time_s[known], begins),
            broken(true[known], begins),
            name="true azimuth",
            mode="lines",
            line={"color": theme.TRUTH, "width": 1, "dash": "dash"},
            hovertemplate="<b>true azimuth</b><br>%{y:.3f} deg<br>%{x:.3f} s<extra></extra>",
        )
    ]


CHART = Chart(name="azimuth", title=TITLE, source="run", needs=("crossings",), draw=draw, kinds=("doppler_pairs",))
