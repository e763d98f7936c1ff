"""Radial error of each algorithm: the distance in the plane between estimate and truth, on a logarithmic axis.

The article's figure 7. What an algorithm claims stands in the chart `drms`; this one compares algorithms.
"""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.actual import CURVES, MARK, actual_errors, zeros_left_out
from backend.charts.bins import TimeBins, time_bins
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve, thin
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import (
    ChartNote,
    Trace,
    counted,
    crowd_opacity,
    figure,
    hover,
    line_of,
    log_axis,
    marker_of,
    not_applicable,
    time_axis,
    trace,
)
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Radial error"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the errors of few tracks as lines, those of many as medians with the middle 90 %."""
    found = [
        (entry, states, actual_errors(entry, states)) for entry in view.entries for states in [estimates_of(entry)]
    ]
    if not any((error > 0).any() for _, _, error in found):
        return not_applicable(TITLE, "no_truth")
    bins = time_bins(view.time_s)
    in_bins = any(np.count_nonzero((error > 0) & states.starts) > CURVES for _, states, error in found)
    traces: list[Trace] = []
    picked: list[Picked] = []
    notes: list[ChartNote] = []
    for entry, states, error in found:
        known = error[np.isfinite(error)]
        if not known.size:
            continue
        notes += zeros_left_out(entry, error)
        if in_bins:
            traces += _bins(entry, states, error, bins, options)
        else:
            traces += _single(entry, states, error, options, picked)
        median, high = np.percentile(known, (50, 95))
        text = f"Median {median:.3g} m, 95 % below {high:.3g} m, of {counted(known.size, 'mark')}."
        notes.append(ChartNote("error_summary", text, entry.label))
    if in_bins:
        text = f"Lines are medians of {bins.width_s:g} s, the bands hold the middle 90 % of the errors."
        notes.append(ChartNote("medians_in_bins", text))
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=notes,
        xaxis=time_axis(view.recording),
        yaxis=log_axis("Radial error, m", traces),
    )


def _single(entry: Entry, states: Estimates, error: Floats, options: ChartOptions, picked: list[Picked]) -> list[Trace]:
    """Lines of tracks; single fixes have a marker each."""
    values = np.where(error > 0, error, np.nan)
    if states.moving:
        points = curve(states.time_s, (np.log(values),), states.starts, options.curve_points)
        look = {"mode": "lines", "line": line_of(entry, 1.2)}
    else:
        points = thin(np.flatnonzero(np.isfinite(values)), options.marks)
        look = {"mode": "markers", "marker": marker_of(entry, 3.5, crowd_opacity(points.of))}
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
            customdata=points.take(states.row),
            **look,
            **hover(points, entry.label, f"%{{y:,.3~r}} m<br>{MARK}", [("target", states.words_at("target"))]),
        )
    ]


def _bins(entry: Entry, states: Estimates, error: Floats, bins: TimeBins, options: ChartOptions) -> list[Trace]:
    """Median and the middle 90 % of each bin of time that holds errors."""
    known = np.flatnonzero(error > 0)
    at = bins.index(states.time_s[known])
    order = np.argsort(at, kind="stable")
    size = bins.edges.size - 1
    parts = np.split(error[known][order], np.searchsorted(at[order], np.arange(1, size)))
    low, median, high = (np.full(size, np.nan) for _ in range(3))
    for i, part in enumerate(parts):
        if part.size:
            low[i], median[i], high[i] = np.percentile(part, (5, 50, 95))
    held = np.flatnonzero(np.isfinite(median))
    if held.size == 0:
        return []
    runs = np.split(held, np.flatnonzero(np.diff(held) > 1) + 1)
    gap = [np.nan]
    outline = [np.concatenate([bins.centres[r], bins.centres[r][::-1], gap]) for r in runs]
    edges = [np.concatenate([low[r], high[r][::-1], gap]) for r in runs]
    color = theme.series_color(entry.index)
    return [
        trace(
            "interval",
            np.concatenate(outline),
            options.number(np.concatenate(edges)),
            entry=entry,
            name=f"{entry.label}, middle 90 %",
            showlegend=False,
            mode="lines",
            line={"width": 0},
            fill="toself",
            fillcolor=theme.faint(color, theme.INTERVAL_OPACITY),
            hoverinfo="skip",
        ),
        trace(
            "series",
            bins.centres,
            options.number(median),
            entry=entry,
            name=entry.label,
            mode="lines+markers",
            line=line_of(entry, 2),
            marker=marker_of(entry, size=5),
            text=np.array([part.size for part in parts]),
            hovertemplate=f"<b>{entry.label}</b><br>median %{{y:,.3~r}} m of %{{text}} marks<br>{bins.width_s:g} s "
            "around %{x:.5~g} s<extra></extra>",
        ),
    ]


CHART = Chart(name="radial_error", title=TITLE, source="run", needs=("states", "errors"), draw=draw, overlay="time")
