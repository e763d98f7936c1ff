"""One pair closely: what each conversion makes of the true region of a plot's error, and the gate around it.

The true region of a plot in range and azimuth is a banana; every conversion puts an ellipse in its place. The gate is
drawn around the first plot: where the second one lies inside, the two may be one target.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.identification.pairs import Points, Side, points_of
from algorithms.identification.parameters import PlotConversion
from algorithms.identification.plots import Plots
from algorithms.recording import PolarPlots
from backend.charts import theme
from backend.charts.columns import Floats, numbers, words
from backend.charts.ellipse import error_ellipses
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.identification.known_plots import parameters_of, plots_of_entry, tail_of
from backend.charts.identification.run_bananas import banana
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "One pair closely: conversions and gate"
# Name and dash; colours follow the order of the series.
CONVERSIONS: tuple[tuple[PlotConversion, str], ...] = (
    ("lin", "solid"),
    ("paper", "dash"),
    ("dcm", "dashdot"),
    ("ucm", "longdash"),
    ("mucm", "dot"),
    ("paper_literal", "longdashdot"),
)
MARGIN = 0.15


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the accepted pair with the largest distance of the first algorithm that has one."""
    recording = view.recording
    if not isinstance(recording, PolarPlots):
        return not_applicable(TITLE, "other_kind")
    for entry in view.entries:
        chosen = _pair(entry, recording)
        plots = None if chosen is None else plots_of_entry(recording, entry)
        if chosen is None or plots is None or len(set(plots.radar[list(chosen)].tolist())) < 2:
            continue
        traces = _traces(recording, entry, plots, chosen)
        for one in traces:
            one["x"], one["y"] = (options.number(np.asarray(one[k], float) / 1000) for k in "xy")
        rows = [int(recording.row[k]) for k in chosen]
        text = (
            f"Of {entry.label}, rows {rows[0]} and {rows[1]}, the accepted pair with the largest distance. Filled: the "
            "true regions; lines: the ellipses that conversions put in their place, all of 95 %; dashed in grey: the "
            "gate, within which the converted second plot must lie."
        )
        notes = [ChartNote("closeup", text, entry.label)]
        if plots.ahead is not None:
            later = float(recording.time_s[chosen[1]] - recording.time_s[chosen[0]])
            words = f"The second plot was measured {later:.2f} s after the first and is drawn as of its instant."
            notes.append(ChartNote("one_instant", words, entry.label))
        return figure(
            TITLE,
            traces,
            recording=recording,
            notes=notes,
            xaxis=axis("East, km", range=_range(traces, "x")),
            yaxis=axis("North, km", scaleanchor="x", scaleratio=1, range=_range(traces, "y")),
            dragmode="pan",
            legend=True,
        )
    return not_applicable(TITLE, "no_pairs")


def _pair(entry: Entry, recording: PolarPlots) -> tuple[int, int] | None:
    """Positions of the two plots."""
    table = entry.table("associations")
    taken = np.flatnonzero(words(table, "decision") == "accepted")
    if not taken.size:
        return None
    statistic = np.nan_to_num(numbers(table, "statistic")[taken], nan=-1.0)
    best = taken[int(np.argmax(statistic))]
    place = {int(row): k for k, row in enumerate(recording.row)}
    ends = [place.get(int(numbers(table, name)[best]), -1) for name in ("row_1", "row_2")]
    return None if min(ends) < 0 else (ends[0], ends[1])


def _side(plots: Plots, mark: int, first: int) -> Side:
    """Return a plot as of the instant of the first one."""
    radar = int(plots.radar[mark])
    ahead = np.zeros(2) if plots.ahead is None else plots.ahead[mark, :2] - plots.ahead[first, :2]
    return Side(
        plots.sites[radar] + ahead,
        plots.range_m[mark : mark + 1, :1],
        plots.angle_rad[mark : mark + 1, :1],
        float(plots.sigma_range[radar]),
        float(plots.sigma_angle[radar]),
    )


def _traces(recording: PolarPlots, entry: Entry, plots: Plots, chosen: tuple[int, int]) -> list[Trace]:
    sides = [_side(plots, mark, chosen[0]) for mark in chosen]
    names = [plots.names[int(plots.radar[mark])] for mark in chosen]
    out: list[Trace] = []
    for k, (side, name) in enumerate(zip(sides, names, strict=True)):
        color = theme.SERIES[(k + 2) % len(theme.SERIES)]
        out.append(
            trace(
                "interval",
                *banana(side.site, side.range_m[0], side.angle_rad[0], side.sigma_range, side.sigma_angle),
                name=f"radar {name}, true region",
                mode="lines",
                line={"color": color, "width": 1},
                fill="toself",
                fillcolor=theme.faint(color, 0.15),
                hoverinfo="skip",
                showlegend=False,
            )
        )
    for i, (conversion, dash) in enumerate(CONVERSIONS):
        points = [points_of(side, conversion) for side in sides]
        x, y = _ellipses(points)
        # The misprint's ellipses are so long that they would hide everything else.
        hidden: dict[str, Any] = {"visible": "legendonly"} if conversion == "paper_literal" else {}
        line = {"color": theme.SERIES[i % len(theme.SERIES)], "dash": dash, "width": 1.3}
        out.append(trace("interval", x, y, name=conversion, mode="lines", line=line, hoverinfo="skip", **hidden))
    out.append(_gate(entry, sides))
    raw = [side.site + side.range_m[0] * np.array([np.cos(side.angle_rad[0, 0]), np.sin(side.angle_rad[0, 0])])
           for side in sides]  # fmt: skip
    for k, (place, name) in enumerate(zip(raw, names, strict=True)):
        color = theme.SERIES[(k + 2) % len(theme.SERIES)]
        marker = {"color": color, "size": 8, "symbol": theme.SYMBOLS[k % len(theme.SYMBOLS)]}
        out.append(
            trace("measurement", place[:1], place[1:], name=f"radar {name}, plot", mode="markers", marker=marker,
                  customdata=recording.row[[chosen[k]]], text=recording.time_s[[chosen[k]]], showlegend=False)
        )  # fmt: skip
    truth = recording.truth_m[chosen[0], :2]
    if np.isfinite(truth).all():
        marker = {"color": theme.TRUTH, "size": 10, "symbol": "x-thin", "line": {"width": 2, "color": theme.TRUTH}}
        out.append(
            trace("truth", truth[:1], truth[1:], name="true position", mode="markers", marker=marker, showlegend=False)
        )
    return out


def _ellipses(points: list[Points]) -> tuple[Floats, Floats]:
    columns: list[Floats] = [np.concatenate([p[k][:, 0] for p in points]) for k in range(5)]
    x, y, xx, yy, xy = columns
    return error_ellipses(x, y, np.sqrt(xx), np.sqrt(yy), xy, corners=90)


def _gate(entry: Entry, sides: list[Side]) -> Trace:
    """The gate of the difference, around the first plot as the entry's conversion places it."""
    conversion = getattr(parameters_of(entry), "conversion", "mucm")
    name: PlotConversion = conversion if conversion in {c for c, _ in CONVERSIONS} else "mucm"
    a, b = (points_of(side, name) for side in sides)
    xx, yy, xy = a.xx + b.xx, a.yy + b.yy, a.xy + b.xy
    tail = tail_of(entry)
    x, y = error_ellipses(
        a.x[:, 0], a.y[:, 0], np.sqrt(xx[:, 0]), np.sqrt(yy[:, 0]), xy[:, 0],
        probability=1 - tail, corners=90,
    )  # fmt: skip
    line = {"color": theme.BOUND, "dash": "dash", "width": 1.5}
    return trace("bound", x, y, entry=None, name=f"gate, α = {tail:g}", mode="lines", line=line)


def _range(traces: list[Trace], axis_name: str) -> list[float]:
    """What is seen at first: the true regions with a margin."""
    values = np.concatenate([np.asarray(t[axis_name], float) for t in traces if t.get("fill")])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return [low - MARGIN * (high - low), high + MARGIN * (high - low)]


CHART = Chart(
    name="pair_closeup",
    title=TITLE,
    source="run",
    needs=("associations",),
    draw=draw,
    kinds=("polar_plots",),
)
