"""Plan of the pairs: for each plot the true region of its error in polar axes, a banana, and the fused ellipse."""

from __future__ import annotations

import numpy as np

from algorithms.recording import PolarPlots
from backend.charts import theme
from backend.charts.columns import Floats, Ints, numbers, words
from backend.charts.ellipse import error_ellipses
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, line_of, not_applicable, trace
from backend.charts.identification.known_plots import plots_of_entry
from backend.charts.plots import plot_positions
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Pairs with the regions of their errors"
# Bananas of more plots than this cover each other.
MOST_PLOTS = 40
CORNERS = 60
# 95 % of a Gaussian in two dimensions.
RADIUS = float(np.sqrt(-2 * np.log(0.05)))


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the plots of the first looks."""
    recording = view.recording
    if not isinstance(recording, PolarPlots):
        return not_applicable(TITLE, "other_kind")
    where = plot_positions(recording)
    here = np.flatnonzero(np.isfinite(where.east_m + where.north_m))
    if not here.size:
        return not_applicable(TITLE, "no_marks")
    chosen = here[:MOST_PLOTS]
    traces: list[Trace] = []
    known = plots_of_entry(recording, view.entries[0] if view.entries else None)
    for radar, name in enumerate(recording.radars):
        mine = chosen[recording.radar[chosen] == radar]
        color = theme.SERIES[(radar + 2) % len(theme.SERIES)]
        if known is not None and mine.size:
            traces.append(
                trace(
                    "interval",
                    *banana(
                        known.sites[radar],
                        known.range_m[mine, 0],
                        known.angle_rad[mine, 0],
                        float(known.sigma_range[radar]),
                        float(known.sigma_angle[radar]),
                    ),
                    name=f"radar {name}, 95 % regions",
                    mode="lines",
                    line={"color": color, "width": 1},
                    fill="toself",
                    fillcolor=theme.faint(color, 0.10),
                    hoverinfo="skip",
                )
            )
        traces.append(
            trace(
                "measurement",
                where.east_m[mine],
                where.north_m[mine],
                name=f"radar {name}, plots",
                mode="markers",
                marker={"color": color, "size": 6, "symbol": theme.SYMBOLS[radar % len(theme.SYMBOLS)]},
                customdata=recording.row[mine],
                text=recording.time_s[mine],
                hovertemplate="row %{customdata}<br>%{x:.3f} km east, %{y:.3f} km north<extra></extra>",
            )
        )
    for entry in view.entries:
        traces += _pairs(entry, recording, where.east_m, where.north_m, chosen)
    true = chosen[np.isfinite(recording.truth_m[chosen]).all(axis=1)]
    if true.size:
        place = np.unique(recording.truth_m[true, :2], axis=0)
        marker = {"color": theme.TRUTH, "size": 8, "symbol": "x-thin", "line": {"width": 2, "color": theme.TRUTH}}
        traces.append(trace("truth", place[:, 0], place[:, 1], name="true position", mode="markers", marker=marker))
    for one in traces:
        one["x"], one["y"] = (options.number(np.asarray(one[k], float) / 1000) for k in "xy")
    notes = []
    if chosen.size < here.size:
        text = f"The first {counted(chosen.size, 'plot')} of {counted(here.size, 'plot')}."
        notes.append(ChartNote("first_plots", text))
    return figure(
        TITLE,
        traces,
        recording=recording,
        notes=notes,
        xaxis=axis("East, km"),
        yaxis=axis("North, km", scaleanchor="x", scaleratio=1),
        dragmode="pan",
    )


def banana(
    site: Floats, range_m: Floats, angle_rad: Floats, sigma_range_m: float, sigma_rad: float
) -> tuple[Floats, Floats]:
    """Outlines (m) of the regions that hold 95 % in range and angle, of plots (n,), NaN after each."""
    turn = np.linspace(0, 2 * np.pi, CORNERS + 1)
    r = range_m[:, None] + RADIUS * sigma_range_m * np.cos(turn)
    b = angle_rad[:, None] + RADIUS * sigma_rad * np.sin(turn)
    gap = np.full((range_m.size, 1), np.nan)
    east = np.hstack([site[0] + r * np.cos(b), gap]).ravel()
    north = np.hstack([site[1] + r * np.sin(b), gap]).ravel()
    return east, north


def _pairs(entry: Entry, recording: PolarPlots, east: Floats, north: Floats, chosen: Ints) -> list[Trace]:
    """Lines between the plots of accepted pairs, and the ellipses of the fused positions."""
    table = entry.table("associations")
    place = {int(recording.row[k]): int(k) for k in chosen}
    first, second = numbers(table, "row_1"), numbers(table, "row_2")
    accepted = words(table, "decision") == "accepted"
    pairs = [(place[int(i)], place[int(j)]) for i, j, ok in zip(first, second, accepted, strict=True)
             if ok and int(i) in place and int(j) in place]  # fmt: skip
    out: list[Trace] = []
    if pairs:
        ends = np.array(pairs)
        gap = np.full(len(pairs), np.nan)
        x = np.stack([east[ends[:, 0]], east[ends[:, 1]], gap], axis=1).ravel()
        y = np.stack([north[ends[:, 0]], north[ends[:, 1]], gap], axis=1).ravel()
        out.append(
            trace("series", x, y, entry=entry, name=f"{entry.label}, pairs", mode="lines", line=line_of(entry, 2),
                  hoverinfo="skip")
        )  # fmt: skip
    states = entry.table("states")
    rows = np.isin(numbers(states, "row"), recording.row[chosen])
    columns = [
        numbers(states, n)[rows]
        for n in ("east_m", "north_m", "sigma_east_m", "sigma_north_m", "covariance_east_north_m2")
    ]
    if rows.any():
        x, y = error_ellipses(*columns)
        color = theme.series_color(entry.index)
        out.append(
            trace("interval", x, y, entry=entry, name=f"{entry.label}, fused, 95 % ellipses", mode="lines",
                  line={"color": color, "width": 1.2}, hoverinfo="skip")
        )  # fmt: skip
    return out


CHART = Chart(
    name="pairs_plan",
    title=TITLE,
    source="run",
    needs=("associations", "states"),
    draw=draw,
    kinds=("polar_plots",),
)
