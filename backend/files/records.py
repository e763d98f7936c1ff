"""Records of delimited text: cells line by line, without losing the rest of a file to one bad line.

The `csv` module takes everything up to the next quotation mark for one cell, be it the rest of the file. So a file in
which a record runs over several lines, or that holds a NUL or an overlong line, is read record by record here; all
others go through the module as a whole.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from itertools import islice
from typing import IO

from backend.files.cells import Problem
from backend.files.content import Content
from backend.files.regular_blocks import WORTHWHILE_BYTES, Layout, RegularBlock, read_blocks

# The limit of the csv module for one cell; a mark received by two thousand stations is shorter.
MAX_LINE = 131_072
# A quoted cell may hold a few line ends; more means that a quotation mark was never closed.
_MAX_LINES = 20
ONE_BYTE_LINE_ENDS = ("utf-8-sig", "cp1251")

Record = tuple[int, list[str] | Problem]
"""Physical line of the first character (from 1), and the cells or why there are none."""

_NULL_BYTE = Problem("null_byte", "the line holds a NUL byte; part of the file was probably lost while it was written")
_TOO_LONG = Problem("line_too_long", f"the line is longer than {MAX_LINE} characters")
_OPEN_QUOTE = Problem("unclosed_quote", "a quotation mark is opened and not closed; only this line was left out")


def read_batches(content: Content, layout: Layout, first_line: int, size: int) -> Iterator[list[Record] | RegularBlock]:
    """Yield records from physical line `first_line` on; blank lines are left out.

    They come `size` at a time, or, of long text without quotation marks, in blocks of which every line has a cell
    for each column.
    """
    delimiter = layout.delimiter
    careful = _needs_care(content, delimiter)
    if not careful and _may_be_regular(content):
        with content.open_bytes() as raw:
            for _ in range(first_line - 1):
                raw.readline()
            for piece in read_blocks(raw, layout, first_line):
                yield piece if isinstance(piece, RegularBlock) else list(piece.records(delimiter))
        return
    with content.open_text() as stream:
        for _ in range(first_line - 1):
            stream.readline()
        if careful:
            records = _careful_records(stream, delimiter, first_line)
            while batch := list(islice(records, size)):
                yield batch
            return
        reader = csv.reader(stream, delimiter=delimiter)
        while lines := list(islice(reader, size)):
            yield [(first_line + i, cells) for i, cells in enumerate(lines) if cells]
            first_line += len(lines)


def _needs_care(content: Content, delimiter: str) -> bool:
    """Whether some line is not a record by itself."""
    if content.has_nul:
        return True
    with content.open_text() as stream:
        if not content.has_quotes:
            return not _has_short_lines(content) and any(len(line) > MAX_LINE for line in stream)
        reader = csv.reader(stream, delimiter=delimiter)
        try:
            count = sum(1 for _ in reader)
        except csv.Error:
            return True
        return count != reader.line_num


def _has_short_lines(content: Content) -> bool:
    """Whether no line has more bytes than a line may have characters."""
    return content.encoding in ONE_BYTE_LINE_ENDS and content.longest_line <= MAX_LINE


def _may_be_regular(content: Content) -> bool:
    if content.has_quotes or content.encoding != "utf-8-sig":
        return False
    with content.open_bytes() as raw:
        return len(raw.read(WORTHWHILE_BYTES)) == WORTHWHILE_BYTES


def _careful_records(stream: IO[str], delimiter: str, first_line: int) -> Iterator[Record]:
    waiting: list[str] = []

    def look(ahead: int) -> str:
        while len(waiting) <= ahead:
            waiting.append(stream.readline())
        return waiting[ahead]

    number = first_line
    while line := look(0):
        taken = 1
        if "\0" in line:
            yield number, _NULL_BYTE
        elif len(line) > MAX_LINE:
            yield number, _TOO_LONG
        elif line.strip():
            cells, taken = join_record(look, delimiter)
            yield number, _OPEN_QUOTE if cells is None else cells
        del waiting[:taken]
        number += taken


def join_record(look: Callable[[int], str], delimiter: str) -> tuple[list[str] | None, int]:
    """Cells of the record that begins in line `look(0)`, and over how many lines it runs.

    The cells are None, of one line, where a quotation mark stays open. A quotation mark within an unquoted cell is a
    character like others.
    """
    text = ""
    for taken in range(1, _MAX_LINES + 1):
        line = look(taken - 1)
        text += line
        if not line or "\0" in line or len(text) > MAX_LINE:
            break
        try:
            return next(csv.reader([text], delimiter=delimiter, strict=True), []), taken
        except csv.Error as e:
            if "unexpected end" in str(e):
                continue
            if taken > 1:
                break
            return next(csv.reader([text], delimiter=delimiter), []), 1
    return None, 1
