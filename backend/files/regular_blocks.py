"""Regular text in big blocks: split and converted by Arrow, several times faster than line by line.

A block is regular where each of its lines is a record with a cell for every name. Arrow's numbers are those of Python's
`float`, digit for digit; what it does not take, and every other block, goes the way of `records`, which names line and
cell. So what is read, and what is rejected, does not depend on the way.
"""

from __future__ import annotations

import csv
import io
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import IO, Any, overload

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints

# Shorter files are read line by line: Arrow takes longer to be loaded.
WORTHWHILE_BYTES = 1 << 20
BLOCK_BYTES = 8 << 20
# Blocks that are split and converted beside each other, in threads: Arrow does not hold the interpreter meanwhile.
_AT_ONCE = 2
_LINES_LOOKED_AT_ONCE = 4096


@dataclass(frozen=True)
class ArrowCells(Sequence[str]):
    """Cells of a column as Arrow keeps them; a sequence of str."""

    array: Any

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.array)

    @overload
    def __getitem__(self, at: int) -> str: ...

    @overload
    def __getitem__(self, at: slice) -> ArrowCells: ...

    def __getitem__(self, at: int | slice) -> str | ArrowCells:
        """Return a cell, or some."""
        if isinstance(at, slice):
            return ArrowCells(self.array[at])
        return str(self.array[at].as_py())

    def __iter__(self) -> Iterator[str]:
        """Yield the cells."""
        for first in range(0, len(self.array), _LINES_LOOKED_AT_ONCE):
            yield from self.array.slice(first, _LINES_LOOKED_AT_ONCE).to_pylist()

    def where(self, keep: NDArray[np.bool_]) -> ArrowCells:
        """Return only these cells."""
        return self if keep.all() else ArrowCells(self.array.filter(keep))

    def text(self) -> bytes:
        """All cells without anything between them."""
        offsets = np.frombuffer(self.array.buffers()[1], np.int32)
        first, last = offsets[self.array.offset], offsets[self.array.offset + len(self.array)]
        values = self.array.buffers()[2]
        return b"" if values is None else values.slice(int(first), int(last - first)).to_pybytes()

    def numbers(self) -> Floats | None:
        """Cells as numbers, NaN for empty ones; None where some cell is no plain decimal number."""
        import pyarrow as pa
        import pyarrow.compute as pc

        try:
            values = pc.if_else(pc.equal(self.array, ""), None, self.array).cast(pa.float64())
        except pa.ArrowInvalid:
            return None
        return _floats(values)

    def coded(self) -> tuple[Ints, list[str]]:
        """Codes of the cells into the distinct ones, these in the order in which they are met."""
        found = self.array.dictionary_encode()
        codes = np.frombuffer(found.indices.buffers()[1], np.int32, len(found.indices), found.indices.offset * 4)
        return codes.astype(np.int64), found.dictionary.to_pylist()


@dataclass(frozen=True)
class Layout:
    """How lines are parted: the delimiter, cells in a line, and the columns that are read as numbers alone."""

    delimiter: str
    width: int
    numbers: frozenset[int] = frozenset()


@dataclass(frozen=True)
class RegularBlock:
    """Consecutive lines of cells: the number of the first line, and the columns, as numbers or as texts."""

    line: int
    columns: list[ArrowCells | Floats]

    def __len__(self) -> int:
        """Return the number of lines."""
        return len(self.columns[0])


@dataclass(frozen=True)
class OtherBlock:
    """Consecutive lines that have to be looked at one by one."""

    line: int
    text: str

    def records(self, delimiter: str) -> list[tuple[int, list[str]]]:
        """Line numbers and cells; blank lines are left out."""
        reader = csv.reader(io.StringIO(self.text, newline=""), delimiter=delimiter)
        return [(self.line + i, cells) for i, cells in enumerate(reader) if cells]


def read_blocks(stream: IO[bytes], layout: Layout, line: int) -> Iterator[RegularBlock | OtherBlock]:
    """Cut UTF-8 text without quotation marks into blocks; `line` is the number of the stream's first line.

    The blocks come in order; the next ones are converted while the caller works on one.
    """
    ahead: deque[Future[RegularBlock | OtherBlock]] = deque()
    with ThreadPoolExecutor(_AT_ONCE, thread_name_prefix="blocks") as threads:
        for text, lines in _whole_lines(stream):
            ahead.append(threads.submit(_block, text, layout, line, lines))
            line += lines
            if len(ahead) > _AT_ONCE:
                yield ahead.popleft().result()
        while ahead:
            yield ahead.popleft().result()


def _whole_lines(stream: IO[bytes]) -> Iterator[tuple[bytes, int]]:
    """Cut a stream into pieces of whole lines, each with their number."""
    rest: list[bytes] = []
    while block := stream.read(BLOCK_BYTES):
        end = block.rfind(b"\n") + 1
        if end:
            text = b"".join((*rest, memoryview(block)[:end]))
            yield text, text.count(b"\n")
            rest = []
        rest.append(block[end:])
    if last := b"".join(rest):
        yield last, last.count(b"\n") + 1


def _block(text: bytes, layout: Layout, line: int, lines: int) -> RegularBlock | OtherBlock:
    if b"\r" not in text or text.count(b"\r") == text.count(b"\r\n"):
        columns = _numbers_and_texts(text, layout, lines)
        if columns is None:
            columns = _columns(text, layout, frozenset(), lines)
        if columns is not None:
            return RegularBlock(line, columns)
    return OtherBlock(line, text.decode("utf-8"))


def _numbers_and_texts(text: bytes, layout: Layout, lines: int) -> list[ArrowCells | Floats] | None:
    """Columns of which some are converted as they are parted; None where that might hide how they are written.

    The way by texts tells of infinities, words for nothing and decimal commas, and whether there are decimal points.
    """
    if not layout.numbers or (layout.delimiter != "," and b"," in text):
        return None
    columns = _columns(text, layout, layout.numbers, lines)
    if columns is None:
        return None
    found = [column for column in columns if isinstance(column, np.ndarray)]
    broken = any((column != np.floor(column))[np.isfinite(column)].any() for column in found)
    return columns if broken == (b"." in text) else None


def _columns(text: bytes, layout: Layout, numbers: frozenset[int], lines: int) -> list[ArrowCells | Floats] | None:
    """Cells of each column; None where a line is no record, or a cell of the `numbers` is not a plain one."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    names = [str(i) for i in range(layout.width)]
    types = {name: pa.float64() if i in numbers else pa.string() for i, name in enumerate(names)}
    try:
        table = arrow_csv.read_csv(
            pa.BufferReader(text),
            read_options=arrow_csv.ReadOptions(column_names=names, use_threads=False, block_size=len(text) + 1),
            parse_options=arrow_csv.ParseOptions(delimiter=layout.delimiter, quote_char=False),
            convert_options=arrow_csv.ConvertOptions(column_types=types, null_values=[""], strings_can_be_null=False),
        )
    except pa.ArrowInvalid:
        return None
    if table.num_rows != lines:
        return None
    out: list[ArrowCells | Floats] = []
    for i, column in enumerate(table.columns):
        cells = column.combine_chunks()
        if i not in numbers:
            out.append(ArrowCells(cells))
            continue
        values = _floats(cells)
        if int(np.isfinite(values).sum()) != len(cells) - cells.null_count:
            return None
        out.append(values)
    return out


def _floats(cells: Any) -> Floats:
    """Numbers of an Arrow column, NaN for null."""
    import pyarrow.compute as pc

    # Arrow's own way to NumPy loads pandas, where there is one, which takes a third of a second.
    filled = pc.fill_null(cells, float("nan")) if cells.null_count else cells
    return np.frombuffer(filled.buffers()[1], np.float64, len(filled), filled.offset * 8).copy()
