"""Which track each target has, scan by scan: a row for each target, a colour for each track, a gap where it has none.

Where nothing is known of targets, each track has a row of its own. Of several radars a target has a row for each, and
the colour is that of the joint track.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts import theme
from backend.charts.columns import Floats, Ints, numbers, row_numbers, words
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Continuity"
# Rows of all entries together; more could not be told apart.
MOST_ROWS = 60
# A piece ends where the next estimate comes later than so many usual steps.
PIECE_STEPS = 2.5
# More rows than the first have small names; more than the second have not room for all of them.
MANY, SMALLEST, SMALL = 12, 26, 8
# Estimates of a track without a target, where others have one, are false or not matched.
NOBODY = "no target"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a bar for each unbroken piece of a track."""
    traces: list[Trace] = []
    notes: list[ChartNote] = []
    for entry in view.entries:
        traces += _bars(entry, MOST_ROWS // max(len(view.entries), 1), notes)
    if not traces:
        return not_applicable(TITLE, "no_states")
    notes.append(
        ChartNote("colour_is_track", "Each colour is a track: where it changes along a row, ids were switched.")
    )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=time_axis(view.recording),
        yaxis=axis("Target", type="category", autorange="reversed", **_labels(traces)),
    )


def _labels(traces: list[Trace]) -> dict[str, Any]:
    """Every row has its name; of many rows the names are small."""
    rows = len({t["y"][0] for t in traces})
    return {"dtick": 1, "tickfont": {"size": SMALL}} if MANY < rows <= SMALLEST else {}


def _bars(entry: Entry, most: int, notes: list[ChartNote]) -> list[Trace]:
    table = entry.table("states")
    if not len(table):
        return []
    time, track = numbers(table, "time_s"), numbers(table, "track")
    target = words(table, "target").astype(object)
    named = target != ""
    if named.any():
        row_of = np.where(named, target, NOBODY)
    else:
        row_of = np.array([f"track {int(n)}" if np.isfinite(n) else "" for n in track.tolist()], object)
    radar = _radars(table, track)
    if np.unique(radar[radar != ""]).size > 1:
        row_of = np.array([f"{row}, {name}" for row, name in zip(row_of.tolist(), radar.tolist(), strict=True)], object)
    shown = numbers(table, "joined") if "joined" in table.names else track
    shown = np.where(np.isfinite(shown), shown, track)
    names = sorted(dict.fromkeys(row_of[np.lexsort((time, ~named))].tolist()), key=_in_order)
    if len(names) > most:
        text = f"The first {most} of {counted(len(names), 'row')} are drawn."
        notes.append(ChartNote("rows_left_out", text, entry.label))
    step = _usual_step(time)
    rows = row_numbers(table)
    out = []
    for name in names[:most]:
        mine = np.flatnonzero(row_of == name)
        # Tracks without a target lie over each other in one row: piece by piece of each track.
        nobody = not named[mine[0]]
        mine = mine[np.lexsort((time[mine], track[mine]) if nobody else (time[mine],))]
        for number, piece in _pieces(mine, time, track, step):
            of_joint = shown[piece[0]]
            color = int(of_joint) - 1 if np.isfinite(of_joint) else 0
            joint = f" of joint track {of_joint:g}" if of_joint != number and np.isfinite(of_joint) else ""
            label = f"{entry.label}, {name}"
            ends = piece[[0, -1]]
            out.append(
                trace(
                    "series",
                    time[ends],
                    [label, label],
                    entry=entry,
                    name=f"{entry.label}, track {number:g}",
                    showlegend=False,
                    mode="lines+markers",
                    line={"color": theme.series_color(color), "width": 9},
                    marker={"color": theme.series_color(color), "symbol": theme.series_symbol(color), "size": 7},
                    customdata=rows[ends],
                    hovertemplate=f"<b>{name}</b><br>track {number:g}{joint}, {counted(piece.size, 'scan')}"
                    f"<br>%{{x:.5~g}} s<extra>{entry.label}</extra>",
                )
            )
    return out


def _in_order(name: str) -> tuple[bool, list[tuple[int, str]]]:
    """Rows as people count them: 2 before 10, nobody's last."""
    return name.startswith(NOBODY), [(int(p), "") if p.isdigit() else (-1, p) for p in re.split(r"(\d+)", name)]


def _radars(table: Table, track: Floats) -> NDArray[np.object_]:
    """Name of the radar that each row's track is of: whose plots it used."""
    used = words(table, "used").astype(object)
    own = {number: name for number, name in zip(track.tolist(), used.tolist(), strict=True) if name}
    return np.array([own.get(number, "") for number in track.tolist()], object)


def _usual_step(time: Floats) -> float:
    steps = np.diff(np.unique(time))
    return float(np.median(steps)) if steps.size else 1.0


def _pieces(mine: Ints, time: Floats, track: Floats, step: float) -> list[tuple[float, Ints]]:
    """Unbroken pieces of one row: the same track, without a gap."""
    cut = np.flatnonzero((np.diff(track[mine]) != 0) | (np.abs(np.diff(time[mine])) > PIECE_STEPS * step)) + 1
    return [(float(track[piece[0]]), piece) for piece in np.split(mine, cut) if piece.size]


CHART = Chart(
    name="track_continuity",
    title=TITLE,
    source="run",
    needs=("states",),
    draw=draw,
    kinds=("polar_plots",),
    overlay="time",
)
