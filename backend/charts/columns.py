"""Read columns of result tables as arrays, whatever an algorithm left out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Column, Table
from algorithms.texts import Texts

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def numbers(table: Table, name: str) -> Floats:
    """A column as floats; NaN throughout where the table has no such column."""
    column = table.columns.get(name)
    if column is None:
        return np.full(len(table), np.nan)
    if isinstance(column, Texts):
        return column.mapped(np.array([np.nan if text is None else float(text) for text in column.categories]))
    return column.astype(np.float64, copy=False)


def words(table: Table, name: str) -> NDArray[Any]:
    """A column as an object array of str; empty texts where the table has no such column or no value."""
    return texts(table, name).words()


def texts(table: Table, name: str) -> Texts:
    """A column as texts; none in any row where the table has no such column."""
    column = table.columns.get(name)
    if column is None:
        return Texts.repeated(None, len(table))
    return column if isinstance(column, Texts) else Texts.of([str(value) for value in column.tolist()])


def codes(table: Table, *names: str) -> Ints:
    """Number the distinct combinations of these columns, in the order of their values."""
    out = np.zeros(len(table), np.int64)
    for name in names:
        column = table.columns.get(name)
        if column is None:
            continue
        _, inverse = np.unique(_ordered(column), return_inverse=True)
        _, out = np.unique(out * (int(inverse.max(initial=0)) + 1) + inverse, return_inverse=True)
    return out


def _ordered(column: Column) -> NDArray[Any]:
    """Numbers, or for texts their places in the alphabet."""
    if not isinstance(column, Texts):
        return column
    _, places = np.unique([text or "" for text in column.categories], return_inverse=True)
    return column.mapped(places)


def row_numbers(table: Table) -> Ints:
    """The column `row`, the recording's row numbers; -1 where unknown."""
    rows = numbers(table, "row")
    return np.where(np.isfinite(rows), rows, -1).astype(np.int64)


def used_marks(table: Table) -> NDArray[np.bool_]:
    """Rows whose mark went into the estimate: `used` lists what was used of it, or is a number; unknown = used."""
    column = table.columns.get("used")
    if column is None:
        return np.ones(len(table), bool)
    if isinstance(column, Texts):
        return column.mapped(np.array([bool(text) for text in column.categories], bool))
    return np.asarray(column != 0)
