"""Receptions of a multilateration site in bins of time: by station, and by how many stations heard a mark."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import ToaMarks
from backend.charts import theme
from backend.charts.bins import TimeBins
from backend.charts.columns import Floats
from backend.charts.figure import Trace, axis, meta, trace
from backend.charts.view import ChartOptions

# Counts of receptions shown one by one: fewer than two give nothing, from five on a mark is overdetermined.
MOST_APART = 5


def raster(recording: ToaMarks, bins: TimeBins, options: ChartOptions) -> Trace:
    """Share of the marks that each station received, station by station over time; empty where there is no mark."""
    heard = np.isfinite(recording.toa_s[:, :, 0])
    at, size = bins.index(recording.time_s), bins.edges.size - 1
    marks = np.bincount(at, minlength=size)
    share = np.full((len(recording.stations), size), np.nan)
    for s in range(len(recording.stations)):
        received = np.bincount(at, heard[:, s], minlength=size)
        share[s, marks > 0] = 100 * received[marks > 0] / marks[marks > 0]
    steps = len(theme.SEQUENCE) - 1
    return {
        "type": "heatmap",
        "x": bins.edges,
        "y": [f"{name}" for name in recording.stations],
        "z": options.number(share),
        "zmin": 0,
        "zmax": 100,
        "colorscale": [[i / steps, color] for i, color in enumerate(theme.SEQUENCE)],
        # As long in a low panel as in a high one, where a share of it would leave no room for its numbers.
        "colorbar": {
            "title": {"text": "%"},
            "lenmode": "pixels",
            "len": 90,
            "y": 1,
            "yanchor": "top",
            "thickness": 10,
            "tickvals": [0, 50, 100],
        },
        "name": "receptions by station",
        "meta": meta("measurement"),
        "hovertemplate": "station %{y}<br>%{z:.0f} % of the marks<br>%{x:.5~g} s<extra></extra>",
        "xgap": 0,
        "ygap": 1,
    }


def shares(recording: ToaMarks, bins: TimeBins, yaxis: str) -> list[Trace]:
    """Share of marks by number of receptions, stacked; complete marks at the bottom."""
    stations = len(recording.stations)
    count = np.isfinite(recording.toa_s[:, :, 0]).sum(axis=1)
    at, size = bins.index(recording.time_s), bins.edges.size - 1
    marks = np.bincount(at, minlength=size).astype(float)
    groups = _groups(stations)
    out = []
    for i, (name, low, high) in enumerate(groups):
        inside = (count >= low) & (count <= high)
        received = np.bincount(at, inside, minlength=size)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(marks > 0, 100 * received / marks, np.nan)
        color = theme.SEQUENCE[max(len(theme.SEQUENCE) - 1 - i, 0)]
        out.append(
            trace(
                "measurement",
                bins.centres,
                share,
                name=name,
                type="bar",
                width=bins.width_s,
                marker={"color": color, "line": {"width": 0}},
                yaxis=yaxis,
                text=received.astype(np.int32),
                textposition="none",
                hovertemplate=f"<b>{name}</b><br>%{{y:.0f}} %, %{{text}} marks<br>{bins.width_s:g} s around "
                "%{x:.5~g} s<extra></extra>",
            )
        )
    return out


def _groups(stations: int) -> list[tuple[str, int, int]]:
    """Names and bounds of the groups, from the most receptions to the fewest."""
    if stations > MOST_APART:
        groups = [(f"{MOST_APART} or more receptions", MOST_APART, stations)]
    else:
        groups = [(f"complete ({stations} receptions)", stations, stations)]
    groups += [(f"{n} receptions", n, n) for n in range(min(stations, MOST_APART) - 1, 1, -1)]
    return [*groups, ("fewer than 2", 0, 1)]


def station_axis(recording: ToaMarks, domain: list[float]) -> dict[str, Any]:
    """Axis of the raster: the first station on top."""
    return axis("Station", type="category", autorange="reversed", domain=domain, showgrid=False)


def share_axis(domain: list[float], title: str = "Marks, %") -> dict[str, Any]:
    """Axis of shares in per cent."""
    return axis(title, range=[0, 102], domain=domain)


def used_shares(time_s: Floats, used: NDArray[np.bool_], bins: TimeBins) -> tuple[Floats, Floats]:
    """(bin,) share of marks that an entry used, per cent, and number of marks."""
    n, total = bins.sums(time_s, used.astype(float))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(n > 0, 100 * total / n, np.nan), n
