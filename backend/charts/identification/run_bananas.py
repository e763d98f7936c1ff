"""Plan of the pairs: for each plot the true region of its error in polar axes, a banana, and the fused ellipse."""

from __future__ import annotations

import numpy as np

from algorithms.recording import PolarPlots
from algorithms.toolbox.frames.polar_conversion import angle_from_compass
from backend.charts import theme
from backend.charts.columns import Floats, Ints, numbers, words
from backend.charts.ellipse import error_ellipses
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, line_of, not_applicable, trace
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
    for radar, name in enumerate(recording.radars):
        mine = chosen[recording.radar[chosen] == radar]
        outline = _bananas(recording, mine, radar)
        color = theme.SERIES[(radar + 2) % len(theme.SERIES)]
        if outline is not None:
            traces.append(
                trace(
                    "interval",
                    *outline,
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
    known = chosen[np.isfinite(recording.truth_m[chosen]).all(axis=1)]
    if known.size:
        place = np.unique(recording.truth_m[known, :2], axis=0)
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


def _bananas(recording: PolarPlots, marks: Ints, radar: int) -> tuple[Floats, Floats] | None:
    """Outlines of the region that holds 95 % in range and azimuth, NaN after each."""
    if recording.site is None:
        return None
    known = {r.name: (r, p) for r, p in zip(recording.site.radars, recording.site.radar_positions(), strict=True)}
    found = known.get(recording.radars[radar])
    if found is None or found[0].sigma_range_m is None or found[0].sigma_azimuth_deg is None or not marks.size:
        return None
    place = found[1]
    sigma_range, sigma_angle = found[0].sigma_range_m, np.radians(found[0].sigma_azimuth_deg)
    turn = np.linspace(0, 2 * np.pi, CORNERS + 1)
    range_m = recording.range_m[marks, 0]
    angle = angle_from_compass(recording.azimuth_rad[marks, 0])
    r = range_m[:, None] + RADIUS * sigma_range * np.cos(turn)
    b = angle[:, None] + RADIUS * sigma_angle * np.sin(turn)
    gap = np.full((marks.size, 1), np.nan)
    east = np.hstack([place[0] + r * np.cos(b), gap]).ravel()
    north = np.hstack([place[1] + r * np.sin(b), gap]).ravel()
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
