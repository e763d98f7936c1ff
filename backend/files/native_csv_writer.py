"""Write a recording as native CSV: what `native_csv` reads back is the same to the last digit but one.

Numbers are written with all the digits that tell one float64 from its neighbours. A value that was read from a short
decimal in the file's unit (123456.7 ns) is written as that decimal again.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from typing import TextIO

import numpy as np

from algorithms.recording import Floats, Ints, Recording
from backend.files.formula_guard import guarded
from backend.files.native_table import NativeColumn, in_unit, native_columns_of

_ROWS_AT_ONCE = 20_000


def write_native_csv(recording: Recording, stream: TextIO, *, trial: int = 0) -> None:
    """Write one trial of a recording of any kind, with its truth where it has one.

    `row` and `start_utc` are not part of the format: rows are numbered by their place, and times count from
    the start.
    """
    write_native_columns(native_columns_of(recording, trial), stream)


def write_native_columns(native: Iterable[NativeColumn], stream: TextIO) -> None:
    """Write columns of one length as CSV."""
    columns = list(native)
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([name for name, _, _ in columns])
    rows = len(columns[0][1])
    for start in range(0, rows, _ROWS_AT_ONCE):
        cut = slice(start, start + _ROWS_AT_ONCE)
        texts = [_texts(name, values[cut], names) for name, values, names in columns]
        writer.writerows(zip(*texts, strict=True))


def _texts(name: str, values: Floats | Ints, names: tuple[str, ...] | None) -> Sequence[str]:
    if names is not None:
        table = [*map(guarded, names), ""]
        return [table[c] for c in values.tolist()]
    if values.dtype == np.int64:
        return ["" if v < 0 else str(v) for v in values.tolist()]
    return ["" if v != v else repr(v) for v in in_unit(name, values.astype(np.float64)).tolist()]
