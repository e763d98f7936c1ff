"""A backup made while the server works unpacks to a data folder with the same runs and the same bytes."""

from __future__ import annotations

import json
import os
import sqlite3
import tarfile
import threading
from pathlib import Path
from typing import Any

import httpx2
import pytest

from backend.backup import back_up
from backend.db.engine import Database
from backend.db.migrate import upgrade
from backend.errors import StorageError
from backend.files.store import Store
from backend.settings import Settings
from tests.api.conftest import ServerProcess, Upload, finished, start_server
from tests.api.test_command_line import run_command


def restored(archive: Path, folder: Path) -> Path:
    with tarfile.open(archive) as packed:
        packed.extractall(folder, filter="data")
    return folder


@pytest.mark.slow
def test_a_restored_folder_has_the_same_runs_and_bytes(
    server: ServerProcess, api: httpx2.Client, run: dict[str, Any], recording: dict[str, Any], tmp_path: Path
) -> None:
    archive = tmp_path / "backup.tar"
    done = run_command("backup", str(archive), "--data", str(server.data), "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["missing"], told["damaged"]) == ([], [])
    assert told["files"] >= 4
    assert told["bytes"] == archive.stat().st_size
    assert archive.stat().st_mode & 0o077 == 0
    assert not [p for p in (*server.data.iterdir(), *tmp_path.iterdir()) if "backup-" in p.name or ".part" in p.name]

    folder = restored(archive, tmp_path / "restored")
    assert not (folder / "token").exists()
    second = start_server(folder, "--no-samples", "--workers", "1")
    try:
        with second.client() as other:
            for path in (f"runs/{run['id']}", f"recordings/{recording['id']}", f"runs/{run['id']}/tables/metrics.json"):
                assert other.get(f"/api/v1/{path}").json() == api.get(f"/api/v1/{path}").json()
            for path in (f"runs/{run['id']}/result.npz", f"recordings/{recording['id']}/data.csv"):
                ours = api.get(f"/api/v1/{path}").raise_for_status().content
                assert other.get(f"/api/v1/{path}").raise_for_status().content == ours
            assert other.get("/api/v1/runs").json()["items"]
            body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf"}]}
            assert finished(other, other.post("/api/v1/runs", json=body).headers["location"])["state"] == "succeeded"
    finally:
        assert second.stop() == 0


def test_backups_while_recordings_come_and_go(server: ServerProcess, upload: Upload, tmp_path: Path) -> None:
    stop = threading.Event()

    def churn() -> None:
        with server.client() as client:
            for i in range(1000):
                if stop.is_set():
                    return
                data = f"time_s,toa_A_ns,toa_B_ns\n{i},1,2\n{i + 1},1,2\n".encode()
                made = client.post("/api/v1/recordings", files=[("file", (f"{i}.csv", data))])
                client.delete(f"/api/v1/recordings/{made.json()['id']}")

    worker = threading.Thread(target=churn)
    worker.start()
    try:
        for i in range(4):
            archive = tmp_path / f"{i}.tar.gz"
            done = back_up(server.data, archive)
            assert (done.missing, done.damaged) == ((), ())
            folder = restored(archive, tmp_path / str(i))
            with sqlite3.connect(folder / "filterroom.sqlite") as database:
                assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
                wanted = {
                    f["sha256"]
                    for (files,) in database.execute("SELECT files FROM recordings")
                    for f in json.loads(files)
                }
            database.close()
            assert wanted <= set(Store(folder / "store").hashes())
    finally:
        stop.set()
        worker.join()


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A data folder with one recording's file, as the database tells it."""
    folder = tmp_path / "data"
    database = Database(Settings(data_dir=folder).url)
    upgrade(database)
    database.close()
    sha = Store(folder / "store").put_bytes(b"measurements")
    with sqlite3.connect(folder / "filterroom.sqlite") as rows:
        files = json.dumps([{"role": "data", "name": "a.csv", "sha256": sha, "size": 12}])
        names = [row[1] for row in rows.execute("PRAGMA table_info(recordings)")]
        values = dict.fromkeys(names, "0") | {"id": "a", "files": files, "data_sha256": None}
        rows.execute(
            f"INSERT INTO recordings ({', '.join(names)}) VALUES ({', '.join('?' * len(names))})",
            [values[n] for n in names],
        )
    rows.close()
    return folder


def test_what_nothing_refers_to_stays_out(small: Path, tmp_path: Path) -> None:
    Store(small / "store").put_bytes(b"left over")
    assert back_up(small, tmp_path / "b.tar").files == 1


def test_missing_and_damaged_files_are_told(small: Path, tmp_path: Path) -> None:
    blob = next((small / "store").glob("[0-9a-f][0-9a-f]/*"))
    blob.write_bytes(b"measurementz")
    done = run_command("backup", str(tmp_path / "b.tar"), "--data", str(small))
    assert done.returncode == 1
    assert "1 stored files are damaged" in done.stderr
    blob.unlink()
    done = run_command("backup", str(tmp_path / "b.tar"), "--data", str(small), "--json")
    assert done.returncode == 1
    assert json.loads(done.stdout)["missing"] == [blob.parent.name + blob.name]


def test_an_older_backup_stays_where_a_new_one_fails(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    archive = tmp_path / "b.tar"
    archive.write_text("older")

    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tarfile.TarFile.addfile", fail)
    with pytest.raises(OSError, match="No space"):
        back_up(small, archive)
    assert archive.read_text() == "older"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["b.tar", "data"]
    assert not list(small.glob(".backup-*"))


def test_a_file_system_without_hard_links(small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)
    assert back_up(small, tmp_path / "b.tar").files == 1


def test_no_data_folder(tmp_path: Path) -> None:
    done = run_command("backup", str(tmp_path / "b.tar"), "--data", str(tmp_path / "nowhere"), "--json")
    assert done.returncode == 1
    assert json.loads(done.stdout)["error"]["code"] == "no_data"
    assert not (tmp_path / "nowhere").exists()
    (tmp_path / "filterroom.sqlite").write_bytes(b"")
    with pytest.raises(StorageError, match="no database of this program"):
        back_up(tmp_path, tmp_path / "b.tar")


def test_a_database_elsewhere_is_not_ours_to_copy(tmp_path: Path) -> None:
    done = run_command("backup", str(tmp_path / "b.tar"), FILTERROOM_DATABASE_URL="postgresql://host/db")
    assert done.returncode == 2
    assert "its tools" in done.stderr
