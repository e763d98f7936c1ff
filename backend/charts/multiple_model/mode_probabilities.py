"""Probability of each motion model over time, stacked, for each algorithm with several models."""

from __future__ import annotations

import numpy as np

from backend.charts.columns import Floats
from backend.charts.figure import ChartNote, Trace, figure, not_applicable, time_axis
from backend.charts.multiple_model.panels import MOST, POINTS, area, panels
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Probabilities of the models"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a band of panels, one for each entry, probabilities stacked from the first model up."""
    found = [entry for entry in view.entries if len(entry.table("mode_probabilities"))]
    if not found:
        return not_applicable(TITLE, "no_models")
    shown = found if options.full else found[:MOST]
    traces: list[Trace] = []
    for i, entry in enumerate(shown):
        traces += _areas(entry, i)
    layout = panels([entry.label for entry in shown], [_models(entry) for entry in shown], "Probability", legs=False)
    notes = [ChartNote("stacked", "Stacked from the first model of the list; the sum is one.")]
    if len(shown) < len(found):
        notes.append(ChartNote("panels", f"{MOST} panels of {len(found)} are drawn; the table has all."))
    if any(_tracks(entry) > 1 for entry in shown):
        notes.append(ChartNote("mean_of_tracks", "Mean over all tracks of an instant; choose a target to see its own."))
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=time_axis(view.recording, anchor="y" if len(shown) == 1 else f"y{len(shown)}"),
        **layout,
    )


def _models(entry: Entry) -> list[str]:
    return list(dict.fromkeys(np.array(entry.table("mode_probabilities").columns["model"], object).tolist()))


def _areas(entry: Entry, panel: int) -> list[Trace]:
    table = entry.table("mode_probabilities")
    models = np.array(table.columns["model"], object)
    names = list(dict.fromkeys(models.tolist()))
    time = np.asarray(table.columns["time_s"], float)
    probability = np.asarray(table.columns["probability"], float)
    track = np.asarray(table.columns.get("track", np.ones(time.size)), float)
    at = np.unique(time)
    at = at[:: max(1, at.size // POINTS)]
    out = []
    for m, name in enumerate(names):
        rows = np.flatnonzero(models == name)
        shares = _over_tracks(at, time[rows], probability[rows], track[rows])
        out.append(area(entry, entry.label, panel, m, name, at, shares.astype(np.float32)))
    return out


def _tracks(entry: Entry) -> int:
    """Of how many tracks the table tells."""
    track = entry.table("mode_probabilities").columns.get("track")
    return 1 if track is None else int(np.unique(np.asarray(track, float)).size)


def _over_tracks(at: Floats, time: Floats, probability: Floats, track: Floats) -> Floats:
    """Mean over the tracks that live at these instants; each keeps what it had at its last estimate."""
    total, alive = np.zeros(at.size), np.zeros(at.size)
    for number in np.unique(track):
        own = np.flatnonzero(track == number)
        own = own[np.argsort(time[own], kind="stable")]
        place = np.searchsorted(time[own], at, side="right") - 1
        there = (place >= 0) & (at <= time[own[-1]])
        total[there] += probability[own[place[there]]]
        alive += there
    mean: Floats = np.divide(total, alive, out=np.full(at.size, np.nan), where=alive > 0)
    return mean


CHART = Chart(
    name="mode_probabilities",
    title=TITLE,
    source="run",
    needs=("mode_probabilities",),
    draw=draw,
    kinds=("antenna_plots", "polar_plots", "toa_marks"),
    overlay="time",
)
