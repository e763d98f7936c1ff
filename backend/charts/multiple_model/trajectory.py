"""Trajectory in space: of each algorithm's tracks and the true one, with its shadow on the ground."""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts import theme
from backend.charts.columns import Floats, by_key_and_time
from backend.charts.decimate import Picked, curve, line_starts
from backend.charts.estimates import estimates_of
from backend.charts.figure import ChartNote, Trace, figure, not_applicable, outside_view, trace
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Trajectory in space"
AXES = ("East, km", "North, km", "Up, km")
KM = 1e-3
# Beyond the middle 98 % of what is known by so much of their span points do not decide what is shown.
ROOM = 0.1
# Plotly's lines in space have no long dashes.
DASHES = {"longdash": "dash", "longdashdot": "dashdot"}


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw lines in space; the axes have scales of their own, and the view can be turned."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    for entry in view.entries:
        states = estimates_of(entry)
        place = np.stack([states.numbers(f"{axis}_m") for axis in ("east", "north", "up")])
        points = curve(states.time_s, tuple(place), states.starts, options.curve_points)
        if points.of:
            picked.append(points)
            look = {"color": theme.series_color(entry.index), "width": 4, "dash": _dash(entry.index)}
            traces.append(
                _line(
                    "series",
                    points,
                    place,
                    states.time_s,
                    states.row,
                    options,
                    entry=entry,
                    name=entry.label,
                    line=look,
                )
            )
    truth = _truth(view)
    known = truth[0][:, np.isfinite(truth[0]).all(axis=0)]
    if known.size:
        place, time, row, starts = truth
        points = curve(time, tuple(place), starts, options.curve_points)
        picked.append(points)
        look = {"color": theme.TRUTH, "width": 3, "dash": "dash"}
        traces.append(_line("truth", points, place, time, row, options, name="true path", line=look))
    elif traces:
        known = np.concatenate([np.stack([t[k] for k in "xyz"]).astype(float) / KM for t in traces], axis=1)
        known = known[:, np.isfinite(known).all(axis=0)]
    if not traces or not known.size:
        return not_applicable(TITLE, "no_states")
    ranges = [_range(values, exact=bool(np.isfinite(truth[0]).any())) for values in known]
    low = ranges[2][0]
    shadow = next((t for t in traces if t["meta"]["role"] == "truth"), traces[0])
    traces.append(shadow | {
        "z": np.where(np.isfinite(shadow["x"]), low, np.nan).astype(shadow["x"].dtype), "name": "on the ground",
        "meta": {"role": "bound", "label": None, "index": None}, "hoverinfo": "skip",
        "line": {"color": theme.BOUND, "width": 1},
    })  # fmt: skip
    for name in ("legendgroup", "hovertemplate"):
        traces[-1].pop(name, None)
    notes = [ChartNote("own_scales", "Each axis has a scale of its own. Drag to turn, turn the wheel to come nearer.")]
    everything = np.concatenate([np.stack([np.asarray(t[k], float) for k in "xyz"]) for t in traces], axis=1)
    everything = everything[:, np.isfinite(everything).all(axis=0)]
    out = np.any([(v < r[0]) | (v > r[1]) for v, r in zip(everything, ranges, strict=True)], axis=0)
    if out.any():
        notes.append(outside_view(int(out.sum()), out.size, "point"))
    scene: dict[str, Any] = {
        f"{letter}axis": {"title": {"text": title}, "range": span, "nticks": 6, "tickfont": {"size": 10}}
        for letter, title, span in zip("xyz", AXES, ranges, strict=True)
    }
    scene |= {"aspectmode": "manual", "aspectratio": {"x": 1, "y": 1.3, "z": 0.7}, "dragmode": "turntable",
              "camera": {"eye": {"x": 1.7, "y": -1.7, "z": 0.8}, "center": {"x": 0, "y": 0, "z": -0.15}}}  # fmt: skip
    return figure(TITLE, traces, recording=view.recording, picked=picked, notes=notes, scene=scene)


def _dash(index: int) -> str:
    dash = theme.series_dash(index)
    return DASHES.get(dash, dash)


def _line(
    role: Any, points: Picked, place: Floats, time_s: Floats, row: Any, options: ChartOptions, **properties: Any
) -> Trace:
    x, y, z = (options.number(points.take(values) * KM) for values in place)
    line = trace(
        role, x, y, mode="lines", z=z, customdata=points.take(row), text=points.take(time_s),
        hovertemplate="%{x:.3f} km east, %{y:.3f} km north, %{z:.3f} km up<br>%{text:.3f} s<extra></extra>",
        **properties,
    )  # fmt: skip
    return line | {"type": "scatter3d"}


def _truth(view: RunView) -> tuple[Floats, Floats, Any, Any]:
    """(3, M) true places in the order of targets and time, m, with times, rows and starts of pieces."""
    recording = view.recording
    order = by_key_and_time(recording.target, recording.time_s)
    time = recording.time_s[order]
    return recording.truth_m[order].T, time, recording.row[order], line_starts(recording.target[order], time)


def _range(values: Floats, *, exact: bool) -> list[float]:
    low, high = (values.min(), values.max()) if exact else np.percentile(values, (1, 99))
    margin = max(ROOM * (high - low), 100.0)
    return [float(low - margin) * KM, float(high + margin) * KM]


CHART = Chart(name="trajectory", title=TITLE, source="run", needs=("states",), draw=draw, kinds=("antenna_plots",))
