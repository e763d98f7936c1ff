"""Plan of a run: stations, true paths, each algorithm's tracks, 95 % error ellipses, marks that were not used; for
marks the lines of equal GDOP below.
"""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import Ints
from backend.charts.decimate import curve, thin
from backend.charts.ellipse import error_ellipses
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import (
    ChartNote,
    counted,
    hollow_marker_of,
    hover,
    line_of,
    marker_of,
    name_pieces,
    not_applicable,
    trace,
)
from backend.charts.gdop_lines import add_gdop_lines
from backend.charts.plane import MARK, PLACE, Plane
from backend.charts.replay import replay_of
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Plan"
# Ellipses of all entries together: more cover the tracks.
ELLIPSES = 60
# Markers of more estimates than this touch each other and are drawn smaller.
FEW_MARKS = 600


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the plan."""
    plane = Plane(view.recording, options)
    plane.add_plots()
    found = [(entry, estimates_of(entry)) for entry in view.entries]
    for entry, states in found:
        _add_ellipses(plane, entry, states, ELLIPSES // len(found))
    for entry, states in found:
        _add_tracks(plane, entry, states, options)
    # The true path is thin: it lies over the tracks, else it is hidden where they are good.
    for recording in view.recordings:
        plane.add_truth(recording)
    for entry, states in found:
        _add_unused(plane, entry, states, options)
    plane.add_stations()
    add_gdop_lines(plane, view.recording)
    if not any(len(states.table) for _, states in found):
        return not_applicable(TITLE, "no_states")
    drawn = plane.draw(TITLE)
    replay = replay_of(found)
    if replay is not None:
        kilometres = drawn["layout"]["xaxis"]["title"]["text"].endswith("km")
        drawn["layout"]["meta"]["replay"] = replay | {"unit_m": 1000 if kilometres else 1}
    return drawn


def _add_tracks(plane: Plane, entry: Entry, states: Estimates, options: ChartOptions) -> None:
    """Lines with a marker at every estimate; crowded tracks keep their line alone, crowded fixes every k-th point."""
    east, north = states.numbers("east_m"), states.numbers("north_m")
    here = np.isfinite(east) & np.isfinite(north)
    crowded = options.marks is not None and int(here.sum()) > options.marks
    if states.moving:
        points = curve(states.time_s, (east, north), states.starts, options.marks)
        mode = "lines" if crowded else "lines+markers"
    else:
        points, mode = thin(np.flatnonzero(here & states.used), options.marks), "markers"
    plane.picked.append(points)
    if points.of == 0:
        return
    plane.traces.append(
        trace(
            "series",
            points.take(east),
            points.take(north),
            entry=entry,
            name=entry.label,
            mode=mode,
            line=line_of(entry),
            marker=marker_of(entry, 4 if points.shown <= FEW_MARKS else 2.5),
            customdata=points.take(states.row),
            text=points.take(states.time_s),
            **hover(
                points,
                entry.label,
                f"{PLACE}<br>{MARK}",
                [
                    ("track", states.words_at("track")),
                    ("target", states.words_at("target")),
                    ("", states.words_at("status")),
                ],
            ),
        )
    )
    if states.moving:
        name_pieces(plane.traces[-1], _names_of(states, points.piece_starts))


def _names_of(states: Estimates, starts: Ints) -> list[str | int]:
    """Names of the pieces that begin at these places: the target, or else the number of the track."""
    tracks = np.nan_to_num(states.numbers("track")[starts], nan=-1).astype(int).tolist()
    return [target or track for target, track in zip(states.words_at("target")(starts), tracks, strict=True)]


def _add_unused(plane: Plane, entry: Entry, states: Estimates, options: ChartOptions) -> None:
    """Hollow markers at the estimates of marks that were not used; those without an estimate are counted."""
    decisions = entry.table("decisions")
    east, north = states.numbers("east_m"), states.numbers("north_m")
    placed = np.flatnonzero(np.isfinite(east) & np.isfinite(north) & ~states.used)
    nowhere = int((~np.isfinite(east) & ~states.used).sum())
    if nowhere:
        text = f"No estimate, so no place in the plan: {counted(nowhere, 'mark')}; the decisions list them."
        plane.notes.append(ChartNote("not_drawn", text, entry.label))
    if placed.size == 0:
        return
    points = thin(placed, options.doubted)
    plane.picked.append(points)
    reason = states.at_rows(decisions, "reason")
    plane.traces.append(
        trace(
            "rejected",
            points.take(east),
            points.take(north),
            entry=entry,
            name=f"{entry.label}, not used",
            showlegend=False,
            mode="markers",
            marker=hollow_marker_of(entry),
            customdata=points.take(states.row),
            text=points.take(states.time_s),
            **hover(
                points,
                f"{entry.label}, not used",
                f"{PLACE}<br>{MARK}",
                [("", states.words_at("status")), ("", reason), ("target", states.words_at("target"))],
            ),
        )
    )


def _add_ellipses(plane: Plane, entry: Entry, states: Estimates, most: int) -> None:
    """95 % regions at instants spread evenly over the entry's estimates."""
    columns = ("east_m", "north_m", "sigma_east_m", "sigma_north_m", "covariance_east_north_m2")
    values = [states.numbers(name) for name in columns]
    known = np.flatnonzero(np.isfinite(np.stack(values)).all(axis=0) & states.used)
    if known.size == 0:
        return
    count = min(known.size, max(most, 1))
    chosen = known[np.unique(np.linspace(0, known.size - 1, count).round().astype(np.int64))]
    east, north = error_ellipses(*(value[chosen] for value in values))
    color = theme.series_color(entry.index)
    plane.traces.append(
        trace(
            "interval",
            east,
            north,
            entry=entry,
            name=f"{entry.label}, 95 % error ellipses",
            showlegend=False,
            mode="lines",
            line={"color": color, "width": 0.7},
            fill="toself",
            fillcolor=theme.faint(color, theme.INTERVAL_OPACITY),
            hoverinfo="skip",
        )
    )
    if count < known.size:
        text = f"95 % error ellipses at {count} of {counted(int(known.size), 'estimate')}."
        plane.notes.append(ChartNote("ellipses", text, entry.label))


CHART = Chart(name="plan", title=TITLE, source="run", needs=("states", "decisions"), draw=draw, overlay="frame")
