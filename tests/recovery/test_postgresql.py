"""A server whose rows are in PostgreSQL: one at a time, and up again when the database is."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psycopg
import pytest

from algorithms.errors import InputError
from backend.db import idempotency
from backend.db.engine import Database
from backend.db.migrate import upgrade
from backend.errors import StateError, StorageError, UnavailableError
from tests.api.conftest import problem, start_server
from tests.postgresql import PostgreSQL
from tests.recovery.conftest import settle, wait_for

pytestmark = [pytest.mark.recovery, pytest.mark.slow]
ROOT = Path(__file__).parents[2]


@pytest.fixture
def url(postgresql_server: PostgreSQL) -> Iterator[str]:
    with postgresql_server.database() as url:
        yield url


@pytest.fixture
def database(url: str) -> Iterator[Database]:
    database = Database(url)
    upgrade(database)
    yield database
    database.close()


def remember(database: Database, key: str) -> None:
    with database.write() as connection:
        idempotency.remember_key(connection, key, "0" * 64, "/")


def test_a_second_server_is_refused_until_the_first_is_gone(database: Database, url: str) -> None:
    second = Database(url)
    with pytest.raises(StateError) as caught:
        upgrade(second)
    assert caught.value.code == "database_in_use"
    with second.read() as connection:
        assert idempotency.find_key(connection, "a") is None, "looking is free"
    database.close()
    remember(second, "a")
    second.close()


def test_who_lost_the_database_to_another_server_changes_nothing(
    database: Database, url: str, postgresql_server: PostgreSQL
) -> None:
    remember(database, "first")
    postgresql_server.admin("SELECT pg_terminate_backend(pid) FROM pg_locks WHERE locktype = 'advisory'")
    second = Database(url)
    remember(second, "second")
    with pytest.raises(StateError, match="Another server uses the database"):
        remember(database, "too late")
    second.close()
    remember(database, "again")
    with database.read() as connection:
        found = [k for k in ("first", "second", "too late", "again") if idempotency.find_key(connection, k)]
    assert found == ["first", "second", "again"]


def test_goes_on_when_the_database_is_back(database: Database, postgresql_server: PostgreSQL) -> None:
    remember(database, "before")
    postgresql_server.stop()
    try:
        for _ in range(2):
            with pytest.raises(UnavailableError, match="does not answer") as caught:
                remember(database, "while it is away")
            with pytest.raises(UnavailableError), database.read():
                pytest.fail("there is nothing to read from")
    finally:
        postgresql_server.start()
    assert caught.value.code == "database_unreachable"
    remember(database, "after")
    with database.read() as connection:
        assert idempotency.find_key(connection, "before")
        assert not idempotency.find_key(connection, "while it is away")


def test_a_run_queued_while_the_database_goes_away_is_taken_when_it_is_back(
    plugin: None, url: str, postgresql_server: PostgreSQL, tmp_path: Path
) -> None:
    house = settle(tmp_path / "data", workers=1, database_url=url)
    house.engine.start()
    wait_for(lambda: house.engine.status().state == "ready", "engine ready", 240)
    # The engine hears of the run when the database is away, and nobody tells it twice.
    run_id = house.store_run({})
    postgresql_server.stop()
    try:
        house.engine.notify()
        time.sleep(3)
    finally:
        postgresql_server.start()
    run = wait_for(lambda: r if (r := house.run(run_id)).state in ("succeeded", "failed") else None, "it is taken", 30)
    house.engine.stop()
    house.database.close()
    assert (run.state, run.error) == ("succeeded", None)


def test_what_postgresql_cannot_store_is_the_users_to_mend(database: Database) -> None:
    for text in ("a\0b", "x" * 129):
        with pytest.raises(InputError, match="cannot be stored"):
            remember(database, text)


def test_a_table_that_somebody_locked(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("backend.db.postgresql._LOCK_WAIT_S", 1)
    database = Database(url)
    upgrade(database)
    with psycopg.connect(url) as other:
        other.execute("LOCK TABLE idempotency_keys")
        with pytest.raises(UnavailableError) as caught:
            remember(database, "a")
    assert caught.value.code == "database_locked"
    remember(database, "a")
    database.close()


def test_missing_rights_are_named(url: str, postgresql_server: PostgreSQL) -> None:
    postgresql_server.admin("DROP ROLE IF EXISTS guest")
    postgresql_server.admin("CREATE ROLE guest LOGIN")
    guest = Database(url.replace("filterroom@", "guest@"))
    with pytest.raises(StorageError, match="permission denied") as caught:
        upgrade(guest)
    guest.close()
    assert caught.value.code == "database_rights"
    postgresql_server.admin("DROP ROLE guest")


def test_the_server_stays_up_while_its_database_is_away(
    url: str, postgresql_server: PostgreSQL, tmp_path: Path
) -> None:
    server = start_server(
        tmp_path / "data", "--no-samples", "--workers", "1", FILTERROOM_DATABASE_URL=url.replace("@/", ":secret@/")
    )
    try:
        with server.client() as client:
            assert client.get("/api/v1/runs").json()["items"] == []
            postgresql_server.stop()
            try:
                answer = client.get("/api/v1/runs")
                problem(answer, 503, "database_unreachable")
                assert answer.headers["retry-after"]
                assert "secret" not in answer.text
                assert client.get("/healthz").status_code == 200
                assert client.get("/readyz").status_code == 503
                assert client.get("/api/v1/meta").status_code == 503
            finally:
                postgresql_server.start()
            wait_for(lambda: client.get("/api/v1/runs").status_code == 200, "the runs are there again", 15)
            # It writes nothing: it holds the database all the same.
            locks = "SELECT 1 FROM pg_locks WHERE locktype = 'advisory'"
            wait_for(lambda: postgresql_server.admin(locks), "the lock is taken again", 15)
            second = subprocess.run(
                [*(sys.executable, "-m", "backend.cli", "serve", "--port", "0", "--data", str(tmp_path / "other"))],
                env={"FILTERROOM_DATABASE_URL": url, "PATH": ""},
                cwd=ROOT,
                capture_output=True,
                text=True,
                timeout=60,
                check=False,
            )
            assert second.returncode == 1
            assert "Another server uses the database" in second.stderr
    finally:
        assert server.stop() == 0
    assert "secret" not in server.log.read_text()
