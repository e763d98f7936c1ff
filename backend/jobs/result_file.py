"""The result file of a run: what it is made of, and how a worker on the server's machine writes it.

It is an .npz: `<label>/<array>` for the arrays of each algorithm, `tables/<table>/<label>/...` for its big tables
(`Table.to_arrays`), `recording/...` where several recordings were joined. It holds no time and no duration: the same
inputs give the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import LazyArrays, Table
from backend.files.array_file import HashedArrays
from backend.files.store import refusal_of

# Tables with a row per mark always stand in the result file, whatever their size: scripts rely on it.
BIG_TABLES = ("states", "errors", "curves")
# Any other table with more rows than this goes there too.
BIG_ROWS = 20_000


def is_big(name: str, rows: int) -> bool:
    """Whether a table stands in the result file; small ones stand in the database."""
    return name in BIG_TABLES or rows > BIG_ROWS


def arrays_of(label: str, arrays: Mapping[str, NDArray[Any]]) -> Mapping[str, NDArray[Any]]:
    """Return an algorithm's arrays under their names in the file."""
    named = LazyArrays()
    named.add_all(arrays, f"{label}/")
    return named


def table_arrays(label: str, name: str, table: Table) -> Mapping[str, NDArray[Any]]:
    """Return a big table as arrays under their names in the file."""
    return table.to_arrays(f"tables/{name}/{label}")


def recording_arrays(arrays: Mapping[str, NDArray[Any]]) -> Mapping[str, NDArray[Any]]:
    """Return joined recordings under their names in the file: charts need them, and they stand nowhere else."""
    named = LazyArrays()
    named.add_all(arrays, "recording/")
    return named


class ResultWriter:
    """Writes the result file of the one algorithm of a run, while the algorithm's tables are still made."""

    def __init__(self, path: Path, label: str) -> None:
        self._out = HashedArrays(path)
        self._label = label

    def add_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Let the algorithm's arrays be written; they must not change any more."""
        self._out.add(arrays_of(self._label, {name: np.asarray(array) for name, array in arrays.items()}))

    def add_tables(self, tables: Mapping[str, Table]) -> dict[str, Table]:
        """Let the big tables be written, and return the others."""
        big = {name: table for name, table in tables.items() if is_big(name, len(table))}
        for name, table in big.items():
            self._out.add(table_arrays(self._label, name, table))
        return {name: table for name, table in tables.items() if name not in big}

    def add_recording(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Let joined recordings be written."""
        self._out.add(recording_arrays(arrays))

    def finish(self) -> str:
        """Have the file on the disk and return its SHA-256."""
        return self._out.finish()

    def close(self) -> None:
        """Close the file, finished or not."""
        self._out.close()


@contextmanager
def writing(path: Path, label: str) -> Iterator[ResultWriter]:
    """Give a writer; where the block fails nothing stays at the path, and what the disk refuses is a StorageError."""
    out: ResultWriter | None = None
    try:
        out = ResultWriter(path, label)
        yield out
    except BaseException as error:
        if out is not None:
            out.close()
            with suppress(OSError):
                path.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise refusal_of(error) from error
        raise
    out.close()
