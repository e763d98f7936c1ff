"""The disk of the data folder is full, or takes no changes: said in words, nothing half done, and on it goes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from backend.db.blobs import referenced_blobs
from backend.db.engine import Database
from backend.files.store import Store
from backend.settings import Settings
from tests.api.conftest import FINAL, ServerProcess, problem, start_server
from tests.recovery.conftest import PLUGIN, wait_for
from tests.recovery.disks import filled, read_only, small_disk

pytestmark = [pytest.mark.recovery, pytest.mark.slow]
ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "examples" / "recordings"
# Blobs and rows of several runs fit, and filling it takes no time.
DISK_MIB = 48


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server with one worker whose data folder is a small disk; the log lies elsewhere."""
    with small_disk(tmp_path_factory.mktemp("disk") / "data", DISK_MIB) as data:
        paths = os.pathsep.join(map(str, (ROOT, PLUGIN)))
        running = start_server(data, "--no-samples", "--workers", "1", PYTHONPATH=paths)
        yield running
        assert running.stop() == 0


@pytest.fixture(scope="module")
def client(server: ServerProcess) -> Iterator[httpx2.Client]:
    with server.client() as client:
        wait_for(lambda: client.get("/readyz").status_code == 200, "the workers are ready", 240)
        yield client


def upload(client: httpx2.Client, name: str, lines: int = 40) -> httpx2.Response:
    data = b"".join((SAMPLE / "sample_marks.csv").read_bytes().splitlines(keepends=True)[: lines + 1])
    return client.post(
        "/api/v1/recordings",
        files=[("file", (f"{name}.csv", data, "text/csv"))],
        data={"options": json.dumps({"name": name}), "site": (SAMPLE / "sample_site.json").read_text()},
    )


def queue(client: httpx2.Client, recording_id: str, *parameters: dict[str, Any]) -> httpx2.Response:
    entries = [{"name": "rehearsal", "label": f"entry {i}", "parameters": p} for i, p in enumerate(parameters)]
    return client.post("/api/v1/runs", json={"recording_id": recording_id, "algorithms": entries, "seed": 7})


def state(client: httpx2.Client, run_id: str, *states: str) -> dict[str, Any]:
    def look() -> dict[str, Any] | None:
        run: dict[str, Any] = client.get(f"/api/v1/runs/{run_id}").json()
        return run if run["state"] in states else None

    found: dict[str, Any] = wait_for(look, f"run {run_id} {' or '.join(states)}")
    return found


def orphans(server: ServerProcess) -> set[str]:
    """Files that nothing refers to, and half-written ones."""
    settings = Settings(data_dir=server.data)
    store, database = Store(settings.store_dir), Database(settings.url)
    try:
        with store.guard(), database.read() as connection:
            kept = referenced_blobs(connection, None)
        return set(store.hashes()) - kept | {p.name for p in store.temporary().parent.iterdir()}
    finally:
        database.close()


@pytest.fixture(scope="module")
def recording_id(client: httpx2.Client) -> str:
    answer = upload(client, "before")
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def test_uploads_and_new_runs_are_refused_until_there_is_space(
    server: ServerProcess, client: httpx2.Client, recording_id: str
) -> None:
    kept = orphans(server)
    with filled(server.data):
        for answer in (upload(client, "meanwhile", 400), queue(client, recording_id, {})):
            problem(answer, 507, "disk_full")
            assert "Free space" in answer.json()["detail"]
        assert client.get(f"/api/v1/recordings/{recording_id}").json()["state"] == "ready"
        assert client.get("/healthz").status_code == 200
    assert orphans(server) == kept == set()
    found = upload(client, "meanwhile", 400)
    assert (found.status_code, found.json()["state"]) == (201, "ready"), "what was refused is no obstacle"
    state(client, queue(client, recording_id, {}).json()["id"], "succeeded")
    wait_for(lambda: not orphans(server), "blocks are folded into the result", 10)


@pytest.mark.parametrize("room", [0, 2**15, 2**17, 2**18], ids="{} bytes left".format)
def test_a_recording_that_cannot_be_stored_leaves_nothing(
    server: ServerProcess, client: httpx2.Client, room: int
) -> None:
    """Whichever step comes first that finds no room: the bytes, the rows, the arrays."""
    name = f"with {room}"
    with filled(server.data, room):
        answer = upload(client, name, 400)
        assert answer.status_code in (201, 507), answer.text
        assert room > 0 or answer.status_code == 507
    if answer.status_code == 507:
        assert answer.json()["code"] == "disk_full", answer.text
        wait_for(lambda: not orphans(server), "nothing is left", 10)
        answer = upload(client, name, 400)
        assert answer.status_code == 201, answer.text
    where = answer.headers["location"]
    wait_for(lambda: client.get(where).json()["state"] == "ready", "it is read when there is space", 30)
    wait_for(lambda: not orphans(server), "nothing is left", 10)


@pytest.mark.parametrize("blocks", [1, 2], ids="{} blocks".format)
def test_a_run_that_cannot_be_stored_fails_with_the_reason(
    server: ServerProcess, client: httpx2.Client, recording_id: str, blocks: int
) -> None:
    run_id = queue(client, recording_id, *[{}] * (blocks - 1), {"seconds": 3.0}).json()["id"]

    # The first of two blocks is stored by the time that progress passes half.
    def is_in_the_last() -> bool:
        progress = client.get(f"/api/v1/runs/{run_id}").json()["progress"]
        return bool(progress["done"] * blocks > progress["total"] * (blocks - 1))

    wait_for(is_in_the_last, "the last block is under way")
    with filled(server.data):
        assert client.get(f"/api/v1/runs/{run_id}").json()["state"] == "running"
        wait_for(lambda: f"run {run_id} failed" in server.log.read_text(), "the log says what hinders", 20)
    run = state(client, run_id, "failed", "succeeded")
    assert run["state"] == "failed"
    assert run["error"]["code"] == "disk_full"
    assert "Free space" in run["error"]["remedy"]
    wait_for(lambda: not orphans(server), "finished blocks are gone", 10)
    state(client, queue(client, recording_id, {}, {}).json()["id"], "succeeded")


@pytest.mark.parametrize("room", [2**15, 2**16, 2**17, 2**18, 2**19], ids="{} bytes left".format)
def test_wherever_a_run_finds_no_room_it_ends_and_leaves_nothing(
    server: ServerProcess, client: httpx2.Client, room: int
) -> None:
    """At its row, its start, a block or its result, which is as large as all blocks together."""
    large = upload(client, "large", 2000).json()["id"]
    with filled(server.data, room):
        logged = len(server.log.read_text())
        answer = queue(client, large, {}, {})
        if answer.status_code == 507:
            problem(answer, 507, "disk_full")
        else:
            where = f"/api/v1/runs/{answer.json()['id']}"
            wait_for(
                lambda: client.get(where).json()["state"] in FINAL or "disk" in server.log.read_text()[logged:],
                "it ends, or the log says why it cannot",
            )
    if answer.status_code != 507:
        run = state(client, answer.json()["id"], *FINAL)
        assert run["state"] == "succeeded" or run["error"]["code"] == "disk_full", run["error"]
    wait_for(lambda: not orphans(server), "nothing is left", 10)
    state(client, queue(client, large, {}, {}).json()["id"], "succeeded")


def test_the_log_of_the_server_has_no_traceback_for_it(server: ServerProcess, client: httpx2.Client) -> None:
    with filled(server.data):
        problem(upload(client, "once more", 400), 507, "disk_full")
    assert "Traceback" not in server.log.read_text()


def test_a_folder_that_becomes_read_only(server: ServerProcess, client: httpx2.Client, recording_id: str) -> None:
    with read_only(server.data):
        answer = upload(client, "closed")
        problem(answer, 507, "storage")
        assert "permissions" in answer.json()["detail"]
        assert client.get(f"/api/v1/recordings/{recording_id}").json()["state"] == "ready"
        run = state(client, queue(client, recording_id, {}).json()["id"], "failed", "succeeded")
    assert run["state"] == "failed"
    assert (run["error"]["code"], "permissions" in run["error"]["remedy"]) == ("storage", True)
    assert upload(client, "closed").status_code == 201
    state(client, queue(client, recording_id, {}).json()["id"], "succeeded")
    wait_for(lambda: not orphans(server), "nothing is left", 10)


@pytest.mark.parametrize("token", ["", "given"])
@pytest.mark.parametrize("used", [False, True], ids=["new folder", "used folder"])
def test_no_server_starts_on_a_read_only_folder(tmp_path: Path, token: str, used: bool) -> None:
    data = tmp_path / "data"
    data.mkdir()
    if used:
        Settings(data_dir=data).read_token()
        (data / "lock").touch()
    with read_only(data):
        done = subprocess.run(
            [sys.executable, "-m", "backend.cli", "serve", "--port", "0", "--data", str(data)],
            env={**{k: v for k, v in os.environ.items() if not k.startswith("FILTERROOM_")}, "FILTERROOM_TOKEN": token},
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    assert done.returncode == 1
    assert f"The data folder {data} cannot be written: Read-only file system." in done.stderr
    assert "--data or FILTERROOM_DATA_DIR" in done.stderr
    assert "Traceback" not in done.stderr
