"""How unequal a converted mark's errors become towards the edge of the antenna's field of view."""

from __future__ import annotations

import numpy as np

from algorithms.recording import AntennaPlots
from algorithms.toolbox.frames.bicone import bicone_jacobian
from backend.charts.figure import ChartNote, not_applicable
from backend.charts.multiple_model.field_of_view import angles, draw_map
from backend.charts.view import Chart, ChartOptions, Figure, RecordingView

TITLE = "Condition of the conversion"


def draw(view: RecordingView, options: ChartOptions) -> Figure:
    """Draw the ratio of the largest to the smallest stretch of the conversion, angles taken times the range."""
    if not isinstance(view.recording, AntennaPlots):
        return not_applicable(TITLE, "other_kind")
    _, elevation, azimuth = angles()
    inside = np.isfinite(elevation)
    condition = np.full(elevation.shape, np.nan)
    stretch = np.linalg.svd(bicone_jacobian(1.0, elevation[inside], azimuth[inside]), compute_uv=False)
    condition[inside] = stretch[:, 0] / stretch[:, -1]
    text = "1 where the antenna looks; at the edge one direction is known far worse than the others."
    return draw_map(TITLE, "Ratio of stretches", condition, view.recording, options, [ChartNote("edge", text)])


CHART = Chart(name="conversion_condition", title=TITLE, source="recording", needs=(), draw=draw,
              kinds=("antenna_plots",))  # fmt: skip
