"""Speed, course and normal acceleration of each track over time, with the regions of two standard deviations."""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import ChartNote, Trace, axis, figure, hover, line_of, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Speed and turn"
# Bands of more tracks than this hide each other.
BANDS = 6
HALF_TURN = 180.0


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw three panels over one axis of time."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    found = [(entry, estimates_of(entry)) for entry in view.entries]
    for entry, states in found:
        speed = states.numbers("speed_mps")
        if not np.isfinite(speed).any():
            continue
        sd = states.numbers("sigma_speed_mps")
        if int(states.starts.sum()) <= BANDS and np.isfinite(sd).any():
            traces += _bands(entry, states, speed, sd)
        traces += _curve(entry, states, speed, "y", "m/s", options, picked)
        traces += _curve(entry, states, states.numbers("course_deg"), "y2", "°", options, picked)
        normal = states.numbers("normal_acceleration_mps2")
        if np.isfinite(normal).any():
            traces += _curve(entry, states, normal, "y3", "m/s²", options, picked)
    if not traces:
        return not_applicable(TITLE, "no_states")
    layout: dict[str, Any] = {
        "yaxis": axis("V, m/s", domain=[0.7, 1.0]),
        "yaxis2": axis("Course, deg", domain=[0.35, 0.65]),
        "yaxis3": axis("a, m/s²", domain=[0.0, 0.3]),
    }
    note = ChartNote(
        "two_sigma",
        "Bands: two standard deviations as the tracker states them. From above: speed, course, acceleration across the "
        "path to the right.",
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[note],
        xaxis=time_axis(view.recording, anchor="y3"),
        **layout,
    )


def _curve(
    entry: Entry, states: Estimates, values: Floats, panel: str, unit: str, options: ChartOptions, picked: list[Picked]
) -> list[Trace]:
    starts = states.starts
    if unit == "°":
        # From 359 to 1 degree is no way back through all courses: the line begins anew.
        starts = starts.copy()
        starts[1:] |= np.abs(np.diff(values)) > HALF_TURN
    points = curve(states.time_s, (values,), starts, options.curve_points)
    picked.append(points)
    if points.of == 0:
        return []
    return [
        trace(
            "series",
            points.take(states.time_s),
            options.number(points.take(values)),
            entry=entry,
            name=entry.label,
            showlegend=panel == "y",
            mode="lines",
            line=line_of(entry),
            yaxis=panel,
            customdata=points.take(states.row),
            **hover(
                points,
                entry.label,
                f"%{{y:.3~f}} {unit}<br>%{{x:.3f}} s, row %{{customdata}}",
                [("track", states.words_at("track")), ("target", states.words_at("target"))],
            ),
        )
    ]


def _bands(entry: Entry, states: Estimates, speed: Floats, sd: Floats) -> list[Trace]:
    color = theme.series_color(entry.index)
    pieces = np.split(np.arange(speed.size), np.flatnonzero(states.starts)[1:])
    out_x: list[Floats] = []
    out_y: list[Floats] = []
    gap = np.array([np.nan])
    for piece in pieces:
        known = piece[np.isfinite(speed[piece] + sd[piece])]
        if known.size:
            out_x += [states.time_s[known], states.time_s[known][::-1], gap]
            out_y += [speed[known] - 2 * sd[known], (speed[known] + 2 * sd[known])[::-1], gap]
    if not out_x:
        return []
    return [
        trace(
            "interval",
            np.concatenate(out_x),
            np.concatenate(out_y),
            entry=entry,
            name=f"{entry.label}, two standard deviations",
            showlegend=False,
            mode="lines",
            line={"width": 0},
            fill="toself",
            fillcolor=theme.faint(color, theme.INTERVAL_OPACITY),
            hoverinfo="skip",
        )
    ]


CHART = Chart(
    name="track_motion",
    title=TITLE,
    source="run",
    needs=("states",),
    draw=draw,
    kinds=("polar_plots",),
    overlay="time",
)
