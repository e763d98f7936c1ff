"""Write a table as Parquet: numbers with null for nothing, texts as a dictionary, Zstandard."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from algorithms.result import Column, Table
from algorithms.texts import Texts

_ROWS_PER_GROUP = 100_000


def write_parquet(table: Table, path: Path, *, about: Mapping[str, str] | None = None) -> None:
    """Write a table; `about` goes into the metadata of the file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = {name: _array(column) for name, column in table.columns.items()}
    schema = pa.schema([(n, a.type) for n, a in arrays.items()], metadata=dict(about or {}))
    # A table without columns has no rows either.
    written = pa.Table.from_arrays(list(arrays.values()), schema=schema)
    pq.write_table(written, path, compression="zstd", row_group_size=_ROWS_PER_GROUP)


def _array(column: Column) -> Any:
    import pyarrow as pa

    if isinstance(column, Texts):
        return pa.array(list(column), pa.string()).dictionary_encode()
    if column.dtype.kind == "f":
        # Infinities are no measurements either; JSON and CSV have null there too.
        return pa.array(column, mask=~np.isfinite(column))
    return pa.array(column)
