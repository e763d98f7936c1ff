"""Altitude above the Earth against height in the local frame: how far the Earth falls away below the plane.

A transponder reports altitude h, a filter in a local frame estimates height z; at 100 km from the origin h exceeds z
by 0.8 km. Who takes one for the other gets a position that is wrong by about as much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.frames.earth import altitude_from_position, sphere, wgs84
from backend.charts import theme
from backend.charts.columns import Floats, Ints, by_key_and_time
from backend.charts.decimate import Picked, curve, line_starts
from backend.charts.estimates import estimates_of
from backend.charts.figure import ChartNote, Trace, axis, figure, hover, line_of, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Altitude and height in the frame"
MARK = "%{x:.3f} s, row %{customdata}"
# Below this difference the two curves are one.
LEAST_DIFFERENCE_M = 1.0


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw altitude h as a line, height z as a dotted one: of each algorithm's tracks and of the true paths."""
    recording = view.recording
    origin = None if recording.site is None else recording.site.frame_origin()
    earth = sphere() if origin is None else wgs84(origin)
    traces: list[Trace] = []
    picked: list[Picked] = []
    differences: list[Floats] = []
    for entry in view.entries:
        states = estimates_of(entry)
        # Single fixes have no line, and their heights scatter by more than the two differ.
        if states.moving:
            position = np.stack([states.numbers(f"{name}_m") for name in ("east", "north", "up")], axis=1)
            targets = states.words_at("target")
            differences.append(
                _add(entry, position, states.time_s, states.starts, states.row, targets, earth, options, traces, picked)
            )
    order = by_key_and_time(recording.target, recording.time_s)
    differences.append(
        _add(
            None,
            recording.truth_m[order],
            recording.time_s[order],
            line_starts(recording.target[order], recording.time_s[order]),
            recording.row[order],
            np.array(recording.targets, object)[recording.target[order]],
            earth,
            options,
            traces,
            picked,
        )
    )
    known = np.concatenate(differences)
    if not known.size:
        return not_applicable(TITLE, "no_height")
    if np.abs(known).max() < LEAST_DIFFERENCE_M:
        return not_applicable(TITLE, "no_curvature")
    low, high = np.percentile(known, (1, 99))
    # A float that rounds to 0 from below would read -0.
    text = f"h exceeds z by {low + 0.0:.0f} to {high:.0f} m here."
    return figure(
        TITLE,
        traces,
        recording=recording,
        picked=picked,
        notes=[ChartNote("height_difference", text)],
        xaxis=time_axis(recording),
        yaxis=axis("Height, m"),
    )


def _add(
    entry: Entry | None,
    position_m: Floats,
    time_s: Floats,
    starts: NDArray[np.bool_],
    row: Ints,
    targets: NDArray[Any] | Callable[[Ints], NDArray[Any]],
    earth: Floats,
    options: ChartOptions,
    traces: list[Trace],
    picked: list[Picked],
) -> Floats:
    """Add both curves of an entry (None: of the true paths); return h - z where both are known."""
    altitude, height = altitude_from_position(position_m, earth), position_m[:, 2]
    points = curve(time_s, (altitude, height), starts, options.curve_points)
    if points.of == 0:
        return np.empty(0)
    picked.append(points)
    who = "true" if entry is None else entry.label
    for what, values in (("h", altitude), ("z", height)):
        name = f"{who}, {what}" if entry is not None else f"{who} {what}"
        line = {"color": theme.TRUTH, "width": 1, "dash": "dash"} if entry is None else line_of(entry)
        if what == "z":
            line = {**line, "dash": "dot", "width": 1}
        traces.append(
            trace(
                "truth" if entry is None else "series",
                points.take(time_s),
                options.number(points.take(values)),
                entry=entry,
                name=name,
                mode="lines",
                line=line,
                customdata=points.take(row),
                **hover(points, name, f"%{{y:.0f}} m<br>{MARK}", [("target", targets)]),
            )
        )
    difference = altitude - height
    return difference[np.isfinite(difference)]


CHART = Chart(name="height", title=TITLE, source="run", needs=("states",), draw=draw)
