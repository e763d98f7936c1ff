"""How far a converted mark lies beside the truth on average, over the antenna's field of view."""

from __future__ import annotations

import numpy as np

from algorithms.errors import RecordingError
from algorithms.multiple_model.measurements import antenna_of
from algorithms.multiple_model.parameters import SIGMA_ANGLE_DEG, SIGMA_RANGE_M
from algorithms.recording import AntennaPlots
from algorithms.toolbox.frames.bicone import conversion_bias
from backend.charts.figure import ChartNote, not_applicable, thousands
from backend.charts.multiple_model.field_of_view import angles, draw_map
from backend.charts.view import Chart, ChartOptions, Figure, RecordingView

TITLE = "Bias of converted plots"


def draw(view: RecordingView, options: ChartOptions) -> Figure:
    """Draw the length of the second-order bias over the range error, at the recording's largest range."""
    recording = view.recording
    if not isinstance(recording, AntennaPlots):
        return not_applicable(TITLE, "other_kind")
    ranges = recording.range_m[np.isfinite(recording.range_m)]
    if not ranges.size:
        return not_applicable(TITLE, "no_marks")
    try:
        antenna = antenna_of(recording)
    except RecordingError:
        antenna = None
    range_m, sigma_m = float(ranges.max()), (antenna and antenna.sigma_range_m) or SIGMA_RANGE_M
    sd = [
        np.radians((antenna and getattr(antenna, f"sigma_bicone_{axis}_deg")) or SIGMA_ANGLE_DEG)
        for axis in ("elevation", "azimuth")
    ]
    _, elevation, azimuth = angles()
    ratio = np.linalg.norm(conversion_bias(range_m, elevation, azimuth, *sd), axis=0) / sigma_m
    text = f"At a range of {thousands(round(range_m / 1000))} km. Above 0.5 filter in the antenna's own coordinates."
    return draw_map(TITLE, "Ratio to the range error", ratio, recording, options, [ChartNote("farthest", text)])


CHART = Chart(name="conversion_bias", title=TITLE, source="recording", needs=(), draw=draw, kinds=("antenna_plots",))
