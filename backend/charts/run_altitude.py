"""Altitude above the Earth: decoded, estimated with its 95 % band, and true."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.recording import PolarPlots, Recording, ToaMarks
from algorithms.toolbox.frames.earth import altitude_from_position, sphere, wgs84
from backend.charts import theme
from backend.charts.columns import Floats, by_key_and_time
from backend.charts.decimate import Picked, curve, line_starts, thin
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import (
    ChartNote,
    Trace,
    axis,
    figure,
    hover,
    line_of,
    marker_of,
    not_applicable,
    outside_view,
    time_axis,
    trace,
)
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Altitude"
MARK = "%{x:.3f} s, row %{customdata}"
# Two-sided 95 % of a normal law.
SIGMAS = 1.959964
# The first view follows what was decoded and what is true; estimates without altitude may be kilometres off.
VIEW_MARGIN = 0.5
# An altitude that was not decoded, by where it came from.
STAND_INS = {"held": "altitude held", "type": "altitude of the type", "class": "assumed altitude"}
SYMBOLS = {"held": "circle-open", "type": "diamond-open", "class": "square-open"}
BAR_OPACITY = 0.3
BARS = 150


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw altitudes over time. Heights of the local frame become altitudes, which the transponder reports."""
    recording = view.recording
    origin = None if recording.site is None else recording.site.frame_origin()
    earth = sphere() if origin is None else wgs84(origin)
    traces: list[Trace] = []
    picked: list[Picked] = []
    notes = [
        ChartNote("altitude_of_sphere", "Without a WGS-84 origin, altitude is above a sphere of 6 371 km.")
        if origin is None
        else ChartNote("altitude_of_ellipsoid", "Altitude is geodetic height (WGS-84); a decoded one is as reported.")
    ]
    decoded = _decoded(recording)
    _add_decoded(recording, decoded, options, traces, picked)
    estimated = []
    for entry in view.entries:
        states = estimates_of(entry)
        height = altitude_from_position(
            np.stack([states.numbers(f"{name}_m") for name in ("east", "north", "up")], axis=1), earth
        )
        _add_band(entry, states, height, options, traces)
        estimated.append((entry, states, height))
    for entry, states, _ in estimated:
        notes += _add_stand_ins(entry, states, options, traces, picked)
    for entry, states, height in estimated:
        _add_estimate(entry, states, height, options, traces, picked)
    truth = altitude_from_position(recording.truth_m, earth)
    _add_truth(recording, truth, options, traces, picked)
    if not any(np.isfinite(t["y"]).any() for t in traces):
        return not_applicable(TITLE, "no_altitude")
    known = np.concatenate([v[np.isfinite(v)] for v in (decoded, truth)])
    vertical = {}
    if known.size:
        low, high = float(known.min()), float(known.max())
        margin = max(VIEW_MARGIN * (high - low), 500.0)
        vertical = {"range": [low - margin, high + margin]}
        heights = np.concatenate([height for _, _, height in estimated] or [np.empty(0)])
        outside = int(((heights < low - margin) | (heights > high + margin)).sum())
        if outside:
            notes.append(outside_view(outside, int(np.isfinite(heights).sum()), "estimate"))
    return figure(
        TITLE,
        traces,
        recording=recording,
        picked=picked,
        notes=notes,
        xaxis=time_axis(recording),
        yaxis=axis("Altitude, m", **vertical),
    )


def _decoded(recording: Recording) -> Floats:
    if isinstance(recording, ToaMarks | PolarPlots):
        return recording.altitude_m[:, 0]
    return np.empty(0)


def _add_decoded(
    recording: Recording, decoded: Floats, options: ChartOptions, traces: list[Trace], picked: list[Picked]
) -> None:
    points = thin(np.flatnonzero(np.isfinite(decoded)), options.marks)
    if points.of == 0:
        return
    picked.append(points)
    names = np.array(recording.targets, object)[recording.target]
    traces.append(
        trace(
            "measurement",
            points.take(recording.time_s),
            options.number(points.take(decoded)),
            name="decoded",
            mode="markers",
            marker={"color": theme.MEASUREMENT, "size": 5},
            customdata=points.take(recording.row),
            **hover(points, "decoded", f"%{{y:.0f}} m<br>{MARK}", [("target", names)]),
        )
    )


def _add_stand_ins(
    entry: Entry, states: Estimates, options: ChartOptions, traces: list[Trace], picked: list[Picked]
) -> list[ChartNote]:
    """Hollow markers where an entry took another altitude than a decoded one, by where it came from."""
    if "altitude_source" not in states.table.columns:
        return []
    source = states.words("altitude_source")
    given, sigma = states.numbers("altitude_given_m"), states.numbers("altitude_sigma_m")
    notes = []
    for kind, words in STAND_INS.items():
        points = thin(np.flatnonzero((source == kind) & np.isfinite(given)), options.marks)
        if points.of == 0:
            continue
        picked.append(points)
        color = theme.series_color(entry.index)
        traces.append(
            trace(
                "measurement",
                points.take(states.time_s),
                options.number(points.take(given)),
                entry=entry,
                name=f"{entry.label}, {words}",
                mode="markers",
                marker={"color": color, "size": 6, "symbol": SYMBOLS[kind], "opacity": 0.6},
                customdata=points.take(states.row),
                **hover(points, f"{entry.label}, {words}", f"%{{y:.0f}} m<br>{MARK}"),
            )
        )
        widest = float(np.nanmax(sigma[source == kind]))
        text = f"{points.of} altitudes were not decoded: {words}, standard deviation up to {widest:.0f} m."
        notes.append(ChartNote(f"altitude_{kind}", text, label=entry.label))
    return notes


def _add_truth(
    recording: Recording, truth: Floats, options: ChartOptions, traces: list[Trace], picked: list[Picked]
) -> None:
    order = by_key_and_time(recording.target, recording.time_s)
    target, time = recording.target[order], recording.time_s[order]
    points = curve(time, (truth[order],), line_starts(target, time), options.curve_points)
    if points.of == 0:
        return
    picked.append(points)
    names = np.array(recording.targets, object)[target]
    traces.append(
        trace(
            "truth",
            points.take(time),
            options.number(points.take(truth[order])),
            name="true",
            mode="lines+markers" if points.shown <= theme.DOTTED_TRUTH else "lines",
            line={"color": theme.TRUTH, "width": 1, "dash": "dash"},
            marker={"color": theme.TRUTH, "size": 2.5},
            customdata=points.take(recording.row[order]),
            **hover(points, "true", f"%{{y:.0f}} m<br>{MARK}", [("target", names)]),
        )
    )


def _add_estimate(
    entry: Entry,
    states: Estimates,
    height: Floats,
    options: ChartOptions,
    traces: list[Trace],
    picked: list[Picked],
) -> None:
    if states.moving:
        points = curve(states.time_s, (height,), states.starts, options.curve_points)
        mode = "lines+markers" if points.shown <= options.points else "lines"
    else:
        points, mode = thin(np.flatnonzero(np.isfinite(height)), options.marks), "markers"
    if points.of == 0:
        return
    picked.append(points)
    traces.append(
        trace(
            "series",
            points.take(states.time_s),
            options.number(points.take(height)),
            entry=entry,
            name=entry.label,
            mode=mode,
            line=line_of(entry),
            marker=marker_of(entry, size=3),
            customdata=points.take(states.row),
            **hover(points, entry.label, f"%{{y:.0f}} m<br>{MARK}", [("target", states.words_at("target"))]),
        )
    )


def _add_band(entry: Entry, states: Estimates, height: Floats, options: ChartOptions, traces: list[Trace]) -> None:
    """95 % band of tracks from the vertical standard deviation; some single fixes get bars of the same length."""
    reach = SIGMAS * states.numbers("sigma_up_m")
    color = theme.series_color(entry.index)
    look: dict[str, Any] = {
        "entry": entry,
        "name": f"{entry.label}, 95 % band",
        "showlegend": False,
        "hoverinfo": "skip",
    }
    if not states.moving:
        points = thin(np.flatnonzero(np.isfinite(height + reach)), BARS)
        if points.of:
            line = {"color": theme.faint(color, BAR_OPACITY), "width": 1}
            time, low, high = (points.take(v) for v in (states.time_s, height - reach, height + reach))
            gap = np.full(time.size, np.nan)
            x, y = (np.stack(c, axis=1).ravel() for c in ((time, time, gap), (low, high, gap)))
            traces.append(trace("interval", x, options.number(y), mode="lines", line=line, **look))
        return
    points = curve(states.time_s, (height - reach, height + reach), states.starts, options.curve_points)
    if points.of == 0:
        return
    x, y = outline(points, states.time_s, height - reach, height + reach)
    fill = theme.faint(color, theme.INTERVAL_OPACITY)
    traces.append(
        trace("interval", x, options.number(y), mode="lines", line={"width": 0}, fill="toself", fillcolor=fill, **look)
    )


def outline(points: Picked, time: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Closed outlines between two curves, one for each unbroken piece, NaN between."""
    pieces = np.split(points.positions, np.flatnonzero(points.positions < 0))
    x: list[Floats] = []
    y: list[Floats] = []
    for piece in pieces:
        there = piece[piece >= 0]
        back = there[::-1]
        x += [time[there], time[back], time[there[:1]], np.array([np.nan])]
        y += [low[there], high[back], low[there[:1]], np.array([np.nan])]
    return np.concatenate(x), np.concatenate(y)


CHART = Chart(name="altitude", title=TITLE, source="run", needs=("states",), draw=draw)
