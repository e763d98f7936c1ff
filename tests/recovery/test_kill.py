"""Kill -9 of the server: nothing is lost, nothing is computed twice, no process stays behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil
import pytest

from backend.db import events, outcomes
from backend.errors import StateError
from backend.files.lock import DataFolderLock
from tests.recovery.conftest import PLUGIN, House, settle, wait_for

pytestmark = pytest.mark.recovery
SCRIPT = Path(__file__).parent / "server_process.py"


@contextmanager
def server(house: House, *entries: dict[str, Any]) -> Iterator[subprocess.Popen[str]]:
    """A server process on the data folder; its first line of output is read by the caller."""
    root = Path(__file__).parents[2]
    process = subprocess.Popen(
        [sys.executable, str(SCRIPT), str(house.settings.data_dir), json.dumps(entries)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=root,
        env={**os.environ, "PYTHONPATH": f"{root}{os.pathsep}{PLUGIN}"},
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def family(process: subprocess.Popen[str]) -> list[psutil.Process]:
    return psutil.Process(process.pid).children(recursive=True)


def gone(processes: list[psutil.Process]) -> bool:
    return all(not p.is_running() or p.status() == psutil.STATUS_ZOMBIE for p in processes)


def test_a_killed_server_goes_on_with_the_rest(plugin: None, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    house = settle(tmp_path / "data")
    markers = [tmp_path / f"starts {i}" for i in range(3)]
    entries = [{"marker": str(m), "seconds": s} for m, s in zip(markers, (0.0, 0.0, 5.0), strict=True)]
    with server(house, *entries) as process:
        run_id = first_line(process)

        def finished() -> dict[int, str]:
            with house.database.read() as connection:
                return outcomes.finished_blocks(connection, run_id)

        wait_for(lambda: set(finished()) == {0, 1} and markers[2].exists(), "the third of three blocks", 120)
        children = family(process)
        assert len(children) >= 2
        process.kill()
        process.wait()
        wait_for(lambda: gone(children), "no process stays behind", 10)
    assert house.run(run_id).state == "running"
    kept = finished()

    request.addfinalizer(house.engine.stop)
    house.engine.start()
    assert house.run(run_id).state in ("queued", "running")
    run = house.wait(run_id, "succeeded", "failed")
    assert run.state == "succeeded"
    assert [len(m.read_text().splitlines()) for m in markers] == [1, 1, 2]
    with house.database.read() as connection:
        log = [line.text for line in events.log_lines(connection, run_id)]
    assert "Goes on after a restart of the server: 2 of 3 algorithms are finished already." in log
    assert not any(house.store.path(sha256).exists() for sha256 in kept.values())

    undisturbed = house.wait(house.queue({}, {}, {}), "succeeded")
    assert undisturbed.result_sha256 == run.result_sha256


def test_killed_while_starting_leaves_no_process_and_no_lock(tmp_path: Path) -> None:
    house = settle(tmp_path / "data")
    with server(house) as process:
        assert first_line(process) == "started"
        with pytest.raises(StateError, match=str(process.pid)):
            DataFolderLock(house.settings.data_dir).acquire()
        wait_for(lambda: family(process), "the first worker is there", 30)
        children = family(process)
        process.kill()
        process.wait()
        wait_for(lambda: gone(children), "no process stays behind", 10)
    with DataFolderLock(house.settings.data_dir):
        pass
    house.database.close()


def test_an_interrupt_reaches_no_worker_and_a_graceful_stop_leaves_none(tmp_path: Path) -> None:
    """Ctrl-C in a terminal: the workers neither die nor print; the server ends them."""
    house = settle(tmp_path / "data")
    with server(house, {"seconds": 60.0}) as process:
        run_id = first_line(process)
        house.wait(run_id, "running", "failed")
        workers = [p for p in family(process) if "spawn_main" in " ".join(p.cmdline())]
        assert len(workers) == 2
        for worker in workers:
            worker.send_signal(signal.SIGINT)
        time.sleep(0.5)
        assert not any(gone([worker]) for worker in workers)
        children = family(process)
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(timeout=20) == 0
        wait_for(lambda: gone(children), "no process stays behind", 5)
    assert house.run(run_id).state == "running"
    house.database.close()
