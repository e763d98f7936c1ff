"""Plan of a recording: stations, true paths, plots; a station's size stands for its receptions."""

from __future__ import annotations

import numpy as np

from algorithms.recording import ToaMarks
from backend.charts.plane import Plane
from backend.charts.view import Chart, ChartOptions, Figure, RecordingView

TITLE = "Plan"


def draw(view: RecordingView, options: ChartOptions) -> Figure:
    """Draw what has a place in the plane."""
    recording = view.recording
    plane = Plane(recording, options)
    plane.add_plots()
    plane.add_truth(view.recording)
    receptions = None
    if isinstance(recording, ToaMarks):
        counts = np.isfinite(recording.toa_s[:, :, 0]).sum(axis=0)
        receptions = {name: int(n) for name, n in zip(recording.stations, counts, strict=True)}
    plane.add_stations(receptions)
    return plane.draw(TITLE)


CHART = Chart(name="plan", title=TITLE, source="recording", needs=(), draw=draw)
