"""Plan in the frame of the base line: terminals, lines of sight, zone, true and estimated paths, error ellipses.

Along the base line runs x; y, across it, is drawn larger, because a pass is a tenth as long as the base line.
"""

from __future__ import annotations

import numpy as np

from algorithms.recording import Recording
from algorithms.toolbox.frames.forward_scatter import ScatterFrame, scatter_frame
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.ellipse import error_ellipses
from backend.charts.figure import ChartNote, Trace, axis, figure, line_of, marker_of, not_applicable, trace
from backend.charts.forward_scatter.panels import Rows, broken, broken_rows, rows_of
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Passes across the base line"
# Where |y| is at most so much of the distance to the nearer end, the closed form is made for it.
ZONE = 0.3
ELLIPSES = 40


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw every pass of every algorithm."""
    site = view.recording.site
    if site is None or not site.transmitters or not site.receivers:
        return not_applicable(TITLE, "no_base_line")
    places = site.terminal_positions()
    count = len(site.transmitters)
    frame = scatter_frame(places[:count], places[count:])
    local = frame.from_enu(places)
    traces = [_zone(local, count)]
    found = [(entry, rows) for entry in view.entries if (rows := rows_of(entry, "states")) is not None]
    for entry, rows in found:
        traces += _ellipses(entry, rows, frame)
    for entry, rows in found:
        traces.append(_path(entry, rows, frame, options))
    traces += _truth(view.recording, frame)
    traces += _terminals(local, count, [p.name for p in (*site.transmitters, *site.receivers)])
    notes = [ChartNote("exaggerated", "Across the base line the scale is larger than along it.")]
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=axis("Along the base line, km"),
        yaxis=axis("Across the base line, km"),
    )


def _positions(rows: Rows, frame: ScatterFrame) -> Floats:
    enu = np.stack([rows.numbers(f"{a}_m") for a in ("east", "north", "up")], axis=1)
    return frame.from_enu(enu) / 1000


def _path(entry: Entry, rows: Rows, frame: ScatterFrame, options: ChartOptions) -> Trace:
    place = _positions(rows, frame)
    return trace(
        "series",
        broken(place[:, 0], rows.breaks),
        broken(place[:, 1], rows.breaks),
        entry=entry,
        name=entry.label,
        mode="lines+markers",
        line=line_of(entry),
        marker=marker_of(entry, 4),
        customdata=broken_rows(rows.row, rows.breaks),
        text=broken(rows.time_s, rows.breaks),
        hovertemplate=f"<b>{entry.label}</b><br>x %{{x:.3f}} km, y %{{y:.3f}} km<br>%{{text:.3f}} s, "
        "row %{customdata}<extra></extra>",
    )


def _ellipses(entry: Entry, rows: Rows, frame: ScatterFrame) -> list[Trace]:
    """95 % error ellipses at instants spread over the passes."""
    place = _positions(rows, frame)
    se, sn = rows.numbers("sigma_east_m"), rows.numbers("sigma_north_m")
    both = rows.numbers("covariance_east_north_m2")
    c, s = frame.cosine, frame.sine
    xx = c * c * se**2 + 2 * c * s * both + s * s * sn**2
    yy = s * s * se**2 - 2 * c * s * both + c * c * sn**2
    xy = c * s * (sn**2 - se**2) + (c * c - s * s) * both
    known = np.flatnonzero(np.isfinite(place[:, 0]) & np.isfinite(xx) & (xx > 0) & (yy > 0))
    # A claim as long as the base line would hide everything.
    known = known[np.sqrt(xx[known]) < 0.25 * np.abs(place[known, 0]) * 1000 + 1.0]
    if not known.size:
        return []
    chosen = known[np.unique(np.linspace(0, known.size - 1, min(known.size, ELLIPSES)).round().astype(np.int64))]
    x, y = error_ellipses(
        1000 * place[chosen, 0], 1000 * place[chosen, 1], np.sqrt(xx[chosen]), np.sqrt(yy[chosen]), xy[chosen]
    )
    color = theme.series_color(entry.index)
    return [
        trace(
            "interval",
            x / 1000,
            y / 1000,
            entry=entry,
            name=f"{entry.label}, 95 % error ellipses",
            showlegend=False,
            mode="lines",
            line={"color": color, "width": 0.7},
            fill="toself",
            fillcolor=theme.faint(color, theme.INTERVAL_OPACITY),
            hoverinfo="skip",
        )
    ]


def _truth(recording: Recording, frame: ScatterFrame) -> list[Trace]:
    place = frame.from_enu(recording.truth_m) / 1000
    known = np.isfinite(place).all(axis=1)
    if not known.any():
        return []
    place, time, row = place[known], recording.time_s[known], recording.row[known]
    order = np.lexsort((time, recording.target[known]))
    place, time, row = place[order], time[order], row[order]
    # Another flight begins where y jumps back.
    step = np.abs(np.diff(place[:, 1]))
    jumps = np.append(True, step > 5 * max(float(np.median(step)) if step.size else 0.0, 1e-6))
    return [
        trace(
            "truth",
            broken(place[:, 0], jumps),
            broken(place[:, 1], jumps),
            name="true path",
            mode="lines",
            line={"color": theme.TRUTH, "width": 1, "dash": "dash"},
            customdata=broken_rows(row, jumps),
            text=broken(time, jumps),
            hovertemplate="<b>true path</b><br>x %{x:.3f} km, y %{y:.3f} km<extra></extra>",
        )
    ]


def _zone(local: Floats, count: int) -> Trace:
    """Where |y| is small against the distances to both ends."""
    a = float(local[:count, 0].mean()) / 1000
    peak = ZONE * a / 2
    return trace(
        "bound",
        np.array([0.0, a / 2, a, a / 2, 0.0]),
        np.array([0.0, peak, 0.0, -peak, 0.0]),
        name="zone of use",
        mode="lines",
        line={"color": theme.BOUND, "dash": "dot", "width": 1},
    )


def _terminals(local: Floats, count: int, names: list[str]) -> list[Trace]:
    lines_x: list[float] = []
    lines_y: list[float] = []
    for t in local[:count]:
        for r in local[count:]:
            lines_x += [t[0] / 1000, r[0] / 1000, np.nan]
            lines_y += [t[1] / 1000, r[1] / 1000, np.nan]
    return [
        trace(
            "station",
            np.array(lines_x),
            np.array(lines_y),
            name="lines of sight",
            mode="lines",
            line={"color": theme.AXIS, "width": 1},
            hoverinfo="skip",
        ),
        trace(
            "station",
            local[:, 0] / 1000,
            local[:, 1] / 1000,
            name="transmitters and receivers",
            mode="markers+text",
            marker={
                "color": theme.STATION,
                "size": 9,
                "symbol": ["triangle-up"] * count + ["square"] * (len(local) - count),
            },
            text=names,
            # Two that stand side by side have their names on either side.
            textposition=[
                "bottom center" if y < local[group, 1].max() else "top center"
                for group in (slice(0, count), slice(count, None))
                for y in local[group, 1]
            ],
            hovertemplate="<b>%{text}</b><br>x %{x:.3f} km, y %{y:.3f} km<extra></extra>",
        ),
    ]


CHART = Chart(
    name="base_plan",
    title=TITLE,
    source="run",
    needs=("states",),
    draw=draw,
    kinds=("doppler_pairs",),
)
