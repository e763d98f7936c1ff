"""Start an engine on a data folder and wait: what the tests kill. Arguments: data folder, what to queue (JSON)."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from backend.db import recordings, runs
from backend.db.engine import Database
from backend.db.migrate import upgrade
from backend.files.lock import DataFolderLock
from backend.files.store import Store
from backend.jobs.engine import Engine
from backend.settings import Settings


def main(data_dir: Path, entries: list[dict[str, object]]) -> None:
    settings = Settings(data_dir=data_dir, workers=2)
    DataFolderLock(data_dir).acquire()
    database, store = Database(settings.url), Store(settings.store_dir)
    upgrade(database)
    engine = Engine(database, store, settings)
    engine.start()
    if entries:
        with database.write() as connection:
            (recording,) = recordings.list_recordings(connection, limit=1)
            run = runs.create_run(
                connection,
                algorithms=[runs.Entry("rehearsal", f"entry {i}", e) for i, e in enumerate(entries)],
                source={"recording_id": recording.id},
                recording_ids=[recording.id],
                seed=7,
                progress_total=100,
            )
        engine.notify()
        print(run.id, flush=True)
    else:
        print("started", flush=True)
    sys.stdin.read()
    engine.stop()
    database.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), json.loads(sys.argv[2]))
