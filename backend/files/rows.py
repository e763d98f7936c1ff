"""Rows of a file by column: what every container of a table (text, Parquet, MATLAB, NumPy) gives to the readers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import InputError
from algorithms.recording import Floats, Ints
from backend.files.regular_blocks import ArrowCells
from backend.files.report import Findings, some

Cells = Sequence[str] | Floats
"""Cells of a column: texts, or, where the container knows them as numbers, float64 with NaN for nothing."""

ROWS_AT_ONCE = 50_000


@dataclass(frozen=True)
class Chunk:
    """Some consecutive rows: their numbers in the file (first data row = 1), physical lines, and cells by column.

    `line` is 0 where the container has no lines.
    """

    row: Ints
    line: Ints
    cells: Mapping[str, Cells]

    def __len__(self) -> int:
        return len(self.row)

    def take(self, keep: NDArray[np.bool_]) -> Chunk:
        """Return only these rows."""
        return Chunk(self.row[keep], self.line[keep], {n: taken(v, keep) for n, v in self.cells.items()})

    def texts(self, name: str) -> Sequence[str]:
        """Cells of a column as text: a whole number without a point, nothing as an empty text."""
        cells = self.cells[name]
        return [number_text(v) for v in cells.tolist()] if isinstance(cells, np.ndarray) else cells


def without_place(rows: Rows) -> str:
    """Say, for the end of a message about columns, what of the file is in none of them; empty where nothing is."""
    left_out: Sequence[str] = getattr(rows, "left_out", ())
    return f" These variables are no columns of that table: {some(left_out)}." if left_out else ""


class Rows(Protocol):
    """The table in a file."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns, none twice; an unnamed one is empty."""

    @property
    def start_utc(self) -> str | None:
        """The instant from which relative times count, where the file itself tells it."""

    def chunks(self, findings: Findings, max_rows: int, numbers: Collection[str] = ()) -> Iterator[Chunk]:
        """Yield all rows; those that are none are rejected. Past `max_rows` reading ends with a warning.

        The columns `numbers` will be read as numbers and nothing else, so a text may convert them at once.
        """


def require_column(rows: Rows, name: str, pointer: str) -> None:
    """Raise InputError where a column is absent."""
    if name not in rows.names:
        raise InputError(
            f"There is no column {name!r}; the columns are {some(rows.names)}." + without_place(rows),
            pointer=pointer,
            remedy="Name a column as the file spells it.",
            code="missing_column",
        )


def first_rows(rows: Rows, count: int) -> tuple[tuple[str, ...], ...]:
    """Return the first rows as text, to be looked at."""
    chunk = next(rows.chunks(Findings(), 10**12), None)
    if chunk is None:
        return ()
    head = chunk.take(np.arange(len(chunk)) < count)
    columns = [head.texts(n) if n else [""] * len(head) for n in rows.names]
    return tuple(islice(zip(*columns, strict=True), count))


def end_at_limit(name: str, max_rows: int, findings: Findings, rows: int | None = None) -> None:
    """Say that a file has more rows than a recording may have, and that its first ones were read.

    `rows` is how many it has, where the file itself says so; the rest of a text would have to be read to be counted.
    """
    if rows is not None:
        findings.warn(
            "rows_beyond_limit",
            f"{name} has {rows} rows; only the first {max_rows} of them were read, {rows - max_rows} were left out. "
            "Raise the setting FILTERROOM_MAX_ROWS, or upload the rest by itself.",
            rows - max_rows,
        )
        return
    findings.warn(
        "rows_beyond_limit",
        f"{name} has more than {max_rows} rows; only the first of them were read. Raise the setting "
        "FILTERROOM_MAX_ROWS, or upload the rest by itself.",
    )


def taken(cells: Cells, keep: NDArray[np.bool_]) -> Cells:
    """Return only these cells."""
    if isinstance(cells, np.ndarray):
        return cells[keep]
    if isinstance(cells, ArrowCells):
        return cells.where(keep)
    return [c for c, ok in zip(cells, keep.tolist(), strict=True) if ok]


def number_text(value: float) -> str:
    """A number as a cell of text."""
    if value != value:
        return ""
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
