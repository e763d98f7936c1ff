"""Another program keeps the database locked for longer than anybody waits: said so, and all goes on afterwards."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest

from backend.db import recordings
from backend.errors import UnavailableError
from tests.api.conftest import problem, start_server
from tests.recovery.conftest import House, settle, wait_for

pytestmark = [pytest.mark.recovery, pytest.mark.slow]
LOCKING = """
import sqlite3, sys
connection = sqlite3.connect(sys.argv[1], isolation_level=None)
connection.execute("BEGIN IMMEDIATE")
print("locked", flush=True)
sys.stdin.read()
"""
MARKS = "time_s,toa_A_ns,toa_B_ns,altitude_m\n" + "".join(f"{i},{100 + i},{200 + i},8000\n" for i in range(20))


@contextmanager
def locked(data_dir: Path) -> Iterator[None]:
    """Hold the database's lock in another process."""
    command = [sys.executable, "-c", LOCKING, str(data_dir / "filterroom.sqlite")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "locked\n"
        yield


@pytest.fixture(scope="module")
def house(plugin: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    """An engine that soon loses its patience with the database."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("backend.db.sqlite.BUSY_MS", 200)
        patch.setattr("backend.jobs.parsing.RETRY_S", 0.2)
        house = settle(tmp_path_factory.mktemp("house"), workers=1)
        house.engine.start()
        wait_for(lambda: house.engine.status().state == "ready", "engine ready", 240)
        yield house
        house.engine.stop()
        house.database.close()


def test_a_block_and_a_result_wait_until_they_can_be_stored(
    house: House, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    markers = [tmp_path / f"starts {i}" for i in range(3)]
    run_id = house.queue(*[{"seconds": s, "marker": str(m)} for m, s in zip(markers, (0.5, 0.0, 0.0), strict=True)])
    wait_for(markers[0].exists, "the first block is under way")
    with locked(house.settings.data_dir):
        wait_for(lambda: "cannot go on" in caplog.text, "it is logged", 10)
        with pytest.raises(UnavailableError, match="locked"):
            house.engine.cancel(run_id)
        assert house.run(run_id).state == "running"
        assert not markers[2].exists(), "of what could not be stored either, no more than one block is computed"
    run = house.wait(run_id, "succeeded", "failed")
    assert run.error is None
    assert [len(m.read_text().splitlines()) for m in markers] == [1, 1, 1], "nothing is computed twice"
    assert caplog.text.count("cannot go on") == 1, "the same trouble is logged once"
    assert "Traceback" not in caplog.text
    assert run.result_sha256 == house.wait(house.queue({}, {}, {}), "succeeded").result_sha256


def test_a_failure_is_written_down_later(house: House, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    marker = tmp_path / "starts"
    run_id = house.queue({"behaviour": "fail", "seconds": 1.0, "marker": str(marker)})
    wait_for(marker.exists, "the algorithm runs")
    with locked(house.settings.data_dir):
        wait_for(lambda: "cannot go on" in caplog.text, "it is logged", 10)
        assert house.run(run_id).state == "running"
    run = house.wait(run_id, "succeeded", "failed")
    assert run.error is not None
    assert run.error["code"] == "singular"


@pytest.mark.parametrize("readable", [True, False])
def test_a_recording_is_read_again_until_its_outcome_can_be_written(house: House, readable: bool) -> None:
    data = (MARKS if readable else "nothing that anybody could read").encode()
    with house.store.guard(), house.database.write() as connection:
        sha256 = house.store.put_bytes(data)
        recording = recordings.create_recording(
            connection,
            name="marks",
            sha256=sha256,
            fingerprint=hashlib.sha256(data).hexdigest(),
            files=[recordings.StoredFile("data", "marks.csv", sha256, len(data))],
            options={},
        )
    with locked(house.settings.data_dir):
        reading = house.engine.read_recording(recording.id)
        with pytest.raises(TimeoutError):
            reading.result(4)
    done = reading.result(30)
    assert done.state == ("ready" if readable else "failed")
    assert (done.error is None) == readable


def test_the_server_says_so_and_goes_on(tmp_path: Path) -> None:
    server = start_server(tmp_path / "data", "--no-samples", "--workers", "1")

    def upload() -> httpx2.Response:
        return client.post("/api/v1/recordings", files=[("file", ("marks.csv", MARKS.encode(), "text/csv"))])

    try:
        with server.client() as client:
            with locked(server.data):
                answer = upload()
                problem(answer, 503, "database_locked")
                assert int(answer.headers["retry-after"]) > 0
                assert client.get("/api/v1/recordings").json()["items"] == [], "reading goes on"
            assert upload().status_code == 201
    finally:
        assert server.stop() == 0
    assert "Traceback" not in server.log.read_text()
