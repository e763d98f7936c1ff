"""Measured quantities of a recording over time, one panel each."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.recording import AntennaPlots, DopplerPairs, PolarPlots, Recording, ToaMarks
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, thin
from backend.charts.figure import Trace, axis, figure, hover, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Figure, RecordingView

TITLE = "Measurements"
GAP = 0.06
# Channels named in the legend; of more, the hover names each.
NAMED = 6
Panel = tuple[str, tuple[tuple[str, Floats], ...]]


def draw(view: RecordingView, options: ChartOptions) -> Figure:
    """Draw every measured quantity that the recording holds."""
    recording = view.recording
    panels = [(title, held) for title, quantities in _panels(recording) if (held := _held(quantities))]
    if not panels:
        return not_applicable(TITLE, "no_marks")
    traces: list[Trace] = []
    picked: list[Picked] = []
    axes: dict[str, Any] = {}
    height = (1 - GAP * (len(panels) - 1)) / len(panels)
    for i, (title, quantities) in enumerate(panels):
        top = 1 - i * (height + GAP)
        key = "" if i == 0 else str(i + 1)
        axes[f"yaxis{key}"] = axis(title, domain=[max(top - height, 0), top])
        most = None if options.marks is None else max(options.marks // (len(quantities) * len(panels)), 1)
        for k, (name, values) in enumerate(quantities):
            points = thin(np.flatnonzero(np.isfinite(values)), most)
            picked.append(points)
            # Channels of one quantity are told apart by symbol; all are measurements.
            symbol = theme.SYMBOLS[k % len(theme.SYMBOLS)] + ("-open" if k else "")
            traces.append(
                trace(
                    "measurement",
                    points.take(recording.time_s),
                    options.number(points.take(values)),
                    name=name,
                    showlegend=1 < len(quantities) <= NAMED,
                    yaxis=f"y{key}",
                    mode="markers",
                    marker={"color": theme.MEASUREMENT, "size": 4, "symbol": symbol},
                    customdata=points.take(recording.row),
                    **hover(points, name, "%{y:.6~g}<br>%{x:.3f} s, row %{customdata}"),
                )
            )
    last = "y" if len(panels) == 1 else f"y{len(panels)}"
    return figure(TITLE, traces, recording=recording, picked=picked, xaxis=time_axis(recording, anchor=last), **axes)


def _held(quantities: tuple[tuple[str, Floats], ...]) -> tuple[tuple[str, Floats], ...]:
    return tuple((name, values) for name, values in quantities if np.isfinite(values).any())


def _panels(recording: Recording) -> list[Panel]:
    match recording:
        case PolarPlots():
            return [
                ("Range, m", (("range", recording.range_m[:, 0]),)),
                ("Azimuth, deg", (("azimuth", np.degrees(recording.azimuth_rad[:, 0])),)),
                ("Elevation, deg", (("elevation", np.degrees(recording.elevation_rad[:, 0])),)),
                ("Altitude, m", (("altitude", recording.altitude_m[:, 0]),)),
                ("From the radar, m", (("east", recording.east_m[:, 0]), ("north", recording.north_m[:, 0]))),
            ]
        case AntennaPlots():
            return [
                ("Range, m", (("range", recording.range_m[:, 0]),)),
                ("Bicone elevation, deg", (("elevation", np.degrees(recording.bicone_elevation_rad[:, 0])),)),
                ("Bicone azimuth, deg", (("azimuth", np.degrees(recording.bicone_azimuth_rad[:, 0])),)),
            ]
        case DopplerPairs():
            doppler = [(f"channel {c}", recording.doppler_hz[:, i, 0]) for i, c in enumerate(recording.channels)]
            rates = recording.doppler_rate_hz_s
            rate = [(f"rate {i + 1}", rates[:, i, 0]) for i in range(rates.shape[1])]
            return [
                ("Doppler, Hz", tuple(doppler)),
                ("Doppler rate, Hz/s", tuple(rate)),
                ("Azimuth, deg", (("azimuth", np.degrees(recording.azimuth_rad[:, 0])),)),
                ("Elevation, deg", (("elevation", np.degrees(recording.elevation_rad[:, 0])),)),
            ]
        case ToaMarks():
            spread = recording.toa_s[:, :, 0] - _first_reception(recording)[:, None]
            delay = [(f"station {name}", 1e6 * spread[:, i]) for i, name in enumerate(recording.stations)]
            return [
                ("Delay, µs", tuple(delay)),
                ("Altitude, m", (("altitude", recording.altitude_m[:, 0]),)),
            ]
    return []


def _first_reception(recording: ToaMarks) -> Floats:
    toa = recording.toa_s[:, :, 0]
    first = np.where(np.isfinite(toa), toa, np.inf).min(axis=1, initial=np.inf)
    return np.where(np.isfinite(first), first, np.nan)


CHART = Chart(name="measurements", title=TITLE, source="recording", needs=(), draw=draw)
