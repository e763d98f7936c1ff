"""Measured Dopplers with the lines of the closed form: its last window, the zero of each, the crossing that is kept.

Methods without lines have the curve that the last estimate of each pass gives.
"""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve, thin
from backend.charts.figure import ChartNote, Trace, axis, figure, line_of, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import Rows, rows_of
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Dopplers and their lines"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the Dopplers once, of each closed form the lines of every pass, of other methods their last estimate."""
    found = [(entry, rows) for entry in view.entries if (rows := rows_of(entry, "dopplers")) is not None]
    if not found:
        return not_applicable(TITLE, "no_dopplers")
    traces: list[Trace] = []
    picked: list[Picked] = []
    with_lines = False
    _, first = found[0]
    channels = list(dict.fromkeys(first.words("channel")))
    for i, channel in enumerate(channels):
        own = np.flatnonzero((first.words("channel") == channel) & np.isfinite(first.numbers("doppler_hz")))
        points = thin(own, options.marks)
        picked.append(points)
        traces.append(
            trace(
                "measurement",
                points.take(first.time_s),
                options.number(points.take(first.numbers("doppler_hz"))),
                name=f"channel {channel}",
                mode="markers",
                marker={"color": theme.MEASUREMENT, "size": 5, "symbol": theme.SYMBOLS[i % len(theme.SYMBOLS)]},
                customdata=points.take(first.row),
                hovertemplate=f"<b>channel {channel}</b><br>%{{y:.3f}} Hz<br>%{{x:.3f}} s, "
                "row %{customdata}<extra></extra>",
            )
        )
    for entry in view.entries:
        rows = rows_of(entry, "crossings")
        if rows is not None and np.isfinite(rows.numbers("line_1_slope_hz_s")).any():
            traces += _lines(entry, rows)
            with_lines = True
        elif (dopplers := rows_of(entry, "dopplers")) is not None:
            traces += _curves(entry, dopplers, options, picked)
    for entry, rows in found:
        traces += _rejected(entry, rows)
    notes = [
        ChartNote(
            "lines",
            "Solid: the line through the window that gave the kept crossing, a cross; dashed: the last window's. "
            "Both run on to zero.",
        )
    ]
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=notes if with_lines else [],
        xaxis=time_axis(view.recording),
        yaxis=axis("Doppler, Hz", zeroline=True, zerolinecolor=theme.AXIS),
    )


def _lines(entry: Entry, rows: Rows) -> list[Trace]:
    """Of each pass the line that gave the kept crossing, solid, and the last one, dashed; both run on to zero."""
    out: list[Trace] = []
    pieces = np.split(np.arange(rows.order.size), np.flatnonzero(rows.breaks)[1:])
    for j in (1, 2):
        column = {n: rows.numbers(f"line_{j}_{n}") for n in ("centre_s", "centre_hz", "slope_hz_s", "zero_s")}
        kept, crossing = rows.numbers(f"kept_{j}") > 0, rows.numbers(f"crossing_{j}_s")
        # The crossing is the zero of the window that it was taken from, to the last bit.
        of_kept = [k for piece in pieces if kept[piece[-1]]
                   for k in piece[column["zero_s"][piece] == crossing[piece[-1]]][:1]]  # fmt: skip
        look = line_of(entry, 1)
        for word, dash, chosen in (
            ("line", "dash", [int(piece[-1]) for piece in pieces]),
            ("kept line", "solid", of_kept),
        ):
            x, y = _drawn_lines(rows.time_s, column, chosen)
            if x.size:
                name = f"{entry.label}, {word} {j}"
                hover = f"<b>{name}</b><br>%{{y:.2f}} Hz, %{{x:.3f}} s<extra></extra>"
                out.append(trace("series", x, y, entry=entry, name=name, mode="lines", line={**look, "dash": dash},
                                 hovertemplate=hover))  # fmt: skip
        kept_x = np.array([crossing[piece[-1]] for piece in pieces if kept[piece[-1]]])
        if kept_x.size:
            name = f"{entry.label}, crossing of receiver {j}"
            marker = {"symbol": "x", "size": 9, "color": theme.series_color(entry.index)}
            out.append(trace("series", kept_x, np.zeros(kept_x.size), entry=entry, name=name, mode="markers",
                             marker=marker, showlegend=False,
                             hovertemplate=f"<b>{name}</b><br>%{{x:.4f}} s<extra></extra>"))  # fmt: skip
    return out


def _drawn_lines(time_s: Floats, column: dict[str, Floats], chosen: list[int]) -> tuple[Floats, Floats]:
    """The lines of these rows over their windows and on to zero, with a gap behind each."""
    x: list[float] = []
    y: list[float] = []
    for k in chosen:
        centre, value, slope, zero = (float(column[n][k]) for n in ("centre_s", "centre_hz", "slope_hz_s", "zero_s"))
        if not np.isfinite([centre, value, slope, zero]).all():
            continue
        half = max(float(time_s[k]) - centre, 1e-9)
        for t in sorted((zero, centre - half, centre + half)):
            x.append(t)
            y.append(value + slope * (t - centre))
        x.append(np.nan)
        y.append(np.nan)
    return np.array(x), np.array(y)


def _curves(entry: Entry, rows: Rows, options: ChartOptions, picked: list[Picked]) -> list[Trace]:
    """What the last estimate of each pass gives, channel by channel."""
    passes, channel = np.cumsum(rows.breaks), rows.words("channel")
    _, number = np.unique(channel, return_inverse=True)
    order = np.lexsort((rows.time_s, passes, number))
    value = rows.numbers("predicted_hz")[order]
    key = np.stack([number, passes])[:, order]
    breaks = np.append(True, (np.diff(key, axis=1) != 0).any(axis=0))
    points = curve(rows.time_s[order], (value,), breaks, options.curve_points)
    if points.of == 0:
        return []
    picked.append(points)
    name = f"{entry.label}, last estimate"
    return [
        trace(
            "series",
            points.take(rows.time_s[order]),
            options.number(points.take(value)),
            entry=entry,
            name=name,
            mode="lines",
            line=line_of(entry, 1),
            hovertemplate=f"<b>{name}</b><br>%{{y:.3f}} Hz<br>%{{x:.3f}} s<extra></extra>",
        )
    ]


def _rejected(entry: Entry, rows: Rows) -> list[Trace]:
    f, residual, used = (rows.numbers(n) for n in ("doppler_hz", "residual_hz", "used"))
    out = np.flatnonzero(np.isfinite(f) & np.isfinite(residual) & (used == 0))
    if not out.size:
        return []
    name = f"{entry.label}, not used"
    color = theme.series_color(entry.index)
    return [
        trace(
            "rejected",
            rows.time_s[out],
            f[out].astype(np.float32),
            entry=entry,
            name=name,
            mode="markers",
            marker={"symbol": "circle-open", "size": 9, "color": color, "line": {"color": color, "width": 1.5}},
            customdata=rows.row[out],
            hovertemplate=f"<b>{name}</b><br>%{{y:.2f}} Hz<br>%{{x:.3f}} s, row %{{customdata}}<extra></extra>",
        )
    ]


CHART = Chart(
    name="doppler_lines",
    title=TITLE,
    source="run",
    needs=("dopplers", "crossings"),
    draw=draw,
    kinds=("doppler_pairs",),
)
