"""Residuals of each receiver, and which receiver disagrees with the others.

A residual is what a reception leaves after the estimate of its mark, about the mean of the mark's residuals. A good
receiver's lie around zero; those of one that is late or stands elsewhere are shifted, and so are, by less, those of
its neighbours: which one is to blame is told by the test of receivers (table `receivers`), not by the eye.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import ToaMarks
from algorithms.result import Table
from backend.charts import theme
from backend.charts.columns import Floats, Ints, numbers, words
from backend.charts.figure import (
    ChartNote,
    Trace,
    axis,
    counted,
    figure,
    marker_of,
    not_applicable,
    thousands,
    trace,
)
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Residuals by receiver"
SUSPECT = 1.0


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the median and the middle 90 % of the residuals that entered the estimates, receiver by receiver."""
    recording = view.recording
    if not isinstance(recording, ToaMarks):
        return not_applicable(TITLE, "other_kind")
    found = [(entry, _residuals(entry, recording)) for entry in view.entries]
    if not any(np.isfinite(residual).any() for _, residual in found):
        return not_applicable(TITLE, "no_residuals")
    traces: list[Trace] = []
    notes: list[ChartNote] = []
    suspects: dict[str, None] = {}
    for entry, residual in found:
        count = np.isfinite(residual).sum(axis=0)
        heard = np.flatnonzero(count)
        if not heard.size:
            continue
        low, median, high = np.nanpercentile(residual[:, heard], (5, 50, 95), axis=0)
        names = [recording.stations[s] for s in heard.tolist()]
        traces += _spread(entry, names, (low, median, high), count[heard], options)
        judged = entry.table("receivers")
        reasons = dict(zip(words(judged, "station"), words(judged, "reason"), strict=True))
        bad = set(_named(judged, numbers(judged, "suspect") == SUSPECT))
        marked = [i for i, name in enumerate(names) if name in bad]
        if marked:
            traces.append(_rings(entry, [names[i] for i in marked], median[marked], reasons))
        for name in (n for n in recording.stations if n in bad):
            suspects[name] = None
            text = f"Station {name} disagrees with the others: {reasons[name]}."
            notes.append(ChartNote("suspect_receiver", text, entry.label))
        open_cases = _named(judged, np.isnan(numbers(judged, "suspect")))
        if open_cases:
            share = f"{counted(len(open_cases), 'station')} of {len(recording.stations)}"
            text = f"Cannot be judged: {share}; the table of receivers says why."
            notes.append(ChartNote("receivers_not_judged", text, entry.label))
    return figure(
        TITLE,
        traces,
        recording=recording,
        notes=notes,
        xaxis=axis("Station", type="category", categoryorder="array", categoryarray=list(recording.stations)),
        yaxis=axis("Residual, m", zeroline=True, zerolinecolor=theme.AXIS),
        scattermode="group",
        scattergap=0.4,
        annotations=[_label(recording.stations.index(name)) for name in suspects],
    )


def _residuals(entry: Entry, recording: ToaMarks) -> Floats:
    """(mark and trial, station) residuals of the recording's marks, m; NaN where a reception was not used."""
    arrays = entry.arrays()
    if not {"residual_m", "used", "row"} <= set(arrays):
        return np.empty((0, len(recording.stations)))
    mine = np.isin(arrays["row"], recording.row)
    residual = np.where(arrays["used"][mine], arrays["residual_m"][mine], np.nan).astype(np.float64)
    return np.moveaxis(residual, 2, 1).reshape(-1, residual.shape[1])


def _spread(
    entry: Entry,
    names: list[str],
    percentiles: tuple[Floats, Floats, Floats],
    count: Ints,
    options: ChartOptions,
) -> list[Trace]:
    """A bar from the 5th to the 95th percentile, a marker at the median."""
    low, median, high = percentiles
    gap = np.full(low.size, np.nan)
    color = theme.series_color(entry.index)
    says = [
        f"{thousands(int(n))} residuals, middle 90 % {a:.3g} to {b:.3g} m"
        for n, a, b in zip(count, low, high, strict=True)
    ]
    return [
        trace(
            "interval",
            [name for name in names for _ in range(3)],
            options.number(np.stack((low, high, gap), axis=1).ravel()),
            entry=entry,
            name=f"{entry.label}, middle 90 %",
            offsetgroup=entry.label,
            showlegend=False,
            mode="lines",
            line={"color": color, "width": 2},
            hoverinfo="skip",
        ),
        trace(
            "series",
            names,
            options.number(median),
            entry=entry,
            name=entry.label,
            offsetgroup=entry.label,
            mode="markers",
            marker=marker_of(entry, 8),
            hovertext=says,
            hovertemplate=f"<b>{entry.label}</b><br>station %{{x}}, median %{{y:.3~g}} m<br>%{{hovertext}}"
            "<extra></extra>",
        ),
    ]


def _rings(entry: Entry, names: list[str], median: Floats, reasons: dict[str, str]) -> Trace:
    """A ring around each receiver that disagrees."""
    color = theme.series_color(entry.index)
    return trace(
        "rejected",
        names,
        median.astype(np.float32),
        entry=entry,
        name=f"{entry.label}, disagrees",
        offsetgroup=entry.label,
        showlegend=False,
        mode="markers",
        marker={"symbol": "circle-open", "size": 18, "color": color, "line": {"color": color, "width": 2.5}},
        hovertext=[reasons[name] for name in names],
        hovertemplate=f"<b>{entry.label}</b><br>station %{{x}} disagrees: %{{hovertext}}<extra></extra>",
    )


def _named(table: Table, chosen: NDArray[np.bool_]) -> list[str]:
    return [str(name) for name in words(table, "station")[chosen]]


def _label(place: int) -> dict[str, object]:
    return {
        # By its place: a name that is a number would be taken for one.
        "x": place,
        "y": 1,
        "yref": "paper",
        "yanchor": "top",
        "text": "disagrees",
        "showarrow": False,
        "font": {"size": 11, "color": theme.BOUND},
    }


CHART = Chart(name="residuals", title=TITLE, source="run", needs=("receivers",), draw=draw, kinds=("toa_marks",))
