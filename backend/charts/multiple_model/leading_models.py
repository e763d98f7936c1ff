"""Plan of one run in which an estimate has the colour of the model that leads there."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.columns import Ints, numbers, words
from backend.charts.decimate import thin
from backend.charts.estimates import estimates_of
from backend.charts.figure import hover, not_applicable, trace
from backend.charts.plane import MARK, PLACE, Plane
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Leading models"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the estimates of each entry with several models, the true path dashed above them."""
    found = [entry for entry in view.entries if len(entry.table("mode_probabilities"))]
    if not found:
        return not_applicable(TITLE, "no_models")
    plane = Plane(view.recording, options)
    plane.add_plots()
    colours: dict[str, str] = {}
    for entry in found:
        _add_estimates(plane, entry, options, colours)
    for recording in view.recordings:
        plane.add_truth(recording)
    plane.add_stations()
    drawn = plane.draw(TITLE)
    # Colours stand for models here, so the page must name them, each once; what a true path is other plans say.
    drawn["layout"]["meta"]["legend"] = True
    named: set[str] = set()
    for one in drawn["data"]:
        one["showlegend"] = one["meta"]["role"] == "series" and one["name"] not in named
        named.add(one["name"])
    return drawn


def _add_estimates(plane: Plane, entry: Entry, options: ChartOptions, colours: dict[str, str]) -> None:
    """Markers of one entry, model by model; the same model has the same colour in all entries."""
    states = estimates_of(entry)
    names, row, leading = _leaders(entry)
    east, north = states.numbers("east_m"), states.numbers("north_m")
    place = np.searchsorted(row, states.row).clip(0, max(row.size - 1, 0))
    known = (row[place] == states.row) if row.size else np.zeros(states.row.size, np.bool_)
    for m, name in enumerate(names):
        here = known & np.isfinite(east + north)
        here[here] = leading[place[here]] == m
        points = thin(np.flatnonzero(here), options.marks)
        if points.of == 0:
            continue
        colour = colours.setdefault(name, theme.series_color(len(colours)))
        plane.picked.append(points)
        plane.traces.append(
            trace(
                "series",
                points.take(east),
                points.take(north),
                entry=entry,
                name=name,
                mode="markers",
                marker={"color": colour, "size": 5},
                customdata=points.take(states.row),
                text=points.take(states.time_s),
                **hover(points, f"{entry.label}, {name}", f"{PLACE}<br>{MARK}"),
            )
        )


def _leaders(entry: Entry) -> tuple[list[str], Ints, Ints]:
    """Names of the models, rows in rising order, and which model has the largest probability at each."""
    table = entry.table("mode_probabilities")
    models = words(table, "model")
    names = list(dict.fromkeys(models.tolist()))
    number = np.array([names.index(name) for name in models.tolist()], np.int64)
    row, probability = numbers(table, "row"), numbers(table, "probability")
    # Of one row the largest probability stands last, of equal ones the first model's.
    order = np.lexsort((-number, probability, row))
    row, number = row[order], number[order]
    last = np.flatnonzero(np.diff(row, append=np.inf))
    return names, row[last].astype(np.int64), number[last]


CHART = Chart(
    name="leading_models",
    title=TITLE,
    source="run",
    needs=("states", "mode_probabilities"),
    draw=draw,
    kinds=("antenna_plots", "polar_plots"),
    overlay="frame",
)
