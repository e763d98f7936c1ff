"""The database: one writer at a time, readers that never wait for it.

Inside this process writers queue for one connection, and what other processes may do is settled by BEGIN IMMEDIATE
(`backend.db.sqlite`) or by a lock on the whole database (`backend.db.postgresql`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sqlalchemy import Connection, make_url
from sqlalchemy.exc import ArgumentError

from backend.db.postgresql import postgresql_engines
from backend.db.refusals import translated
from backend.db.sqlite import migration_engine, sqlite_engines
from backend.errors import StorageError

# How long a writer waits for another one, seconds. Write transactions take milliseconds.
WRITE_WAIT_S = 30
_ENGINES = {"sqlite": sqlite_engines, "postgresql": postgresql_engines}


class Database:
    """Connections to the database of a server.

    `read()` and `write()` give a `Connection` inside a transaction; `write()` commits at the end of the
    block, or rolls back when it raises. Never compute inside a write transaction.

    Raises
    ------
    StorageError
        The address cannot be used. Whether a database answers there is seen at the first transaction.
    """

    def __init__(self, url: str) -> None:
        try:
            self._url = make_url(url)
        except ArgumentError as error:
            # The address may hold a password: it is not repeated.
            raise _no_address("It cannot be taken apart.") from error
        engines = _ENGINES.get(self._url.get_backend_name())
        if engines is None:
            raise _no_address(f"It begins with {self._url.drivername}://.")
        self._writer, self._reader = engines(self._url, WRITE_WAIT_S)
        self._listeners: list[Callable[[], None]] = []
        self._listeners_lock = threading.Lock()

    @contextmanager
    def read(self) -> Iterator[Connection]:
        """Give a connection that sees one consistent state and cannot write."""
        with translated(self._url, writing=False), self._reader.connect() as connection, connection.begin():
            yield connection

    @contextmanager
    def write(self) -> Iterator[Connection]:
        """Give a connection in a write transaction; commit at the end, then wake the listeners."""
        with translated(self._url, writing=True), self._writer.begin() as connection:
            yield connection
        with self._listeners_lock:
            listeners = tuple(self._listeners)
        for listener in listeners:
            listener()

    @contextmanager
    def migration(self) -> Iterator[Connection]:
        """Give a write transaction in which tables may change; it is committed whole or not at all."""
        if self._url.get_backend_name() != "sqlite":
            with translated(self._url, writing=True), self._writer.begin() as connection:
                yield connection
            return
        with translated(self._url, writing=True), migration_engine(self._url).begin() as connection:
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
        """Close all connections: SQLite's log is then folded into its file, PostgreSQL is free for another server."""
        self._reader.dispose()
        self._writer.dispose()


def _no_address(why: str) -> StorageError:
    return StorageError(
        f"FILTERROOM_DATABASE_URL is no address of a database that this program uses. {why}",
        remedy="Give postgresql://USER:PASSWORD@HOST/DATABASE, or sqlite:////path/to/file.",
        code="database_url",
    )
