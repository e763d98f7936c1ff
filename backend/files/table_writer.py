"""Write a table as CSV, row by row: an empty cell is null, numbers have all their digits, no text is a formula."""

from __future__ import annotations

import csv
from typing import Any, TextIO

from algorithms.result import Table
from backend.files.formula_guard import guarded

_ROWS_AT_ONCE = 20_000


def write_table_csv(table: Table, stream: TextIO, *, header: bool = True) -> None:
    """Write names and rows of a table; `header=False` continues one that was begun."""
    writer = csv.writer(stream, lineterminator="\n")
    if header:
        writer.writerow(table.names)
    for start in range(0, len(table), _ROWS_AT_ONCE):
        writer.writerows(map(_cells, table.rows(start, start + _ROWS_AT_ONCE)))


def _cells(row: tuple[Any, ...]) -> list[Any]:
    """The csv module writes None as an empty cell and floats with repr.

    Truth values become words of JSON; a whole number is written without its ".0", because a column of numbers with
    gaps (the track of a mark that has none) has to be a column of floats.
    """
    return [_cell(v) for v in row]


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return guarded(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return value
