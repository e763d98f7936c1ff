"""A real engine with real worker processes, and a plug-in algorithm that misbehaves."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.recording import ToaMarks
from algorithms.site import Site
from backend.db import recordings, runs
from backend.db.engine import Database
from backend.db.ids import new_id
from backend.db.migrate import upgrade
from backend.files.store import Store
from backend.jobs.engine import Engine
from backend.settings import Settings

PLUGIN = Path(__file__).parent / "plugin"
WAIT_S = 120
SITE = Site.model_validate(
    {
        "stations": [
            {"name": name, "east_m": 5000.0 * east, "north_m": 5000.0 * north, "up_m": 10.0}
            for name, east, north in (("1", 1, 1), ("2", 1, -1), ("3", -1, 0), ("4", 0, 0))
        ]
    }
)


def wait_for(condition: Callable[[], Any], what: str, seconds: float = WAIT_S) -> Any:
    """Return the condition's first true value; fail with `what` when it takes longer."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if value := condition():
            return value
        time.sleep(0.02)
    pytest.fail(f"{what}: not within {seconds:g} s")


@dataclass
class House:
    """Database, store and engine of one data folder."""

    settings: Settings
    database: Database
    store: Store
    engine: Engine
    recording_id: str

    def queue(self, *parameters: dict[str, Any], seed: int = 7, algorithm: str = "rehearsal") -> str:
        """Queue a run with one entry per dict of parameters."""
        run_id = self.store_run(*parameters, seed=seed, algorithm=algorithm)
        self.engine.notify()
        return run_id

    def store_run(self, *parameters: dict[str, Any], seed: int = 7, algorithm: str = "rehearsal") -> str:
        """Write a queued run down; the engine is not told."""
        entries = [runs.Entry(algorithm, f"entry {i}", p) for i, p in enumerate(parameters)]
        with self.database.write() as connection:
            run = runs.create_run(
                connection,
                algorithms=entries,
                source={"recording_id": self.recording_id},
                recording_ids=[self.recording_id],
                seed=seed,
                progress_total=100 * len(entries),
            )
        return run.id

    def run(self, run_id: str) -> runs.Run:
        with self.database.read() as connection:
            return runs.get_run(connection, run_id)

    def wait(self, run_id: str, *states: str) -> runs.Run:
        """Wait until a run is in one of the states."""
        return wait_for(
            lambda: run if (run := self.run(run_id)).state in states else None, f"run {run_id} {' or '.join(states)}"
        )


def settle(data_dir: Path, **more: Any) -> House:
    """Make a data folder with one recording; the engine is not started yet."""
    settings = Settings(data_dir=data_dir, **{"workers": 2, **more})
    database = Database(settings.url)
    upgrade(database)
    store = Store(settings.store_dir)
    with database.write() as connection:
        recording_id = add_recording(connection, store)
    return House(settings, database, store, Engine(database, store, settings), recording_id)


def add_recording(connection: Any, store: Store, marks: int = 5) -> str:
    """Store a recording as the reader would."""
    recording = ToaMarks(
        time_s=np.arange(float(marks)),
        row=np.arange(1, marks + 1),
        target=np.zeros(marks, np.int64),
        toa_s=np.full((marks, 4, 1), 1e-5),
        altitude_m=np.full((marks, 1), 8000.0),
        stations=("1", "2", "3", "4"),
        site=SITE,
    )
    created = recordings.create_recording(
        connection, name="marks", sha256="a" * 64, fingerprint=new_id().ljust(64, "0"), files=[], options={}
    )
    parsed = recordings.Parsed(
        "toa_marks",
        "csv",
        marks,
        marks,
        0.0,
        marks - 1.0,
        None,
        SITE.to_json(),
        False,
        [],
        [],
        store.put_arrays(recording.to_arrays()),
    )
    assert recordings.set_parsed(connection, created.id, parsed)
    return created.id


@pytest.fixture(scope="module")
def plugin() -> Iterator[None]:
    """Let worker processes find the plug-in: they take over this process's path."""
    sys.path.append(str(PLUGIN))
    yield
    sys.path.remove(str(PLUGIN))


@pytest.fixture(scope="module")
def house(plugin: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    """An engine with two workers that is ready."""
    house = settle(tmp_path_factory.mktemp("house"))
    house.engine.start()
    wait_for(lambda: house.engine.status().state == "ready", "engine ready", 240)
    yield house
    house.engine.stop()
    house.database.close()
