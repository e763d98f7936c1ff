"""From the outcomes of a run's blocks to its result file, its small tables and its headline, and back.

Big tables stand in the result file (`result_file`), small ones in the database, all labels together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Column, LazyArrays, Table
from algorithms.texts import Texts
from backend.db import outcomes, runs
from backend.db.engine import Database
from backend.errors import NotFoundError, StateError
from backend.files.store import Store
from backend.jobs.outcome import Outcome, finite
from backend.jobs.result_file import BIG_TABLES, arrays_of, is_big, table_arrays


@dataclass(frozen=True)
class Composed:
    """A finished run, ready to be stored."""

    arrays: Mapping[str, NDArray[Any]]
    tables: list[outcomes.StoredTable]
    summary: dict[str, Any]
    entries: list[dict[str, Any]]
    software: dict[str, Any]


def compose(labels: Sequence[str], blocks: Sequence[Outcome]) -> Composed:
    """Put the blocks of a run together, in the order of its algorithms.

    Where the worker of the only one has written the result file, there are no arrays.
    """
    arrays = LazyArrays()
    by_name: dict[str, dict[str, Table]] = {}
    for label, block in zip(labels, blocks, strict=True):
        arrays.add_all(arrays_of(label, block.arrays))
        for name, table in block.tables.items():
            by_name.setdefault(name, {})[label] = table
    small = [_metrics_table(labels, blocks)]
    for name, tables in by_name.items():
        if is_big(name, sum(len(t) for t in tables.values())):
            for label, table in tables.items():
                arrays.add_all(table_arrays(label, name, table))
        else:
            small.append(_stored(name, joined(tables)))
    entries = [
        {
            "label": label,
            "settings": block.settings,
            "notes": list(block.notes),
            "seconds": block.seconds,
            "tables": {n: len(t) for n, t in block.tables.items()} if block.written is None else block.written.rows,
        }
        for label, block in zip(labels, blocks, strict=True)
    ]
    software = dict(blocks[0].software) if blocks else {}
    # Workers of a mixed cluster differ; then results may too, beyond the ninth digit.
    processors = sorted({b.software["cpu"] for b in blocks if "cpu" in b.software})
    if len(processors) > 1:
        software["cpu"] = ", ".join(processors)
    return Composed(arrays, small, _summary(labels, blocks), finite(entries), software)


def table_names(database: Database, run: runs.Run) -> dict[str, int]:
    """Return the tables of a run with their numbers of rows, by name."""
    with database.read() as connection:
        sizes = outcomes.table_sizes(connection, run.id)
    for entry in run.entries or ():
        for name, rows in entry["tables"].items():
            if name in BIG_TABLES or name not in sizes:
                sizes[name] = sizes.get(name, 0) + rows
    return dict(sorted(sizes.items()))


def load_table(database: Database, store: Store, run: runs.Run, name: str) -> Table:
    """Return a table of a run with all labels together, `label` being its first column (in metrics the second)."""
    with database.read() as connection:
        stored = outcomes.find_table(connection, run.id, name)
    if stored is not None:
        return table_of_stored(stored)
    return joined(_big_tables(store, run, name))


def load_entry_table(database: Database, store: Store, run: runs.Run, label: str, name: str) -> Table:
    """Return a table of one algorithm of a run, without the column `label`."""
    with database.read() as connection:
        stored = outcomes.find_table(connection, run.id, name)
    if stored is None:
        tables = _big_tables(store, run, name)
        return tables[label] if label in tables else next(iter(tables.values())).take(slice(0, 0))
    at = [c for c, _ in stored.columns].index("label")
    rows = [row for row in stored.rows if row[at] == label]
    return table_of_stored(outcomes.StoredTable(name, stored.columns, rows)).without("label")


def load_arrays(store: Store, run: runs.Run) -> Mapping[str, NDArray[Any]]:
    """Return the arrays of the result file; each is read when it is asked for."""
    if run.result_sha256 is None:
        raise StateError(
            f"The run is {run.state}: it has no result.",
            remedy="Wait until it has succeeded." if not run.is_final else "Run it again.",
            code="no_result",
        )
    return store.get_arrays(run.result_sha256)


def load_entry_arrays(store: Store, run: runs.Run, label: str) -> Mapping[str, NDArray[Any]]:
    """Return the result arrays of one algorithm of a run, by the names of its outputs; each is read when asked for."""
    arrays = load_arrays(store, run)
    prefix = f"{label}/"
    own = LazyArrays()
    for key in arrays:
        if key.startswith(prefix):
            own.add(key.removeprefix(prefix), arrays, key)
    return own


def _big_tables(store: Store, run: runs.Run, name: str) -> dict[str, Table]:
    arrays = load_arrays(store, run)
    found = {
        entry.label: Table.from_arrays(arrays, f"tables/{name}/{entry.label}")
        for entry in run.algorithms
        if f"tables/{name}/{entry.label}/columns" in arrays
    }
    if not found:
        raise NotFoundError(f"The run has no table {name!r}.", code="table_not_found")
    return found


def _metrics_table(labels: Sequence[str], blocks: Sequence[Outcome]) -> outcomes.StoredTable:
    columns = [
        ("metric", "text"),
        ("label", "text"),
        ("segment", "text"),
        ("target", "text"),
        ("value", "number"),
        ("ci95_low", "number"),
        ("ci95_high", "number"),
        ("unit", "text"),
        ("n", "integer"),
    ]
    rows = [
        [label if name == "label" else finite(getattr(metric, name)) for name, _ in columns]
        for label, block in zip(labels, blocks, strict=True)
        for metric in block.metrics
    ]
    return outcomes.StoredTable("metrics", columns, rows)


def _summary(labels: Sequence[str], blocks: Sequence[Outcome]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for label, block in zip(labels, blocks, strict=True):
        for m in block.metrics:
            if not m.segment and not m.target:
                known = m.ci95_low is not None and m.ci95_high is not None
                out.setdefault(m.metric, {})[label] = {
                    "value": finite(m.value),
                    "ci95": [finite(m.ci95_low), finite(m.ci95_high)] if known else None,
                    "unit": m.unit,
                }
    return out


def joined(tables: Mapping[str, Table]) -> Table:
    """Put the tables of several labels under each other; a column that one of them lacks is null there."""
    names = list(dict.fromkeys(name for table in tables.values() for name in table.names))
    columns: dict[str, Column] = {"label": Texts.joined(Texts.repeated(label, len(t)) for label, t in tables.items())}
    for name in names:
        parts = [(table.columns.get(name), len(table)) for table in tables.values()]
        if any(isinstance(part, Texts) for part, _ in parts):
            columns[name] = Texts.joined(Texts.repeated(None, n) if p is None else _as_texts(p) for p, n in parts)
        else:
            columns[name] = np.concatenate([np.full(n, np.nan) if p is None else np.asarray(p) for p, n in parts])
    return Table(columns)


def _stored(name: str, table: Table) -> outcomes.StoredTable:
    kinds = {"f": "number", "i": "integer", "u": "integer", "b": "boolean"}
    columns = [
        (column, "text" if isinstance(values, Texts) else kinds[values.dtype.kind])
        for column, values in table.columns.items()
    ]
    return outcomes.StoredTable(name, columns, [finite(list(row)) for row in table.rows()])


def table_of_stored(stored: outcomes.StoredTable) -> Table:
    """Return a table of the database as columns."""
    dtypes: dict[str, type] = {"number": np.float64, "integer": np.int64, "boolean": np.bool_}
    columns: dict[str, Column] = {}
    for at, (name, kind) in enumerate(stored.columns):
        values = [row[at] for row in stored.rows]
        columns[name] = Texts.of(values) if kind == "text" else np.array(values, dtypes[kind])
    return Table(columns)


def _as_texts(column: Column) -> Texts:
    """Texts as they are; numbers, where another label has texts under the same name, in words."""
    return column if isinstance(column, Texts) else Texts.of([f"{value:g}" for value in column.tolist()])
