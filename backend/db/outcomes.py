"""What runs leave behind: finished blocks of a live run, and the small tables of a finished one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, delete, func, insert, select

from backend.db.tables import run_blocks, run_tables


@dataclass(frozen=True)
class StoredTable:
    """A small table: columns as (name, "number" | "integer" | "text"), rows as plain values."""

    name: str
    columns: Sequence[tuple[str, str]]
    rows: Sequence[Sequence[Any]]


def store_block(connection: Connection, run_id: str, position: int, sha256: str) -> None:
    """Note that the block at `position` of a run is finished and where its outcome lies."""
    connection.execute(delete(run_blocks).where(run_blocks.c.run_id == run_id, run_blocks.c.position == position))
    connection.execute(insert(run_blocks).values(run_id=run_id, position=position, sha256=sha256))


def finished_blocks(connection: Connection, run_id: str) -> dict[int, str]:
    """Return the finished blocks of a run: {position: sha256 of the outcome}."""
    query = select(run_blocks.c.position, run_blocks.c.sha256).where(run_blocks.c.run_id == run_id)
    return {row.position: row.sha256 for row in connection.execute(query)}


def forget_blocks(connection: Connection, run_id: str) -> None:
    """Delete the blocks of a run that is finished."""
    connection.execute(delete(run_blocks).where(run_blocks.c.run_id == run_id))


def store_tables(connection: Connection, run_id: str, tables: Sequence[StoredTable]) -> None:
    """Store the small tables of a run."""
    if tables:
        connection.execute(
            insert(run_tables),
            [
                {
                    "run_id": run_id,
                    "name": t.name,
                    "columns": [list(c) for c in t.columns],
                    "rows": [list(r) for r in t.rows],
                }
                for t in tables
            ],
        )


def find_table(connection: Connection, run_id: str, name: str) -> StoredTable | None:
    """Return a small table of a run, None where it has none of this name."""
    query = select(run_tables.c.columns, run_tables.c.rows)
    row = connection.execute(query.where(run_tables.c.run_id == run_id, run_tables.c.name == name)).one_or_none()
    return None if row is None else StoredTable(name, [tuple(c) for c in row.columns], row.rows)


def table_sizes(connection: Connection, run_id: str) -> dict[str, int]:
    """Return the small tables of a run with their number of rows, by name."""
    query = select(run_tables.c.name, func.json_array_length(run_tables.c.rows))
    rows = connection.execute(query.where(run_tables.c.run_id == run_id).order_by(run_tables.c.name))
    return {name: int(length) for name, length in rows}
