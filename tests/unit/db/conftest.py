from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from backend.db import recordings
from backend.db.engine import Database
from backend.db.migrate import upgrade


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    database = Database(f"sqlite:///{tmp_path}/filterroom.sqlite")
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
