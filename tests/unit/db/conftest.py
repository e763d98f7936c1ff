from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from backend.db import recordings
from backend.db.engine import Database
from backend.db.migrate import upgrade


@pytest.fixture(scope="session")
def template(request: pytest.FixtureRequest) -> str:
    """A database of PostgreSQL with all tables: to copy it is quicker than to migrate each new one."""
    server = request.getfixturevalue("postgresql_server")
    server.admin("CREATE DATABASE filled")
    database = Database(server.url("filled"))
    upgrade(database)
    database.close()
    return "filled"


@pytest.fixture
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """The address of a database that --database chooses."""
    if request.config.getoption("--database") == "sqlite":
        yield f"sqlite:///{tmp_path}/filterroom.sqlite"
    else:
        template = request.getfixturevalue("template")
        with request.getfixturevalue("postgresql_server").database(template) as url:
            yield url


@pytest.fixture
def database(url: str) -> Iterator[Database]:
    database = Database(url)
    upgrade(database)
    yield database
    database.close()


@pytest.fixture
def recording(database: Database) -> recordings.Recording:
    """A recording in the state `parsing`."""
    with database.write() as connection:
        return recordings.create_recording(
            connection,
            name="marks.csv",
            sha256="a" * 64,
            fingerprint="b" * 64,
            files=[
                recordings.StoredFile("data", "marks.csv", "a" * 64, 100),
                recordings.StoredFile("site", "site.json", "c" * 64, 20),
            ],
            options={"kind": "toa_marks"},
        )
