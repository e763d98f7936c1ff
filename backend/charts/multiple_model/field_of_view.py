"""Maps over an antenna's field of view, with the recording's plots on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from algorithms.recording import AntennaPlots, Recording
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import thin
from backend.charts.figure import ChartNote, Trace, axis, figure, hover, meta, trace
from backend.charts.view import ChartOptions, Figure

STEP_DEG = 2.0
EDGE_DEG = 89.0
# At the edge itself everything grows without end; the map stops so far off the boresight.
OFF_BORESIGHT_DEG = 88.0
# More markers would be painted under the map.
PLOTS = 240


def angles() -> tuple[Floats, Floats, Floats]:
    """Axis of the map in degrees; bicone elevation and azimuth of its cells, rad, NaN towards the edge and beyond."""
    degrees = np.arange(-EDGE_DEG, EDGE_DEG + 0.5 * STEP_DEG, STEP_DEG)
    elevation, azimuth = np.meshgrid(np.radians(degrees), np.radians(degrees), indexing="ij")
    inside = np.sin(elevation) ** 2 + np.sin(azimuth) ** 2 < np.sin(np.radians(OFF_BORESIGHT_DEG)) ** 2
    return degrees, np.where(inside, elevation, np.nan), np.where(inside, azimuth, np.nan)


def draw_map(
    title: str,
    quantity: str,
    values: Floats,
    recording: Recording,
    options: ChartOptions,
    notes: Sequence[ChartNote],
) -> Figure:
    """Draw positive values (elevation, azimuth) on a logarithmic scale; the colours end at their 99 % quantile."""
    degrees = angles()[0]
    edges = np.append(degrees - STEP_DEG / 2, degrees[-1] + STEP_DEG / 2)
    known = values[np.isfinite(values)]
    low, high = float(known.min()), float(np.quantile(known, 0.99))
    with np.errstate(divide="ignore", invalid="ignore"):
        shades = np.log10(values).astype(np.float32)
    ticks = low * (high / low) ** np.linspace(0, 1, 5)
    map_: dict[str, Any] = {
        "type": "heatmap", "x": edges.astype(np.float32), "y": degrees.astype(np.float32), "z": shades,
        "customdata": values.astype(np.float32), "zmin": float(np.log10(low)), "zmax": float(np.log10(high)),
        "colorscale": [[i / (len(theme.SEQUENCE) - 1), c] for i, c in enumerate(theme.SEQUENCE)],
        "colorbar": {"title": {"text": quantity, "side": "right"}, "thickness": 12, "tickvals": np.log10(ticks),
                     "ticktext": [f"{v:.2g}" for v in ticks]},
        "name": quantity, "meta": meta("bound"),
        "hovertemplate": "%{x:.0f}° azimuth, %{y:.0f}° elevation: %{customdata:.3~g}<extra></extra>",
    }  # fmt: skip
    traces: list[Trace] = [map_]
    if isinstance(recording, AntennaPlots):
        azimuth, elevation = (
            np.degrees(a[:, 0]) for a in (recording.bicone_azimuth_rad, recording.bicone_elevation_rad)
        )
        points = thin(np.flatnonzero(np.isfinite(azimuth + elevation)), None if options.full else PLOTS)
        traces.append(
            trace(
                "measurement",
                options.number(points.take(azimuth)),
                options.number(points.take(elevation)),
                name="plot",
                mode="markers",
                marker={"color": theme.MEASUREMENT, "size": 4},
                customdata=points.take(recording.row),
                text=points.take(recording.time_s),
                **hover(points, "plot", "%{x:.3f}° azimuth, %{y:.3f}° elevation<br>%{text:.3f} s, row %{customdata}"),
            )
        )
    edge = [-90.0, 90.0]
    return figure(
        title,
        traces,
        recording=recording,
        notes=notes,
        xaxis=axis("Bicone azimuth, deg", range=edge, constrain="domain"),
        yaxis=axis("Bicone elevation, deg", range=edge, scaleanchor="x", scaleratio=1, constrain="domain"),
        dragmode="pan",
    )
