"""Delimited text as a line of names and chunks of columns, with every unusable line listed."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.cells import Problem
from backend.files.content import Content
from backend.files.records import MAX_LINE, join_record, read_batches
from backend.files.regular_blocks import Layout, RegularBlock
from backend.files.report import Findings, some
from backend.files.rows import ROWS_AT_ONCE, Chunk, end_at_limit

# The names begin within these lines; as many are looked at behind, for a record runs over twenty at most.
_SEARCHED_LINES = 40
_DELIMITERS = (",", ";", "\t", "|")


@dataclass(frozen=True)
class DelimitedText:
    """A table as text: names of the columns, the delimiter, and the physical line on which the data begin."""

    content: Content
    names: tuple[str, ...]
    delimiter: str
    first_data_line: int
    start_utc: str | None = None

    def chunks(self, findings: Findings, max_rows: int, numbers: Collection[str] = ()) -> Iterator[Chunk]:
        """Yield the rows in chunks; rows that are no rows are rejected, blank lines are not counted.

        Past `max_rows` reading ends with a warning.
        """
        row = 0
        width = len(self.names)
        table = Layout(self.delimiter, width, frozenset(i for i, n in enumerate(self.names) if n in numbers))
        for records in read_batches(self.content, table, self.first_data_line, ROWS_AT_ONCE):
            if isinstance(records, RegularBlock):
                first, row = row, row + len(records)
                counted = np.arange(first, row)
                cells_of = {n: c for n, c in zip(self.names, records.columns, strict=True) if n}
                chunk = Chunk(counted + 1, counted - first + records.line, cells_of)
                if first < max_rows:
                    yield chunk if row <= max_rows else chunk.take(counted < max_rows)
                if row > max_rows:
                    end_at_limit(self.content.name, max_rows, findings)
                    return
                continue
            kept: list[list[str]] = []
            rows: list[int] = []
            lines: list[int] = []
            for line, record in records:
                row += 1
                if row > max_rows:
                    break
                cells = _fitting(record, width) if isinstance(record, list) and len(record) != width else record
                if isinstance(cells, Problem):
                    findings.reject(row, cells.code, f"line {line}: {cells.detail}")
                    continue
                kept.append(cells)
                rows.append(row)
                lines.append(line)
            if kept:
                columns = zip(*kept, strict=True)
                cells_by_name = {n: c for n, c in zip(self.names, columns, strict=True) if n}
                yield Chunk(np.array(rows, np.int64), np.array(lines, np.int64), cells_by_name)
            if row > max_rows:
                end_at_limit(self.content.name, max_rows, findings)
                return


def read_delimited_text(content: Content, *, pointer: str = "/file") -> DelimitedText:
    """Read the line of names and find the delimiter.

    Raises
    ------
    InputError
        Names are repeated, or the first line holds numbers.
    UnsupportedFormatError
        The first line is no list of names.
    """
    with content.open_text() as stream:
        lines = [stream.readline(MAX_LINE) for _ in range(2 * _SEARCHED_LINES)]
    number = next((i for i, line in enumerate(lines[:_SEARCHED_LINES]) if line.strip()), 0)
    told = None
    if lines[number].lower().startswith("sep=") and len(lines[number].rstrip("\r\n")) == 5:
        told, number = lines[number][4], number + 1
    first = lines[number]
    if len(first) >= MAX_LINE:
        raise UnsupportedFormatError(
            f"{content.name}: the first line is longer than {MAX_LINE} characters.",
            pointer=pointer,
            remedy="Put the column names in the first line and each row in a line of its own.",
            code="no_columns",
        )
    # A station's name may hold a line end, so the header is a record like others.
    candidates = {d: join_record(lambda i: lines[number + i], d) for d in ((told,) if told else _DELIMITERS)}
    # Names and numbers may hold commas (`Time, ms;Range, m` over `1,5;20,0`): what splits the row below into as many
    # cells goes before what splits the names into the most.
    delimiter = max(
        candidates, key=lambda d: (_fits_below(candidates[d], lines[number:], d), len(candidates[d][0] or ()))
    )
    cells, height = candidates[delimiter]
    names = [n.strip() for n in cells or ()]
    if len(names) > 1 and not names[-1]:
        names.pop()
    if first.lstrip().startswith("{"):
        raise UnsupportedFormatError(
            f"{content.name} is JSON, not a table of measurements.",
            pointer=pointer,
            remedy="Give a site as the site of the recording, and the measurements as CSV.",
            code="no_columns",
        )
    if len(names) < 2:
        raise UnsupportedFormatError(
            f"{content.name}: the first line is no list of column names (it begins with {first.strip()[:60]!r}).",
            pointer=pointer,
            remedy="Separate the columns by comma, semicolon or tab, names in the first line.",
            code="no_columns",
        )
    if all(_is_number(n) for n in names):
        raise InputError(
            f"{content.name}: the first line holds numbers, not column names.",
            pointer=pointer,
            remedy="Put a line of names in front; docs/formats.md shows them.",
            code="no_header",
        )
    repeated = sorted({n for n in names if n and names.count(n) > 1})
    if repeated:
        raise InputError(
            f"{content.name}: the column {some(repeated)} occurs more than once.",
            pointer=pointer,
            remedy="Give each column its own name.",
            code="duplicate_column",
        )
    return DelimitedText(content, tuple(names), delimiter, number + height + 1)


def _fits_below(header: tuple[list[str] | None, int], lines: list[str], delimiter: str) -> bool:
    """Whether the record after the names has several cells, one for each name."""
    names, height = header
    if names is None or len(names) < 2 or height >= len(lines):
        return False
    below, _ = join_record(lambda i: lines[height + i] if height + i < len(lines) else "", delimiter)
    return below is not None and len(below) == len(names)


def _fitting(cells: list[str], width: int) -> list[str] | Problem:
    """Cells in the number of the names; too many are fine where the rest is empty."""
    if len(cells) > width and not any(c.strip() for c in cells[width:]):
        return cells[:width]
    return Problem("wrong_cell_count", f"{len(cells)} cells where the first line has {width} names")


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True
