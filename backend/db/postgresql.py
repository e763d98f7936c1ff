"""Connections to PostgreSQL: one for writing, which holds the database for this server, and some for reading.

The one connection for writing gives what BEGIN IMMEDIATE gives in SQLite: transactions that read first and write later
never meet, and the numbers of events grow in the order of their commits. It holds an advisory lock as long as it
lives. So nobody can write who has not got the lock: a server that lost its connection, and meanwhile the database to
another server, finds out before it changes anything. An idle server looks after its connection every few seconds.
"""

from __future__ import annotations

import logging
import threading
from importlib.util import find_spec
from typing import Any

from sqlalchemy import URL, Engine, create_engine, event
from sqlalchemy.exc import SQLAlchemyError

from algorithms.errors import FilterRoomError
from backend.errors import StateError, StorageError

logger = logging.getLogger(__name__)

# "filterro" as a number: the lock is one of this database, whatever else uses it.
LOCK = int.from_bytes(b"filterro", "big")
# How long the connection of a dead server may linger, and statements wait for a table that somebody locked, seconds.
_LINGER_S = 3
_LOCK_WAIT_S = 10
_CONNECT_S = 5
# How soon an idle server takes the database again when the connection broke, seconds.
_LOOK_S = 2


def postgresql_engines(url: URL, wait_s: float) -> tuple[Engine, Engine]:
    """Return the engines for writing and for reading; a writer waits `wait_s` for its turn in this process.

    Raises
    ------
    StorageError
        The driver is not installed, or the address asks for another one.
    """
    if url.get_driver_name() != "psycopg":
        raise StorageError(
            f"The driver {url.get_driver_name()!r} is not used by this program.",
            remedy="Begin the address with postgresql://",
            code="database_url",
        )
    if find_spec("psycopg") is None:
        raise StorageError(
            "PostgreSQL needs the package psycopg, which is not installed.",
            remedy="Install it with the program: uv sync --extra postgres, or pip install 'filterroom[postgres]'",
            code="database_url",
        )
    options: dict[str, Any] = {"pool_pre_ping": True}
    if "connect_timeout" not in url.query:
        options["connect_args"] = {"connect_timeout": _CONNECT_S}
    writer = create_engine(url, pool_size=1, max_overflow=0, pool_timeout=wait_s, **options)
    reader = create_engine(url, pool_size=8, max_overflow=12, isolation_level="REPEATABLE READ", **options)

    holding, closed = threading.Event(), threading.Event()

    @event.listens_for(writer, "connect")
    def _hold(connection: Any, _record: object) -> None:
        _set_up(connection)
        _take_lock(connection, url)
        if not holding.is_set():
            holding.set()
            threading.Thread(target=_keep, args=(writer, closed), name="database", daemon=True).start()

    @event.listens_for(reader, "connect")
    def _look(connection: Any, _record: object) -> None:
        _set_up(connection)

    @event.listens_for(writer, "engine_disposed")
    def _end(_engine: Engine) -> None:
        closed.set()

    return writer, reader.execution_options(postgresql_readonly=True)


def _set_up(connection: Any) -> None:
    connection.execute(f"SET lock_timeout = '{_LOCK_WAIT_S}s'")
    # The server notices within two minutes that this machine is gone, and the lock is free again.
    for name, value in (("idle", 60), ("interval", 15), ("count", 4)):
        connection.execute(f"SET tcp_keepalives_{name} = {value}")
    connection.commit()


def _take_lock(connection: Any, url: URL) -> None:
    from psycopg.errors import LockNotAvailable

    try:
        connection.execute(f"SET LOCAL lock_timeout = '{_LINGER_S}s'")
        connection.execute("SELECT pg_advisory_lock(%s)", (LOCK,))
        connection.commit()
    except LockNotAvailable as error:
        connection.close()
        raise StateError(
            f"Another server uses the database {url.render_as_string(hide_password=True)}.",
            remedy="Stop it, or give this one a database of its own with FILTERROOM_DATABASE_URL.",
            code="database_in_use",
        ) from error


def _keep(writer: Engine, closed: threading.Event) -> None:
    """Look after the connection that holds the lock: a broken one is replaced before another server comes by."""
    held = True
    while not closed.wait(_LOOK_S):
        try:
            # Taken from the pool, a connection is tried, and opened anew where it is broken.
            with writer.connect():
                pass
            if not held:
                logger.info("the database is there again")
            held = True
        except (SQLAlchemyError, FilterRoomError) as error:
            if held:
                logger.error("the database is lost: %s", " ".join(str(error).split()))
            held = False
