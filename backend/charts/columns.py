"""Read columns of result tables as arrays, whatever an algorithm left out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def numbers(table: Table, name: str) -> Floats:
    """A column as floats; NaN throughout where the table has no such column."""
    column = table.columns.get(name)
    if column is None:
        return np.full(len(table), np.nan)
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiub":
        return column.astype(np.float64)
    return np.array([np.nan if value is None else float(value) for value in column], np.float64)


def words(table: Table, name: str) -> NDArray[Any]:
    """A column as an object array of str; empty texts where the table has no such column or no value."""
    column = table.columns.get(name)
    out = np.full(len(table), "", object)
    if column is not None:
        out[:] = ["" if value is None else str(value) for value in column]
    return out


def codes(table: Table, *names: str) -> Ints:
    """Number the distinct combinations of these columns, in the order of their values."""
    out = np.zeros(len(table), np.int64)
    for name in names:
        column = table.columns.get(name)
        if column is None:
            continue
        is_number = isinstance(column, np.ndarray) and column.dtype.kind in "fiub"
        values = numbers(table, name) if is_number else words(table, name).astype(str)
        _, inverse = np.unique(values, return_inverse=True)
        _, out = np.unique(out * (int(inverse.max(initial=0)) + 1) + inverse, return_inverse=True)
    return out


def row_numbers(table: Table) -> Ints:
    """The column `row`, the recording's row numbers; -1 where unknown."""
    rows = numbers(table, "row")
    return np.where(np.isfinite(rows), rows, -1).astype(np.int64)


def used_marks(table: Table) -> NDArray[np.bool_]:
    """Rows whose mark went into the estimate: `used` lists what was used of it, or is a number; unknown = used."""
    column = table.columns.get("used")
    if column is None:
        return np.ones(len(table), bool)
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiub":
        return np.asarray(column != 0)
    return np.array([bool(value) for value in column], bool)
