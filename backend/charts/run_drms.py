"""Horizontal error of a run: what each algorithm claims (DRMS) and, where the truth is known, what it really is."""

from __future__ import annotations

from typing import Any

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

TITLE = "Horizontal error: claimed and actual"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw claimed errors as lines, actual ones as points, and say how often the claim held."""
    bins = time_bins(view.time_s)
    traces: list[Trace] = []
    picked: list[Picked] = []
    notes: list[ChartNote] = []
    found = [(entry, estimates_of(entry)) for entry in view.entries]
    claimed = {entry.label: states.numbers("drms_m") for entry, states in found}
    if not any((values > 0).any() for values in claimed.values()):
        return not_applicable(TITLE, "no_covariance")
    in_bins = any(
        np.count_nonzero(np.isfinite(states.numbers("drms_m")) & states.starts) > CURVES for _, states in found
    )
    actual = {entry.label: actual_errors(entry, states) for entry, states in found}
    for entry, states in found:
        _add_actual(entry, states, actual[entry.label], in_bins, options, traces, picked, notes)
    for entry, states in found:
        if in_bins:
            _add_bins(entry, states, claimed[entry.label], actual[entry.label], bins, traces)
        else:
            _add_claim(entry, states, claimed[entry.label], options, traces, picked)
        notes += _honesty(entry, claimed[entry.label], actual[entry.label])
    if in_bins:
        text = f"Lines and large symbols: root mean squares of {bins.width_s:g} s; small points: single marks."
        notes.append(ChartNote("rms_in_bins", text))
    if not any(recording.has_truth for recording in view.recordings):
        notes.append(ChartNote("no_truth", "No truth in this recording: only the claimed error is known."))
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=notes,
        xaxis=time_axis(view.recording),
        yaxis=log_axis("Horizontal error, m", traces),
    )


def _add_claim(
    entry: Entry,
    states: Estimates,
    claimed: Floats,
    options: ChartOptions,
    traces: list[Trace],
    picked: list[Picked],
) -> None:
    """The claim as a line; of single fixes, which have no line, as a dash at each mark."""
    values = np.where(claimed > 0, claimed, np.nan)
    look: dict[str, Any]
    if states.moving:
        points = curve(states.time_s, (np.log(values),), states.starts, options.curve_points)
        look = {"mode": "lines", "line": line_of(entry, 2)}
    else:
        points = thin(np.flatnonzero(np.isfinite(values)), options.marks)
        dash = {"color": theme.series_color(entry.index), "width": 1.5}
        look = {
            "mode": "markers",
            "marker": {"symbol": "line-ew-open", "size": 6, "line": dash, "color": dash["color"]},
        }
    picked.append(points)
    traces.append(
        trace(
            "series",
            points.take(states.time_s),
            options.number(points.take(values)),
            entry=entry,
            name=f"{entry.label}, claimed",
            customdata=points.take(states.row),
            **look,
            **hover(
                points, f"{entry.label}, claimed", f"%{{y:,.3~r}} m<br>{MARK}", [("track", states.words_at("track"))]
            ),
        )
    )


def _add_actual(
    entry: Entry,
    states: Estimates,
    actual: Floats,
    in_bins: bool,
    options: ChartOptions,
    traces: list[Trace],
    picked: list[Picked],
    notes: list[ChartNote],
) -> None:
    notes += zeros_left_out(entry, actual)
    points = thin(np.flatnonzero(actual > 0), options.marks)
    picked.append(points)
    if points.of == 0:
        return
    traces.append(
        trace(
            "series",
            points.take(states.time_s),
            options.number(points.take(actual)),
            entry=entry,
            name=f"{entry.label}, actual",
            showlegend=not in_bins,
            mode="markers",
            marker=marker_of(entry, 3.5, crowd_opacity(points.of)),
            customdata=points.take(states.row),
            **hover(
                points, f"{entry.label}, actual", f"%{{y:,.3~r}} m<br>{MARK}", [("target", states.words_at("target"))]
            ),
        )
    )


def _add_bins(
    entry: Entry, states: Estimates, claimed: Floats, actual: Floats, bins: TimeBins, traces: list[Trace]
) -> None:
    """Root mean squares in bins of time: the claim as a line, what really was as large symbols."""
    for name, values in (("claimed", claimed), ("actual", actual)):
        known = np.isfinite(values)
        n, total = bins.sums(states.time_s[known], values[known] ** 2)
        with np.errstate(invalid="ignore", divide="ignore"):
            rms = np.where(total > 0, np.sqrt(total / n), np.nan)
        if not np.isfinite(rms).any():
            continue
        look = (
            {"mode": "lines+markers", "line": line_of(entry, 2), "marker": marker_of(entry, size=3)}
            if name == "claimed"
            else {"mode": "markers", "marker": marker_of(entry, size=8)}
        )
        traces.append(
            trace(
                "series",
                bins.centres,
                rms,
                entry=entry,
                name=f"{entry.label}, {name} (rms)",
                text=n,
                hovertemplate=f"<b>{entry.label}, {name}</b><br>rms %{{y:,.3~r}} m of %{{text}} marks<br>"
                f"{bins.width_s:g} s around %{{x:.5~g}} s<extra></extra>",
                **look,
            )
        )


def _honesty(entry: Entry, claimed: Floats, actual: Floats) -> list[ChartNote]:
    """How often the actual error stays below the claimed DRMS: 63 % for a round, 68 % for a flat Gaussian error."""
    known = np.isfinite(claimed) & np.isfinite(actual)
    if not known.any():
        return []
    share = float((actual[known] <= claimed[known]).mean())
    text = (
        f"The actual error is below the claimed one at {100 * share:.0f} % of {counted(int(known.sum()), 'mark')} "
        "(63 to 68 % when the claim is right)."
    )
    return [ChartNote("claim_held", text, entry.label)]


CHART = Chart(name="drms", title=TITLE, source="run", needs=("states", "errors"), draw=draw, overlay="time")
