"""Reading happens in a process of its own, which may die, hang, or grow too large."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest

from algorithms.recording import recording_from_arrays
from backend.db import recordings
from backend.db.engine import Database
from backend.db.migrate import upgrade
from backend.errors import StateError
from backend.files.store import Store
from backend.jobs.parsing import Parser
from backend.jobs.reader_process import ReaderProcess, ReadRequest
from backend.settings import Settings
from tests.recovery.conftest import wait_for

pytestmark = pytest.mark.recovery
MARKS = "time_s,toa_A_ns,toa_B_ns,altitude_m\n" + "".join(f"{i},{100 + i},{200 + i},8000\n" for i in range(20))
BAD_ROW = "x,1,2,3\n"
SPAWN = """
import sys
from backend.jobs.reader_process import ReaderProcess
if __name__ == "__main__":
    reader = ReaderProcess(2**30, 60)
    reader._started()
    print(reader.pid, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def reader() -> Iterator[ReaderProcess]:
    reader = ReaderProcess(memory_bytes=2**30, timeout_s=60)
    yield reader
    reader.stop()


def request(tmp_path: Path, text: str) -> ReadRequest:
    path = tmp_path / "upload"
    path.write_text(text)
    return ReadRequest((("marks.csv", path),), None, None, {}, 1000, tmp_path / "out.npz")


def test_facts_and_arrays_come_back(reader: ReaderProcess, tmp_path: Path) -> None:
    answer = reader.read(request(tmp_path, MARKS + BAD_ROW))
    assert answer.error is None
    assert (answer.kind, answer.rows_read, answer.rows_accepted) == ("toa_marks", 21, 20)
    assert [r[0] for r in answer.rejections] == [21]
    with np.load(tmp_path / "out.npz") as arrays:
        recording = recording_from_arrays(arrays)
    assert len(recording) == 20


def test_an_unreadable_file_is_an_error_with_a_pointer(reader: ReaderProcess, tmp_path: Path) -> None:
    answer = reader.read(request(tmp_path, "nothing that anybody could read"))
    assert answer.error is not None
    assert answer.error["pointer"] == "/file"
    assert answer.error["detail"]
    pid = reader.pid
    assert reader.read(request(tmp_path, MARKS)).error is None
    assert reader.pid == pid


def test_a_dead_process_is_replaced(reader: ReaderProcess, tmp_path: Path) -> None:
    reader.read(request(tmp_path, MARKS))
    assert reader.pid is not None
    os.kill(reader.pid, signal.SIGSTOP)
    with ThreadPoolExecutor(1) as thread:
        reading = thread.submit(reader.read, request(tmp_path, MARKS))
        time.sleep(0.2)
        os.kill(reader.pid, signal.SIGKILL)
        answer = reading.result(10)
    assert answer.error is not None
    assert answer.error["code"] == "reader_died"
    assert reader.read(request(tmp_path, MARKS)).error is None


def test_a_hanging_process_is_stopped(tmp_path: Path) -> None:
    reader = ReaderProcess(memory_bytes=2**30, timeout_s=60)
    reader.read(request(tmp_path, MARKS))
    reader._timeout_s = 0.3
    pid = reader.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    answer = reader.read(request(tmp_path, MARKS))
    assert answer.error is not None
    assert answer.error["code"] == "reader_timeout"
    assert not psutil.pid_exists(pid)
    reader.stop()


def test_memory_is_limited(tmp_path: Path) -> None:
    reader = ReaderProcess(memory_bytes=2**24, timeout_s=60)
    large = request(tmp_path, MARKS.splitlines()[0] + "\n" + "1,2,3,4\n" * 3_000_000)
    answer = reader.read(replace(large, max_rows=10**7))
    reader.stop()
    assert answer.error is not None
    assert answer.error["code"] in ("reader_memory", "reader_died")


def test_the_process_ends_with_the_server(tmp_path: Path) -> None:
    script = tmp_path / "server.py"
    script.write_text(SPAWN)
    root = Path(__file__).parents[2]
    with subprocess.Popen(
        [sys.executable, str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(root)},
    ) as server:
        assert server.stdout is not None
        child = psutil.Process(int(server.stdout.readline()))
        server.kill()
        server.wait()
        wait_for(lambda: not child.is_running() or child.status() == psutil.STATUS_ZOMBIE, "the reader ended", 10)


class TestParser:
    @pytest.fixture
    def parts(self, tmp_path: Path) -> Iterator[tuple[Database, Store, Parser]]:
        settings = Settings(data_dir=tmp_path)
        database, store = Database(settings.url), Store(settings.store_dir)
        upgrade(database)
        parser = Parser(database, store, settings)
        yield database, store, parser
        parser.stop()
        database.close()

    def upload(self, database: Database, store: Store, text: str) -> str:
        with store.guard():
            sha256 = store.put_bytes(text.encode())
            with database.write() as connection:
                return recordings.create_recording(
                    connection,
                    name="marks",
                    sha256=sha256,
                    fingerprint=sha256,
                    files=[recordings.StoredFile("data", "marks.csv", sha256, len(text))],
                    options={},
                ).id

    def test_a_recording_becomes_ready(self, parts: tuple[Database, Store, Parser]) -> None:
        database, store, parser = parts
        recording_id = self.upload(database, store, MARKS + BAD_ROW)
        reading = parser.parse(recording_id)
        assert parser.parse(recording_id) is reading, "it is read once"
        recording = reading.result(60)
        assert (recording.state, recording.rows_accepted, recording.rows_rejected) == ("ready", 20, 1)
        assert recording.data_sha256 is not None
        assert len(recording_from_arrays(store.get_arrays(recording.data_sha256))) == 20
        assert list(store.temporary().parent.iterdir()) == []
        with database.read() as connection:
            assert recordings.list_rejections(connection, recording.id)[0].row == 21

    def test_or_failed_with_the_reason(self, parts: tuple[Database, Store, Parser]) -> None:
        database, store, parser = parts
        recording = parser.parse(self.upload(database, store, "no measurements")).result(60)
        assert recording.state == "failed"
        assert recording.error is not None
        assert recording.error["detail"]

    def test_what_a_stopped_server_left_is_read_by_the_next(self, parts: tuple[Database, Store, Parser]) -> None:
        database, store, parser = parts
        recording_id = self.upload(database, store, MARKS)
        parser.resume()

        def ready() -> bool:
            with database.read() as connection:
                return recordings.get_recording(connection, recording_id).state == "ready"

        wait_for(ready, "the recording is ready")

    def test_a_stop_leaves_the_recording_for_the_next_server(self, parts: tuple[Database, Store, Parser]) -> None:
        database, store, parser = parts
        recording_id = self.upload(database, store, MARKS)
        reading = parser.parse(recording_id)
        pid = wait_for(lambda: parser.pid, "the process is there")
        os.kill(pid, signal.SIGSTOP)
        parser.stop()
        with pytest.raises(StateError, match="stopping"):
            reading.result(10)
        with database.read() as connection:
            assert recordings.get_recording(connection, recording_id).state == "parsing"
