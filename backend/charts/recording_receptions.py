"""Receptions of a recording: which station heard what, and how complete the marks are."""

from __future__ import annotations

from algorithms.recording import ToaMarks
from backend.charts import receptions
from backend.charts.bins import time_bins
from backend.charts.figure import ChartNote, figure, not_applicable, time_axis
from backend.charts.view import Chart, ChartOptions, Figure, RecordingView

TITLE = "Receptions"


def draw(view: RecordingView, options: ChartOptions) -> Figure:
    """Draw the raster above, the shares below."""
    recording = view.recording
    if not isinstance(recording, ToaMarks):
        return not_applicable(TITLE, "other_kind")
    if len(recording) == 0:
        return not_applicable(TITLE, "no_marks")
    bins = time_bins(recording.time_s)
    traces = [receptions.raster(recording, bins, options), *receptions.shares(recording, bins, "y2")]
    return figure(
        TITLE,
        traces,
        recording=recording,
        notes=[ChartNote("bins", f"Shares in bins of {bins.width_s:g} s.")],
        xaxis=time_axis(recording, anchor="y2"),
        yaxis=receptions.station_axis(recording, [0.5, 1]),
        yaxis2=receptions.share_axis([0, 0.44]),
        barmode="stack",
        bargap=0,
    )


CHART = Chart(name="receptions", title=TITLE, source="recording", needs=(), draw=draw, kinds=("toa_marks",))
