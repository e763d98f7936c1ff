"""Parquet files: flat columns of numbers, texts, dates; read batch by batch, so a big file never stands in memory."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from algorithms.errors import InputError
from backend.files.array_rows import START_UTC
from backend.files.cells import is_instant
from backend.files.content import Content
from backend.files.matlab5 import damaged
from backend.files.native_csv import detect_native, read_native
from backend.files.options import ReadLimits
from backend.files.packing import check_expansion
from backend.files.reader import Reader, Source
from backend.files.report import Findings, some
from backend.files.rows import ROWS_AT_ONCE, Cells, Chunk, end_at_limit

MAGIC = b"PAR1"


@dataclass(frozen=True)
class ParquetRows:
    """The flat columns of a Parquet file; `nested` names the others."""

    content: Content
    pointer: str
    names: tuple[str, ...]
    nested: tuple[str, ...]
    count: int
    start_utc: str | None = None

    def chunks(self, findings: Findings, max_rows: int, numbers: Collection[str] = ()) -> Iterator[Chunk]:
        """Yield the rows in chunks, `max_rows` at most; raises InputError where the file is damaged."""
        import pyarrow.parquet as pq

        if self.count > max_rows:
            end_at_limit(self.content.name, max_rows, findings, self.count)
        if self.nested:
            findings.warn(
                "columns_nested",
                f"Columns of {self.content.name} that hold lists, structs or other values than numbers, texts and "
                f"dates were left out: {some(self.nested)}.",
                len(self.nested),
            )
        first = 1
        with self.content.open_seekable() as stream:
            batches = pq.ParquetFile(stream).iter_batches(ROWS_AT_ONCE, columns=list(self.names), use_threads=False)
            while (batch := self._next(batches)) is not None:
                row = np.arange(first, first + batch.num_rows, dtype=np.int64)
                first += batch.num_rows
                cells = {n: _cells(batch.column(i)) for i, n in enumerate(batch.schema.names)}
                chunk = Chunk(row, np.zeros(len(row), np.int64), cells)
                yield chunk if first - 1 <= max_rows else chunk.take(row <= max_rows)
                if first - 1 >= max_rows:
                    return

    def _next(self, batches: Any) -> Any:
        try:
            return next(batches, None)
        except MemoryError:
            raise
        except Exception as e:  # what a damaged file makes Arrow raise is not told anywhere
            raise damaged(self.content.name, str(e), self.pointer) from e


def open_parquet(content: Content, limits: ReadLimits, pointer: str) -> ParquetRows:
    """Open the table of a file.

    Raises InputError where the file is damaged, unpacks to too much, repeats a name, or has no flat column.
    """
    import pyarrow.parquet as pq

    with content.open_seekable() as stream:
        packed_size = stream.seek(0, 2)
        try:
            file = pq.ParquetFile(stream)
            schema, metadata = file.schema_arrow, file.metadata
            size = sum(metadata.row_group(i).total_byte_size for i in range(metadata.num_row_groups))
        except MemoryError:
            raise
        except Exception as e:  # what a damaged file makes Arrow raise is not told anywhere
            raise damaged(content.name, str(e), pointer) from e
    check_expansion(content.name, size, packed_size, limits, pointer)
    flat = tuple(f.name for f in schema if _is_flat(f.type))
    nested = tuple(f.name for f in schema if not _is_flat(f.type))
    repeated = sorted({n for n in schema.names if schema.names.count(n) > 1})
    if repeated:
        raise InputError(
            f"{content.name}: the column {some(repeated)} occurs more than once.",
            pointer=pointer,
            remedy="Give each column its own name.",
            code="duplicate_column",
        )
    if not flat:
        raise InputError(
            f"{content.name} has no column of numbers, texts or dates: {some(nested) if nested else 'it has none'}.",
            pointer=pointer,
            remedy="Save a flat table.",
            code="no_table",
        )
    start = (schema.metadata or {}).get(START_UTC.encode(), b"").decode("utf-8", "replace")
    return ParquetRows(content, pointer, flat, nested, metadata.num_rows, start if is_instant(start) else None)


def _is_flat(kind: Any) -> bool:
    import pyarrow.types as t

    if t.is_dictionary(kind):
        kind = kind.value_type
    checks = (t.is_integer, t.is_floating, t.is_boolean, t.is_decimal, t.is_string, t.is_large_string, t.is_timestamp)
    return any(check(kind) for check in (*checks, t.is_null))


def _cells(column: Any) -> Cells:
    """A column as float64 with NaN for null, or as texts; instants as ISO 8601 in UTC."""
    import pyarrow as pa
    import pyarrow.types as t

    if t.is_dictionary(column.type):
        column = column.dictionary_decode()
    if t.is_timestamp(column.type):
        # With or without a zone the stored value counts from 1970 in UTC; digits below a microsecond are cut off.
        column = column.cast(pa.timestamp("us"), safe=False).cast(pa.string())
    if t.is_string(column.type) or t.is_large_string(column.type):
        return [v or "" for v in column.to_pylist()]
    values = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
    return np.asarray(values, np.float64)


def _detect(source: Source) -> bool:
    return source.content.head.startswith(MAGIC) and detect_native(source)


READER = Reader(
    name="parquet",
    title="Parquet with flat columns",
    kinds=("toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"),
    detect=_detect,
    read=read_native,
)
