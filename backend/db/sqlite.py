"""Connections to SQLite: one for writing, many for reading.

In WAL mode readers go on while one transaction writes. A transaction that reads first and writes later fails at once
with "database is locked" when another one wrote in between, whatever the busy timeout; therefore every write
transaction starts with BEGIN IMMEDIATE.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic_core import from_json
from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.pool import NullPool

from backend.errors import StorageError

# How long a transaction waits for another program that holds the lock, milliseconds.
BUSY_MS = 10_000


def sqlite_engines(url: URL, wait_s: float) -> tuple[Engine, Engine]:
    """Return the engines for writing and for reading; a writer waits `wait_s` for its turn in this process."""
    if not url.database or url.database == ":memory:":
        raise StorageError(
            "A database in memory cannot be shared by the server's threads.",
            remedy="Give a file: sqlite:////path/to/filterroom.sqlite",
            code="database_url",
        )
    Path(url.database).parent.mkdir(parents=True, exist_ok=True)
    writer = create_engine(url, pool_size=1, max_overflow=0, pool_timeout=wait_s, json_deserializer=from_json)
    # Most of the time of a list goes into its JSON columns; this reads them in half of what json.loads takes.
    reader = create_engine(url, pool_size=8, max_overflow=40, json_deserializer=from_json)
    _set_up(writer, begin="BEGIN IMMEDIATE", read_only=False)
    _set_up(reader, begin="BEGIN", read_only=True)
    return writer, reader


def migration_engine(url: URL) -> Engine:
    """Return an engine without foreign key actions.

    SQLite changes a table by copying and dropping it, and with foreign keys on the drop would delete the rows that
    refer to it.
    """
    engine = create_engine(url, poolclass=NullPool)
    _set_up(engine, begin="BEGIN IMMEDIATE", read_only=False, foreign_keys=False)
    return engine


def _set_up(engine: Engine, *, begin: str, read_only: bool, foreign_keys: bool = True) -> None:
    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: object) -> None:
        # The driver must not start transactions of its own (before Python 3.12 it has no other switch).
        connection.isolation_level = None
        cursor = connection.cursor()
        cursor.execute(f"PRAGMA busy_timeout={BUSY_MS}")
        cursor.execute("PRAGMA journal_mode=WAL")
        cursor.execute("PRAGMA synchronous=NORMAL")
        cursor.execute(f"PRAGMA foreign_keys={'ON' if foreign_keys else 'OFF'}")
        if read_only:
            cursor.execute("PRAGMA query_only=ON")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        connection.exec_driver_sql(begin)
