"""The database: one writer at a time, readers that never wait for it.

SQLite in WAL mode lets readers go on while one transaction writes. A transaction that reads first and
writes later fails at once with "database is locked" when another one wrote in between, whatever the busy
timeout; therefore every write transaction starts with BEGIN IMMEDIATE, and inside this process writers
queue for one connection.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import DBAPIError, OperationalError
from sqlalchemy.pool import NullPool

from backend.errors import StorageError

# How long a writer waits for another one, seconds. Write transactions take milliseconds.
WRITE_WAIT_S = 30


class Database:
    """Connections to the database of a server.

    `read()` and `write()` give a `Connection` inside a transaction; `write()` commits at the end of the
    block, or rolls back when it raises. Never compute inside a write transaction.
    """

    def __init__(self, url: str) -> None:
        self._url = make_url(url)
        self.is_sqlite = self._url.get_backend_name() == "sqlite"
        if self.is_sqlite:
            if not self._url.database or self._url.database == ":memory:":
                raise StorageError(
                    "A database in memory cannot be shared by the server's threads.",
                    remedy="Give a file: sqlite:////path/to/filterroom.sqlite",
                    code="database_url",
                )
            Path(self._url.database).parent.mkdir(parents=True, exist_ok=True)
            # One connection for writing: writers of this process queue in order instead of polling the lock.
            self._writer = create_engine(self._url, pool_size=1, max_overflow=0, pool_timeout=WRITE_WAIT_S)
            self._reader = create_engine(self._url, pool_size=8, max_overflow=40)
            _set_up_sqlite(self._writer, begin="BEGIN IMMEDIATE", read_only=False)
            _set_up_sqlite(self._reader, begin="BEGIN", read_only=True)
        else:
            self._writer = create_engine(self._url, pool_pre_ping=True)
            self._reader = self._writer.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
        self._listeners: list[Callable[[], None]] = []
        self._listeners_lock = threading.Lock()

    @contextmanager
    def read(self) -> Iterator[Connection]:
        """Give a connection that sees one consistent state and cannot write."""
        with _storage_errors(), self._reader.connect() as connection, connection.begin():
            yield connection

    @contextmanager
    def write(self) -> Iterator[Connection]:
        """Give a connection in a write transaction; commit at the end, then wake the listeners."""
        with _storage_errors(), self._writer.begin() as connection:
            yield connection
        with self._listeners_lock:
            listeners = tuple(self._listeners)
        for listener in listeners:
            listener()

    @contextmanager
    def migration(self) -> Iterator[Connection]:
        """Give a write transaction without foreign key actions.

        SQLite changes a table by copying and dropping it, and with foreign keys on the drop would delete
        the rows that refer to it.
        """
        if not self.is_sqlite:
            with self._writer.begin() as connection:
                yield connection
            return
        engine = create_engine(self._url, poolclass=NullPool)
        _set_up_sqlite(engine, begin="BEGIN IMMEDIATE", read_only=False, foreign_keys=False)
        with engine.begin() as connection:
            yield connection
            broken = connection.exec_driver_sql("PRAGMA foreign_key_check").fetchall()
            if broken:
                raise StorageError(
                    f"{len(broken)} rows would refer to nothing after the migration; nothing was changed.",
                    remedy="Restore the last backup or report this.",
                    code="migration",
                )

    def listen(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call `listener` after every commit, from the committing thread; the return value ends that.

        Every event is written in a transaction, so a stream of events waits here and then asks
        `backend.db.events.events_after`. The listener must not block: set a flag, or
        `loop.call_soon_threadsafe`.
        """
        with self._listeners_lock:
            self._listeners.append(listener)

        def stop() -> None:
            with self._listeners_lock:
                self._listeners.remove(listener)

        return stop

    def close(self) -> None:
        """Close all connections; the write-ahead log is then folded into the database file."""
        self._reader.dispose()
        self._writer.dispose()


def _set_up_sqlite(engine: Engine, *, begin: str, read_only: bool, foreign_keys: bool = True) -> None:
    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: object) -> None:
        # The driver must not start transactions of its own (before Python 3.12 it has no other switch).
        connection.isolation_level = None
        cursor = connection.cursor()
        cursor.execute("PRAGMA journal_mode=WAL")
        cursor.execute("PRAGMA synchronous=NORMAL")
        cursor.execute(f"PRAGMA foreign_keys={'ON' if foreign_keys else 'OFF'}")
        cursor.execute("PRAGMA busy_timeout=10000")
        if read_only:
            cursor.execute("PRAGMA query_only=ON")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        connection.exec_driver_sql(begin)


@contextmanager
def _storage_errors() -> Iterator[None]:
    """Turn a full disk, a locked or an unreadable database into an error that says what to do."""
    try:
        yield
    except (OperationalError, DBAPIError) as error:
        text = str(error.orig)
        if "disk is full" in text or "disk I/O" in text:
            raise StorageError(
                f"The database cannot be written: {text}.",
                remedy="Free space on the disk of the data folder; nothing that was stored is lost.",
                code="disk_full",
            ) from error
        if "locked" in text:
            raise StorageError(
                "Another program keeps the database locked.",
                remedy="Close it (a database browser, a second server) and try again.",
                code="database_locked",
            ) from error
        raise
