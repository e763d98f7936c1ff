from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from backend.api import uploads
from backend.api.samples import SAMPLES, import_samples
from backend.api.services import Services
from backend.db import runs
from backend.db.engine import Database
from backend.db.ids import now
from backend.db.migrate import upgrade
from backend.files.store import Store
from backend.http.changes import Changes
from backend.jobs.engine import Engine
from backend.settings import Settings


@pytest.fixture
def services(tmp_path: Path) -> Iterator[Services]:
    """A server's parts without workers: recordings are read, runs stay in the queue."""
    settings = Settings(data_dir=tmp_path)
    database, store = Database(settings.url), Store(settings.store_dir)
    upgrade(database)
    engine = Engine(database, store, settings)
    yield Services(settings, database, store, engine, Changes(), started_at=now())
    engine.stop()
    database.close()


def test_samples_come_once_also_where_reading_takes_long(services: Services, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uploads, "WAIT_S", 0.0)
    for _ in range(2):
        import_samples(services)
        with services.database.read() as connection:
            found = runs.list_runs(connection)
        assert [run.label for run in found] == [sample.label for sample in reversed(SAMPLES)]
        assert {run.state for run in found} == {"queued"}
