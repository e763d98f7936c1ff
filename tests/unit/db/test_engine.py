from __future__ import annotations

import datetime as dt
import threading
from pathlib import Path

import pytest
from sqlalchemy import insert, select
from sqlalchemy.exc import DBAPIError, StatementError

from backend.db import events
from backend.db.engine import Database
from backend.db.tables import idempotency_keys
from backend.errors import StorageError


def key(name: str, at: dt.datetime | None = None) -> dict[str, object]:
    at = at or dt.datetime(2026, 1, 1, tzinfo=dt.UTC)
    return {"key": name, "body_sha256": "0" * 64, "location": "/", "created_at": at}


def test_writers_that_read_first_never_find_the_database_locked(database: Database) -> None:
    """A plain BEGIN fails here for a quarter of the transactions."""
    failures: list[BaseException] = []

    def work(worker: int) -> None:
        try:
            for i in range(50):
                with database.write() as connection:
                    connection.execute(select(idempotency_keys)).all()
                    connection.execute(insert(idempotency_keys).values(**key(f"{worker}-{i}")))
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
    with database.read() as connection:
        assert len(connection.execute(select(idempotency_keys)).all()) == 200


def test_a_writer_waits_for_the_one_before(database: Database) -> None:
    """Events are then numbered in the order of their commits: whoever has seen number n has seen all before it."""

    def announce() -> None:
        with database.write() as connection:
            late.append(events.append_event(connection, "log", {}))

    late: list[int] = []
    with database.write() as connection:
        thread = threading.Thread(target=announce)
        thread.start()
        thread.join(0.1)
        assert thread.is_alive()
        early = events.append_event(connection, "log", {})
    thread.join()
    assert late > [early]


def test_a_reader_does_not_wait_for_a_writer_and_cannot_write(database: Database) -> None:
    with database.write() as writing:
        writing.execute(insert(idempotency_keys).values(**key("a")))
        with database.read() as reading:
            assert reading.execute(select(idempotency_keys)).all() == []
    with pytest.raises(DBAPIError, match=r"read-?only"), database.read() as reading:
        reading.execute(insert(idempotency_keys).values(**key("b")))


def test_an_error_rolls_back_and_wakes_nobody(database: Database) -> None:
    woken: list[int] = []
    stop = database.listen(lambda: woken.append(1))

    def fail() -> None:
        with database.write() as connection:
            connection.execute(insert(idempotency_keys).values(**key("a")))
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert woken == []
    with database.write() as connection:
        connection.execute(insert(idempotency_keys).values(**key("a")))
    assert woken == [1]
    stop()
    with database.write():
        pass
    assert woken == [1]


def test_instants_come_back_in_utc(database: Database) -> None:
    moscow = dt.timezone(dt.timedelta(hours=3))
    with database.write() as connection:
        connection.execute(insert(idempotency_keys).values(**key("a", dt.datetime(2026, 5, 1, 12, 0, tzinfo=moscow))))
        at = connection.scalar(select(idempotency_keys.c.created_at))
        assert at == dt.datetime(2026, 5, 1, 9, 0, tzinfo=dt.UTC)
        assert at.tzinfo is dt.UTC
        with pytest.raises(StatementError, match="without a time zone"):
            connection.execute(insert(idempotency_keys).values(**key("b", dt.datetime(2026, 5, 1))))


def test_a_database_in_memory_is_refused() -> None:
    with pytest.raises(StorageError, match="cannot be shared"):
        Database("sqlite://")


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("nonsense", "taken apart"),
        ("mysql://me:secret@host/db", "mysql://"),
        ("postgresql+asyncpg://me:secret@host/db", "'asyncpg'"),
    ],
)
def test_an_address_that_cannot_be_used_says_why_without_its_password(url: str, words: str) -> None:
    with pytest.raises(StorageError) as caught:
        Database(url)
    assert caught.value.code == "database_url"
    assert words in str(caught.value)
    assert "secret" not in str(caught.value)


def test_close_folds_the_log_into_the_file(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path}/x.sqlite")
    with database.write() as connection:
        connection.exec_driver_sql("CREATE TABLE t (a INTEGER)")
    database.close()
    assert [p.name for p in tmp_path.iterdir()] == ["x.sqlite"]
