"""Map of the probability of a correct association over where target 2 is: two swept values."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, meta, not_applicable, trace
from backend.charts.identification.samples import numbers, rows_of, swept_names
from backend.charts.swept import title_of
from backend.charts.trials_sweep import ticks
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Correct association over two swept values"
# The share that the paper prints for target 1, and the placements that reproduce it (specification 12.1).
ISO = 0.66
RECONSTRUCTED = ((1060.0, 0.0), (-1060.0, 0.0))


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the map of the first algorithm that has two swept values."""
    for entry in view.entries:
        table = entry.table("metrics")
        swept = swept_names(table) if len(table) else []
        rows = rows_of(table, "probability_correct")
        if not 1 <= len(swept) <= 2 or not rows.size:
            continue
        x = numbers(table, swept[0])[rows]
        # One swept value makes a strip.
        y = numbers(table, swept[1])[rows] if len(swept) == 2 else np.zeros(rows.size)
        xs, ys = np.unique(x), np.unique(y)
        if xs.size < 2:
            continue
        z = np.full((ys.size, xs.size), np.nan)
        z[np.searchsorted(ys, y), np.searchsorted(xs, x)] = numbers(table, "value")[rows]
        traces: list[Trace] = [
            {
                "type": "heatmap",
                "x": _edges(xs),
                # Rows are as high as their values lie apart.
                "y": _edges(ys) if ys.size > 1 else ["0"],
                "z": z,
                "zmin": 0,
                "zmax": 1,
                "colorscale": [[i / 5, c] for i, c in enumerate(theme.SEQUENCE)],
                "colorbar": {"title": {"text": "P"}, "thickness": 12},
                "name": entry.label,
                "meta": meta("series", entry),
                "hovertemplate": "%{x:g}, %{y}: %{z:.3f}<extra></extra>",
            }
        ]
        traces += _iso(xs, ys, z)
        traces += _paper(swept, ys)
        text = (
            f"Of {entry.label}. The diamonds are places with a share of {ISO:g}, which the paper prints for target 1."
        )
        return figure(
            TITLE,
            traces,
            recording=view.recording,
            notes=[ChartNote("placement", text)],
            xaxis=axis(title_of(swept[0], view)),
            yaxis=axis(title_of(swept[-1], view), **(ticks(ys, log=False) if ys.size > 1 else {"type": "category"})),
        )
    return not_applicable(TITLE, "no_second_sweep")


def _edges(values: np.ndarray) -> np.ndarray:
    """Edges of cells around these values."""
    middle = (values[:-1] + values[1:]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _rows(values: np.ndarray, ys: np.ndarray) -> np.ndarray | list[str]:
    """Places on the axis of the rows; a single row has no number."""
    return values if ys.size > 1 else ["0"] * values.size


def _iso(xs: np.ndarray, ys: np.ndarray, z: np.ndarray) -> list[Trace]:
    """Crossings of the printed share along each row."""
    px: list[float] = []
    py: list[float] = []
    for k, row in enumerate(z):
        for i in np.flatnonzero((row[:-1] - ISO) * (row[1:] - ISO) < 0):
            px.append(float(xs[i] + (ISO - row[i]) / (row[i + 1] - row[i]) * (xs[i + 1] - xs[i])))
            py.append(float(ys[k]))
    if not px:
        return []
    marker = {"color": theme.SERIES[1], "size": 7, "symbol": "diamond"}
    name = f"share {ISO:g}"
    return [trace("bound", np.array(px), _rows(np.array(py), ys), name=name, mode="markers", marker=marker)]


def _paper(swept: list[str], ys: np.ndarray) -> list[Trace]:
    """Placements that reproduce the paper, where the sweep is over the placement."""
    short = [name.rpartition(".")[2] for name in swept]
    if short != ["offset_along_m", "offset_across_m"] or 0.0 not in ys:
        return []
    x = np.array([p[0] for p in RECONSTRUCTED])
    marker = {"color": theme.TEXT, "size": 10, "symbol": "x-thin", "line": {"width": 2, "color": theme.TEXT}}
    return [trace("truth", x, _rows(np.zeros(2), ys), name="reconstructed placement", mode="markers", marker=marker)]


CHART = Chart(
    name="trials_placement",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("polar_plots",),
    least_sweeps=2,
)
