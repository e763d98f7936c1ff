"""Delimited text as a header and chunks of columns, with every unusable line listed.

The good path hands whole chunks to the `csv` module and checks them as a whole. Only a file in which a quoted cell
runs over several lines, or that holds a NUL or an overlong line, is read record by record: then one open quotation
mark costs one line and not the rest of the file.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import IO

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import InputError, UnsupportedFormatError
from algorithms.recording import Ints
from backend.files.content import Content
from backend.files.report import Findings, some

_CHUNK = 50_000
# The limit of the csv module for one cell; a mark received by two thousand stations is shorter.
_MAX_LINE = 131_072
# A quoted cell may hold a few line ends; more means that a quotation mark was never closed.
_MAX_LINES_OF_RECORD = 20
_DELIMITERS = (",", ";", "\t", "|")


@dataclass(frozen=True)
class Chunk:
    """Some consecutive rows: their numbers in the file (first data row = 1), physical lines, and cells by column."""

    row: Ints
    line: Ints
    cells: Mapping[str, Sequence[str]]

    def __len__(self) -> int:
        return len(self.row)

    def take(self, keep: NDArray[np.bool_]) -> Chunk:
        """Return only these rows."""
        flags = keep.tolist()
        cells = {n: [c for c, ok in zip(v, flags, strict=True) if ok] for n, v in self.cells.items()}
        return Chunk(self.row[keep], self.line[keep], cells)


@dataclass(frozen=True)
class Header:
    """The first line: names of the columns, the delimiter, and the physical line on which the data begin."""

    names: tuple[str, ...]
    delimiter: str
    first_data_line: int

    def require(self, name: str, pointer: str) -> None:
        """Raise InputError where a column is absent."""
        if name not in self.names:
            raise InputError(
                f"There is no column {name!r}; the columns are {some(self.names)}.",
                pointer=pointer,
                remedy="Name a column as the first line spells it.",
                code="missing_column",
            )


_Record = tuple[int, list[str]]
"""Physical line of the first character (from 1) and the cells."""


def read_header(content: Content, *, pointer: str = "/file") -> Header:
    """Read the line of names and find the delimiter.

    Raises
    ------
    InputError
        Names are repeated, or the first line holds numbers.
    UnsupportedFormatError
        The first line is no list of names.
    """
    with content.open_text() as stream:
        line = stream.readline(_MAX_LINE)
        number = 1
        while line and not line.strip():
            line = stream.readline(_MAX_LINE)
            number += 1
        told = None
        if line.lower().startswith("sep=") and len(line.rstrip("\r\n")) == 5:
            told, line, number = line[4], stream.readline(_MAX_LINE), number + 1
        # A station's name may hold a line end: the header goes on while a quotation mark is open.
        while line.count('"') % 2 and number < _MAX_LINES_OF_RECORD and (more := stream.readline(_MAX_LINE)):
            line, number = line + more, number + 1
    delimiter = told or max(_DELIMITERS, key=lambda d: len(_cells(line, d)))
    names = [n.strip() for n in _cells(line, delimiter)]
    if len(names) > 1 and not names[-1]:
        names.pop()
    if len(names) < 2:
        raise UnsupportedFormatError(
            f"{content.name}: the first line is no list of column names (it begins with {line.strip()[:60]!r}).",
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
    return Header(tuple(names), delimiter, number + 1)


def read_chunks(content: Content, header: Header, findings: Findings, max_rows: int) -> Iterator[Chunk]:
    """Yield the rows in chunks; rows that are no rows are rejected, blank lines are not counted.

    Raises InputError (`too_many_rows`) past `max_rows`.
    """
    row = 0
    width = len(header.names)
    with content.open_text() as stream:
        for _ in range(header.first_data_line - 1):
            stream.readline()
        for records in _batches(stream, header, content):
            kept: list[list[str]] = []
            rows: list[int] = []
            lines: list[int] = []
            for line, cells in records:
                row += 1
                if len(cells) != width:
                    problem = _misfit(cells, width)
                    if problem is not None:
                        findings.reject(row, problem[0], f"line {line}: {problem[1]}")
                        continue
                    cells = cells[:width]
                kept.append(cells)
                rows.append(row)
                lines.append(line)
            if row > max_rows:
                raise InputError(
                    f"{content.name} has more than {max_rows:,} rows.".replace(",", " "),
                    pointer="/file",
                    remedy="Upload it in parts.",
                    code="too_many_rows",
                )
            if kept:
                columns = zip(*kept, strict=True)
                cells_by_name = {n: c for n, c in zip(header.names, columns, strict=True) if n}
                yield Chunk(np.array(rows, np.int64), np.array(lines, np.int64), cells_by_name)


def _batches(stream: IO[str], header: Header, content: Content) -> Iterator[list[_Record]]:
    if _needs_care(content, header):
        careful = _careful_records(stream, header)
        while batch := list(islice(careful, _CHUNK)):
            yield batch
        return
    reader = csv.reader(stream, delimiter=header.delimiter)
    first = header.first_data_line
    while raw := list(islice(reader, _CHUNK)):
        yield [(first + i, cells) for i, cells in enumerate(raw) if cells]
        first += len(raw)


def _needs_care(content: Content, header: Header) -> bool:
    """Whether some line is not a record by itself."""
    if content.has_nul:
        return True
    with content.open_text() as stream:
        for number, line in enumerate(stream, 1):
            if len(line) > _MAX_LINE:
                return True
            if content.has_quotes and number >= header.first_data_line and line.count('"') % 2:
                return True
    return False


def _careful_records(stream: IO[str], header: Header) -> Iterator[_Record]:
    """Records of a difficult file. An unusable one has a single cell that begins with a NUL and names the problem."""
    number = header.first_data_line - 1
    waiting: list[str] = []
    while True:
        line = waiting.pop(0) if waiting else stream.readline()
        if not line:
            return
        number += 1
        if not line.strip():
            continue
        if "\0" in line:
            yield number, ["\0null_byte"]
            continue
        if len(line) > _MAX_LINE:
            yield number, ["\0line_too_long"]
            continue
        record, taken = line, 0
        cells = _whole_record(record, header.delimiter)
        while cells is None and taken < _MAX_LINES_OF_RECORD and len(record) <= _MAX_LINE:
            if taken == len(waiting):
                waiting.append(stream.readline())
            if not waiting[taken] or "\0" in waiting[taken]:
                break
            record += waiting[taken]
            taken += 1
            cells = _whole_record(record, header.delimiter)
        if cells is None:
            yield number, ["\0unclosed_quote"]
        else:
            yield number, cells
            number += taken
            del waiting[:taken]


def _whole_record(text: str, delimiter: str) -> list[str] | None:
    """Cells of a record, or None while a quoted cell is still open."""
    if '"' not in text:
        return text.rstrip("\r\n").split(delimiter)
    try:
        return next(csv.reader([text], delimiter=delimiter, strict=True))
    except csv.Error as e:
        if "unexpected end" in str(e):
            return None
        # A quotation mark within a cell: the forgiving reading takes it as a character, and the number conversion
        # tells the user which cell it is.
        return next(csv.reader([text], delimiter=delimiter))


_REASONS = {
    "null_byte": "the line holds a NUL byte; part of the file was probably lost while it was written",
    "line_too_long": f"the line is longer than {_MAX_LINE} characters",
    "unclosed_quote": "a quotation mark is opened and not closed; only this line was left out",
}


def _misfit(cells: list[str], width: int) -> tuple[str, str] | None:
    """Why a record of the wrong length cannot serve; None where only empty cells are too many."""
    if len(cells) == 1 and cells[0].startswith("\0"):
        code = cells[0][1:]
        return code, _REASONS[code]
    if len(cells) > width and not any(c.strip() for c in cells[width:]):
        return None
    return "wrong_cell_count", f"{len(cells)} cells where the first line has {width} names"


def _cells(line: str, delimiter: str) -> list[str]:
    return next(csv.reader([line], delimiter=delimiter), [])


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True
