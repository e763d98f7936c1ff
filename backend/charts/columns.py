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
        places = _places(column)
        count = int(places.max(initial=0)) + 1
        if count > 1:
            out = places if not out.any() else _counted(out * count + places)
    return out


def _places(column: Column) -> Ints:
    """Numbers that are ordered as the values are: those of texts as in the alphabet, NaN last."""
    if isinstance(column, Texts):
        _, places = np.unique([text or "" for text in column.categories], return_inverse=True)
        return _counted(column.mapped(places))
    return _counted(column)


def _counted(values: NDArray[Any]) -> Ints:
    """Places of values among the distinct ones; of whole numbers close together, such as tracks, without sorting."""
    absent = np.isnan(values)
    if absent.all():
        return np.zeros(values.size, np.int64)
    known = values[~absent]
    low, high = known.min(), known.max()
    if not np.isfinite(high - low) or high - low > values.size or (known != np.floor(known)).any():
        return np.unique(values, return_inverse=True)[1].astype(np.int64)
    last = int(high - low) + 1
    offset = np.where(absent, last, values - low).astype(np.int64)
    present = np.zeros(last + 1, bool)
    present[offset] = True
    return (np.cumsum(present) - 1)[offset]


def by_key_and_time(key: Ints, time: Floats) -> Ints:
    """Order by key, then time: what `np.lexsort((time, key))` gives, and much sooner where time rises."""
    if (
        key.size
        and int(key.min()) >= 0
        and int(key.max()) < 1 << 16
        and not (np.diff(time) < 0).any()
        and np.isfinite(time).all()
    ):
        # Sixteen bits are sorted by their digits.
        return np.argsort(key.astype(np.uint16), kind="stable")
    return np.lexsort((time, key))


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
