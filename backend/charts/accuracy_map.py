"""Map of the bound of one mark over a plan: how accurate a position can be at all, and where it cannot be told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend.charts import theme
from backend.charts.contours import contour_lines, contour_traces, levels_between
from backend.charts.figure import ChartNote, Trace, axis, figure, meta, not_applicable, trace
from backend.charts.view import Figure

Floats = NDArray[np.float64]

# Ten shades on a logarithmic scale between these quantiles: one place beside a station must not take them all.
QUANTILES = (0.02, 0.98)
LEAST_SPAN = 1.5
KM = 1e-3
FINE = 120


def draw(
    east_m: Floats,
    north_m: Floats,
    values: Floats,
    *,
    title: str,
    quantity: str,
    unit: str,
    stations_m: Floats,
    names: Sequence[str],
    used: Sequence[bool],
    notes: Sequence[ChartNote] = (),
) -> Figure:
    """Draw values (north, east) over their axes; NaN is left blank, and its share is said.

    `used` tells which stations the map is of; the others are drawn hollow.
    """
    known = values[np.isfinite(values) & (values > 0)]
    if not known.size:
        return not_applicable(title, "nothing_observable")
    low, high = np.quantile(known, QUANTILES)
    middle = np.sqrt(low * high)
    low, high = min(low, middle / LEAST_SPAN), max(high, middle * LEAST_SPAN)
    ticks = _round_numbers(low, high)
    with np.errstate(divide="ignore", invalid="ignore"):
        shades = np.log10(values).astype(np.float32)
    traces: list[Trace] = [
        {
            "type": "heatmap",
            "x": (east_m * KM).astype(np.float32),
            "y": (north_m * KM).astype(np.float32),
            "z": shades,
            "customdata": values.astype(np.float32),
            "zmin": float(np.log10(low)),
            "zmax": float(np.log10(high)),
            "colorscale": [[i / (len(theme.SEQUENCE) - 1), c] for i, c in enumerate(theme.SEQUENCE)],
            "colorbar": {
                "title": {"text": f"{quantity}, {unit}" if unit else quantity, "side": "right"},
                "thickness": 12,
                "tickvals": np.log10(ticks),
                "ticktext": [f"{v:,.15g}".replace(",", "\u2009") for v in ticks],
            },
            "name": quantity,
            "meta": meta("bound"),
            "hovertemplate": f"%{{x:.2f}} km east, %{{y:.2f}} km north: %{{customdata:.4~g}} {unit}<extra></extra>",
        },
        *_lines(east_m, north_m, values, float(low), float(high), quantity, unit),
        _stations(stations_m, names, used),
    ]
    said = list(notes)
    words = " and ".join(f"{value:.3g}" for value in (low, high))
    said.append(ChartNote("colours_end", f"Colours end at {words} {unit}".rstrip() + "; beyond, they stay the same."))
    blank = int((~np.isfinite(values)).sum())
    if blank:
        text = f"Not observable, left blank: {100 * blank / values.size:.3g} % of the map."
        said.append(ChartNote("not_observable", text))
    return figure(
        title,
        traces,
        recording=None,
        notes=said,
        xaxis=axis("East, km", range=_range(east_m), constrain="domain"),
        yaxis=axis("North, km", range=_range(north_m), scaleanchor="x", scaleratio=1, constrain="domain"),
        dragmode="pan",
    )


def _lines(
    east_m: Floats, north_m: Floats, values: Floats, low: float, high: float, quantity: str, unit: str
) -> list[Trace]:
    """Lines of equal value at round numbers, from every second place of a fine map."""
    step = 2 if max(values.shape) > FINE else 1
    drawn = values[::step, ::step]
    lines = contour_lines(east_m[::step] * KM, north_m[::step] * KM, drawn, levels_between(low, high))
    return contour_traces(lines, quantity, unit, theme.TEXT)


def _stations(stations_m: Floats, names: Sequence[str], used: Sequence[bool]) -> Trace:
    symbols = ["triangle-up" if one else "triangle-up-open" for one in used]
    look: dict[str, Any] = {"symbol": symbols, "size": 11, "color": theme.STATION}
    return trace(
        "station",
        stations_m[:, 0] * KM,
        stations_m[:, 1] * KM,
        name="station",
        mode="markers+text",
        text=list(names),
        textposition="top center",
        textfont={"size": 11, "color": theme.STATION},
        marker=look | {"line": {"color": theme.SURFACE, "width": 1}},
        hovertemplate="station %{text}<br>%{x:.3f} km east, %{y:.3f} km north<extra></extra>",
    )


def _range(values_m: Floats) -> list[float]:
    return [float(values_m[0]) * KM, float(values_m[-1]) * KM]


def _round_numbers(low: float, high: float) -> Floats:
    """1, 2 and 5 times powers of ten between two positive numbers; at least the ends."""
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    ticks = np.sort((powers[:, None] * np.array([1.0, 2.0, 5.0])).ravel())
    inside = ticks[(ticks >= 0.999 * low) & (ticks <= 1.001 * high)]
    return inside if inside.size >= 2 else np.array([low, high])
