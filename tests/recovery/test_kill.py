"""Kill -9 of the real server: nothing is lost, nothing is computed twice, no process stays behind."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import psutil
import pytest

from backend.db import events, outcomes
from backend.errors import StateError
from backend.files.lock import DataFolderLock
from tests.recovery.conftest import settle, wait_for
from tests.recovery.served import gone, server

pytestmark = pytest.mark.recovery
ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_a_killed_server_goes_on_with_the_rest(tmp_path: Path) -> None:
    house = settle(tmp_path / "data")
    markers = [tmp_path / f"starts {i}" for i in range(3)]
    entries = [{"marker": str(m), "seconds": s} for m, s in zip(markers, (0.0, 0.0, 5.0), strict=True)]

    def finished() -> dict[int, str]:
        with house.database.read() as connection:
            return outcomes.finished_blocks(connection, run_id)

    with server(house) as first:
        run_id = first.queue(*entries)
        wait_for(lambda: set(finished()) == {0, 1} and markers[2].exists(), "the third of three blocks", 120)
        first.kill()
    kept = finished()
    assert house.run(run_id).state == "running"

    with server(house) as second:
        undisturbed = second.queue({}, {}, {})
        run = house.wait(run_id, "succeeded", "failed")
        assert run.state == "succeeded"
        assert [len(m.read_text().splitlines()) for m in markers] == [1, 1, 2]
        assert house.wait(undisturbed, "succeeded").result_sha256 == run.result_sha256
        # Inside: a server that ends between a run's last commit and the collection leaves it to the next start.
        wait_for(lambda: not any(house.store.path(sha256).exists() for sha256 in kept.values()), "blocks collected")
    with house.database.read() as connection:
        log = [line.text for line in events.log_lines(connection, run_id)]
    assert "Goes on after a restart of the server: 2 of 3 algorithms are finished already." in log
    house.database.close()


@pytest.mark.slow
def test_killed_while_its_workers_start(tmp_path: Path) -> None:
    house = settle(tmp_path / "data")
    with server(house) as first:
        with pytest.raises(StateError, match=str(first.process.pid)):
            DataFolderLock(house.settings.data_dir).acquire()
        queued = first.queue({"seconds": 30})
        wait_for(first.family, "the first worker is there", 30)
        first.kill()
    with DataFolderLock(house.settings.data_dir):
        assert house.run(queued).state in ("queued", "running")
    house.database.close()


@pytest.mark.slow
def test_an_interrupt_reaches_no_worker_and_a_graceful_stop_leaves_none(tmp_path: Path) -> None:
    """Ctrl-C in a terminal: the workers neither die nor print; the server ends them."""
    house = settle(tmp_path / "data")
    marker = tmp_path / "starts"
    with server(house) as running:
        run_id = running.queue({"seconds": 60.0, "marker": str(marker)})
        wait_for(marker.exists, "the algorithm runs", 120)
        worker = psutil.Process(int(marker.read_text()))
        worker.send_signal(signal.SIGINT)
        time.sleep(0.5)
        assert not gone([worker])
        children = running.family()
        running.process.terminate()
        assert running.process.wait(timeout=20) == 0
        wait_for(lambda: gone(children), "no process stays behind", 5)
    assert house.run(run_id).state == "running"
    assert len(marker.read_text().splitlines()) == 1
    house.database.close()
