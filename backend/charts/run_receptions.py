"""Receptions of a run's recording, and what share of the marks each algorithm used."""

from __future__ import annotations

from algorithms.recording import ToaMarks
from backend.charts import receptions
from backend.charts.bins import time_bins
from backend.charts.estimates import estimates_of
from backend.charts.figure import ChartNote, figure, line_of, marker_of, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Receptions and marks used"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the raster, the shares by number of receptions and the share that each entry used."""
    recording = view.recording
    if not isinstance(recording, ToaMarks):
        return not_applicable(TITLE, "other_kind")
    if len(recording) == 0:
        return not_applicable(TITLE, "no_marks")
    bins = time_bins(recording.time_s)
    traces = [receptions.raster(recording, bins, options), *receptions.shares(recording, bins, "y2")]
    for entry in view.entries:
        states = estimates_of(entry)
        share, n = receptions.used_shares(states.time_s, states.used, bins)
        traces.append(
            trace(
                "series",
                bins.centres,
                share,
                entry=entry,
                name=entry.label,
                yaxis="y3",
                mode="lines+markers",
                line=line_of(entry),
                marker=marker_of(entry, size=5),
                text=n,
                hovertemplate=f"<b>{entry.label}</b><br>used %{{y:.0f}} % of %{{text}} marks<br>{bins.width_s:g} s "
                "around %{x:.5~g} s<extra></extra>",
            )
        )
    return figure(
        TITLE,
        traces,
        recording=recording,
        notes=[ChartNote("bins", f"Shares in bins of {bins.width_s:g} s.")],
        xaxis=time_axis(recording, anchor="y3"),
        yaxis=receptions.station_axis(recording, [0.66, 1]),
        yaxis2=receptions.share_axis([0.34, 0.62]),
        yaxis3=receptions.share_axis([0, 0.28], "Used, %"),
        barmode="stack",
        bargap=0,
    )


CHART = Chart(name="receptions", title=TITLE, source="run", needs=("states",), draw=draw, kinds=("toa_marks",))
