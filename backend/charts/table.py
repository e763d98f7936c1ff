"""The points of a figure as a long table: what the same address gives with the suffix `.csv`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Column, Table
from algorithms.texts import Texts
from backend.charts.columns import Floats
from backend.charts.figure import Trace
from backend.charts.view import Figure

COLUMNS = ("label", "trace", "role", "x_axis", "y_axis", "x", "y", "z", "x_text", "y_text", "row", "time_s")
NUMBERS = ("x", "y", "z", "row", "time_s")


def chart_table(drawn: Figure) -> Table:
    """List every point of a figure; one row each, in the order of the traces.

    Columns: `label`, `trace`, `role`; `x_axis`, `y_axis` (titles with units); `x`, `y`, `z` (z of a map, else null);
    `x_text`, `y_text` for axes of names; `row` (the recording's, null where the point stands for no mark); `time_s` of
    the mark where x is not time. Points that break a line are left out. Draw with `ChartOptions(full=True)` for every
    point in double precision.
    """
    parts = [_points(trace, drawn["layout"]) for trace in drawn["data"]]
    columns: dict[str, Column] = {}
    for name in COLUMNS:
        pieces = [part[name] for part in parts]
        if name in NUMBERS:
            columns[name] = np.concatenate([np.empty(0), *pieces])
        else:
            columns[name] = Texts.joined(Texts.of(piece) for piece in pieces)
    return Table(columns)


def _points(trace: Trace, layout: dict[str, Any]) -> dict[str, Any]:
    x_values, y_values, z = _spread(trace)
    x, x_text = _numbers_or_words(x_values)
    y, y_text = _numbers_or_words(y_values)
    placed = (np.isfinite(x) | (x_text != "")) & (np.isfinite(y) | (y_text != ""))
    keep = np.flatnonzero(placed)
    row, time = _mark(trace, x.size)
    about = trace["meta"]
    titles = {k: layout.get(_axis_key(k, trace), {}).get("title", {}).get("text", "") for k in "xy"}

    def same(value: str | None) -> Texts:
        return Texts.repeated(value, keep.size)

    return {
        "label": same(about["label"]),
        "trace": same(trace["name"]),
        "role": same(about["role"]),
        "x_axis": same(titles["x"]),
        "y_axis": same(titles["y"]),
        "x": x[keep],
        "y": y[keep],
        "z": z[keep],
        "x_text": [text or None for text in x_text[keep]],
        "y_text": [text or None for text in y_text[keep]],
        "row": row[keep],
        "time_s": time[keep],
    }


def _axis_key(letter: str, trace: Trace) -> str:
    """`y2` of a trace is `yaxis2` of the layout."""
    return f"{letter}axis{trace.get(f'{letter}axis', letter)[1:]}"


def _spread(trace: Trace) -> tuple[Any, Any, Floats]:
    """x, y and z of each point; the cells of a map become points at their middle."""
    if trace["type"] != "heatmap":
        x = np.asarray(trace["x"], float) if isinstance(trace["x"], np.ndarray) else list(trace["x"])
        return x, trace["y"], np.asarray(trace["z"], float) if "z" in trace else np.full(len(x), np.nan)
    # Where colours are logarithms the values stand beside them.
    z = np.asarray(trace.get("customdata", trace["z"]), np.float64)
    edges = np.asarray(trace["x"], np.float64)
    middle = (edges[:-1] + edges[1:]) / 2
    return np.tile(middle, z.shape[0]), [name for name in trace["y"] for _ in range(z.shape[1])], z.ravel()


def _numbers_or_words(values: Any) -> tuple[Floats, NDArray[Any]]:
    words = np.full(len(values), "", object)
    if len(values) and isinstance(values[0], str):
        words[:] = values
        return np.full(len(values), np.nan), words
    return np.asarray(values, np.float64), words


def _mark(trace: Trace, size: int) -> tuple[Floats, Floats]:
    """Row number and time of the mark that each point stands for."""
    unknown = np.full(size, np.nan)
    if "customdata" not in trace or trace["type"] == "heatmap":
        return unknown, unknown
    rows = np.asarray(trace["customdata"], np.float64)
    time = trace.get("text", unknown)
    return np.where(rows < 0, np.nan, rows), np.asarray(time, np.float64)
