"""Single values of the trials of a run, cell by cell, as the charts of identification draw them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts.figure import Trace, trace
from backend.charts.trial_curves import Series
from backend.charts.view import Entry, swept_columns

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Cell:
    """One algorithm under one set of swept values: single values of each name, without those that are unknown."""

    name: str
    entry: Entry
    variant: int
    variants: int
    values: dict[str, Floats]

    def get(self, *names: str) -> tuple[Floats, ...]:
        """Values of these names, at instants and trials where all of them are known; empty where one is missing."""
        found = [self.values.get(name, np.empty(0)) for name in names]
        if len({v.size for v in found}) != 1:
            return tuple(np.empty(0) for _ in names)
        known = np.isfinite(np.stack(found)).all(axis=0)
        return tuple(v[known] for v in found)


def cells_of(entry: Entry) -> list[Cell]:
    """Return the cells of an entry; none where the run keeps no single values."""
    arrays = entry.arrays()
    if "trials/cells" not in arrays:
        return []
    cells = json.loads(bytes(arrays["trials/cells"]).decode())
    names = {key.split("/")[1] for key in arrays if key.startswith("trials/")} - {"cells", "kept_time_s"}
    out = []
    for i, swept in enumerate(cells):
        words = "".join(f", {key.rpartition('.')[2]} = {_word(value)}" for key, value in swept.items())
        values = {}
        for name in names:
            array = arrays.get(f"trials/{name}/{i}")
            if array is None and f"trials/{name}" in arrays:
                array = arrays[f"trials/{name}"][i]
            if array is not None:
                values[name] = np.asarray(array, np.float64).ravel()
        out.append(Cell(f"{entry.label}{words}", entry, i, len(cells), values))
    return out


def _word(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float) else str(value)


@dataclass(frozen=True)
class Measured:
    """A metric over the swept values of one algorithm, sorted by the first of them."""

    name: str
    variant: int
    variants: int
    x: Floats
    value: Floats
    low: Floats
    high: Floats


def swept_names(table: Table) -> list[str]:
    """Names of the swept numbers that the table has values of."""
    return [n for n in swept_columns(table) if np.isfinite(numbers(table, n)).any()]


def numbers(table: Table, name: str) -> Floats:
    """A column as numbers, NaN where it holds words."""
    column = table.columns[name]
    return np.asarray(column, float) if isinstance(column, np.ndarray) else np.full(len(table), np.nan)


def rows_of(table: Table, metric: str, target: str = "") -> NDArray[np.int64]:
    """Rows of a metric over everything, or of one target."""
    if not len(table):
        return np.empty(0, np.int64)
    named = zip(table.columns["metric"], table.columns["segment"], table.columns["target"], strict=True)
    return np.array([i for i, (m, s, t) in enumerate(named) if m == metric and not s and (t or "") == target], np.int64)


def measured(entry: Entry, metric: str) -> list[Measured]:
    """Return the metric against the first swept name, one for each combination of the others."""
    table = entry.table("metrics")
    rows = rows_of(table, metric)
    swept = swept_names(table) if rows.size else []
    if not swept:
        return []
    x = numbers(table, swept[0])
    others = {i: tuple(numbers(table, n)[i] for n in swept[1:]) for i in rows.tolist()}
    different = list(dict.fromkeys(others.values()))
    out = []
    for k, values in enumerate(different):
        own = np.array([i for i in rows if others[int(i)] == values and np.isfinite(x[i])], np.int64)
        own = own[np.argsort(x[own], kind="stable")]
        words = "".join(f", {n.rpartition('.')[2]} = {v:g}" for n, v in zip(swept[1:], values, strict=True))
        value, low, high = (numbers(table, n)[own] for n in ("value", "ci95_low", "ci95_high"))
        out.append(Measured(f"{entry.label}{words}", k, len(different), x[own], value, low, high))
    return out


def line_over_scans(series: Series, name: str, values: Floats, hover: str, **look: Any) -> Trace:
    """A curve over the scans with all its values, of any sign: scans are few."""
    return trace(
        "series",
        series.time_s,
        values,
        entry=series.entry,
        name=name,
        mode="lines",
        line=series.look | look,
        hovertemplate=f"<b>{name}</b><br>{hover}<br>%{{x:.5~g}} s<extra></extra>",
    )
