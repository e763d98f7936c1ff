"""Speed or acceleration over time: of each algorithm's tracks, and the true one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from algorithms.recording import Recording
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve, line_starts
from backend.charts.estimates import estimates_of
from backend.charts.figure import ChartNote, Trace, axis, figure, hover, line_of, not_applicable, time_axis, trace
from backend.charts.view import ChartOptions, Figure, RunView

MARK = "%{x:.3f} s, row %{customdata}"


@dataclass(frozen=True)
class Quantity:
    """What is drawn: the columns' prefix and unit in `states`, the words for it, why there may be none."""

    title: str
    axis: str
    prefix: str
    suffix: str
    unit: str
    missing: str
    derivative: bool
    """The truth is the derivative of its velocity."""


def draw_motion(view: RunView, options: ChartOptions, what: Quantity) -> Figure:
    """Draw the length of the vector: estimates as lines, the truth dashed. The view follows the truth."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    notes: list[ChartNote] = []
    for entry in view.entries:
        states = estimates_of(entry)
        parts = [states.numbers(f"{what.prefix}_{a}_{what.suffix}") for a in ("east", "north", "up")]
        values = np.sqrt(sum(part * part for part in parts))
        points = curve(states.time_s, (values,), states.starts, options.curve_points)
        if points.of == 0:
            continue
        picked.append(points)
        words = [("target", states.words_at("target")), ("track", states.words_at("track"))]
        traces.append(
            trace(
                "series", points.take(states.time_s), options.number(points.take(values)), entry=entry,
                name=entry.label, mode="lines", line=line_of(entry), customdata=points.take(states.row),
                **hover(points, entry.label, f"%{{y:,.4~r}} {what.unit}<br>{MARK}", words),
            )
        )  # fmt: skip
    if not traces:
        return not_applicable(what.title, what.missing)
    truth = _truth(view.recording, what)
    vertical = {}
    if np.isfinite(truth).any():
        _add_truth(view.recording, truth, what, options, traces, picked)
        # At its start a filter knows neither; what it says then would squeeze everything else.
        highest = 1.6 * float(np.nanmax(truth)) + 1.0
        lowest = max(0.0, 2.0 * float(np.nanmin(truth)) - highest) if not what.derivative else 0.0
        above = sum(int((np.asarray(t["y"], float) > highest).sum()) for t in traces)
        if above:
            vertical = {"range": [lowest, highest]}
            notes.append(ChartNote("above_view", "The first view follows the truth; a double click shows everything."))
    return figure(
        what.title, traces, recording=view.recording, picked=picked, notes=notes, xaxis=time_axis(view.recording),
        yaxis=axis(what.axis, rangemode="tozero", **vertical),
    )  # fmt: skip


def _truth(recording: Recording, what: Quantity) -> Floats:
    """(M,) length of the true vector; NaN where it is unknown."""
    vector = recording.truth_velocity_mps.copy()
    if what.derivative:
        for target in range(len(recording.targets)):
            rows = recording.rows_of(target)
            time = recording.time_s[rows]
            once = np.flatnonzero(np.append(True, np.diff(time) > 0))
            if once.size < 3:
                vector[rows] = np.nan
                continue
            slope = np.gradient(vector[rows][once], time[once], axis=0)
            vector[rows] = slope[np.cumsum(np.append(True, np.diff(time) > 0)) - 1]
    return np.asarray(np.linalg.norm(vector, axis=1))


def _add_truth(
    recording: Recording, truth: Floats, what: Quantity, options: ChartOptions, traces: list[Trace],
    picked: list[Picked],
) -> None:  # fmt: skip
    order = np.lexsort((recording.time_s, recording.target))
    time, values = recording.time_s[order], truth[order]
    points = curve(time, (values,), line_starts(recording.target[order], time), options.curve_points)
    picked.append(points)
    look = {"color": theme.TRUTH, "width": 1, "dash": "dash"}
    traces.append(
        trace(
            "truth", points.take(time), options.number(points.take(values)), name="truth", mode="lines", line=look,
            customdata=points.take(recording.row[order]),
            **hover(points, "truth", f"%{{y:,.4~r}} {what.unit}<br>{MARK}"),
        )
    )  # fmt: skip
