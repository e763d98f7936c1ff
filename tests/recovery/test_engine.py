"""Runs on real workers: what comes out, and what happens when a block fails, hangs, or takes its worker along."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from backend.db import events, outcomes, recordings, runs
from backend.errors import StateError
from backend.jobs import results
from tests.recovery.conftest import House, wait_for

pytestmark = pytest.mark.recovery


def log(house: House, run_id: str) -> str:
    with house.database.read() as connection:
        return "\n".join(line.text for line in events.log_lines(connection, run_id))


def test_a_run_leaves_arrays_tables_metrics_and_a_summary(house: House) -> None:
    run = house.wait(house.queue({"seconds": 0.7}, {}), "succeeded", "failed")
    assert run.error is None
    assert run.state == "succeeded"
    assert (run.progress_done, run.progress_total) == (200, 200)
    arrays = results.load_arrays(house.store, run)
    draw = np.random.default_rng(np.random.SeedSequence(entropy=7, spawn_key=(0, 0))).standard_normal(5) + np.arange(5)
    np.testing.assert_array_equal(arrays["entry 0/draw"], draw)
    np.testing.assert_array_equal(results.load_entry_arrays(house.store, run, "entry 1")["draw"], draw)
    states = results.load_table(house.database, house.store, run, "states")
    assert states.names == ("label", "row", "nis", "status")
    assert list(states.columns["label"]) == ["entry 0"] * 5 + ["entry 1"] * 5
    tracks = results.load_table(house.database, house.store, run, "tracks")
    assert list(tracks.rows()) == [("entry 0", 1, None, None), ("entry 1", 1, None, None)]
    one = results.load_entry_table(house.database, house.store, run, "entry 1", "tracks")
    assert list(one.rows()) == [(1, None, None)]
    metrics = results.load_table(house.database, house.store, run, "metrics")
    assert metrics.names[:5] == ("metric", "label", "segment", "target", "value")
    assert len(metrics) == 6
    assert run.summary is not None
    assert run.summary["nis"]["entry 0"] == {"value": pytest.approx(draw.mean()), "ci95": [0.5, 1.5], "unit": ""}
    assert run.summary["rms_up_m"]["entry 1"] == {"value": None, "ci95": None, "unit": "m"}
    assert results.table_names(house.database, run) == {"metrics": 6, "states": 10, "tracks": 2}
    assert run.entries is not None
    assert run.entries[0]["settings"] == {
        "seconds": {"value": 0.7, "source": "run"},
        "nothing": {"value": None, "source": "default"},
    }
    assert run.software is not None
    assert set(run.software) == {"filterroom", "numpy", "numba", "python", "cpu"}
    assert "Only a rehearsal." in log(house, run.id)


def test_the_same_inputs_give_the_same_bytes(house: House) -> None:
    first, second, other = house.queue({}), house.queue({"seconds": 0.2}), house.queue({}, seed=8)
    hashes = [house.wait(r, "succeeded").result_sha256 for r in (first, second, other)]
    assert hashes[0] == hashes[1]
    assert hashes[0] != hashes[2]


def test_finished_blocks_do_not_stay_beside_the_result(house: House) -> None:
    run = house.wait(house.queue({}, {}), "succeeded")
    with house.database.read() as connection:
        assert outcomes.finished_blocks(connection, run.id) == {}
        recording = recordings.get_recording(connection, house.recording_id)
    wait_for(lambda: len(list(house.store.hashes())) <= 5, "blocks collected", 5)
    assert recording.data_sha256 in set(house.store.hashes())


def test_progress_is_announced_and_not_too_often(house: House) -> None:
    with house.database.read() as connection:
        after = events.last_event_id(connection)
    seen: dict[int, int] = {}

    def look() -> None:
        with house.database.read() as connection:
            for e in events.events_after(connection, after):
                if e.kind == "run.progress":
                    seen[e.id] = e.data["done"]

    stop = house.database.listen(look)
    house.wait(house.queue({"seconds": 1.5}), "succeeded")
    stop()
    assert 3 <= len(seen) <= 8
    assert list(seen.values()) == sorted(seen.values())


def test_an_error_of_the_method_fails_the_run_with_its_label(house: House) -> None:
    run = house.wait(house.queue({"seconds": 30}, {"behaviour": "fail"}), "failed")
    assert run.error == {
        "code": "singular",
        "detail": "The geometry is singular.",
        "remedy": "Add a station.",
        "label": "entry 1",
        "time_s": 3.0,
        "track": None,
    }
    assert "entry 1: The geometry is singular. Add a station." in log(house, run.id)
    # The other algorithm was stopped: both workers are free at once.
    house.wait(house.queue({}, {}), "succeeded")


def test_a_bug_shows_its_traceback_in_the_log_only(house: House) -> None:
    run = house.wait(house.queue({"behaviour": "bug"}), "failed")
    assert run.error is not None
    assert run.error["code"] == "internal"
    assert "ZeroDivisionError" not in str(run.error)
    assert "ZeroDivisionError: nobody thought of this" in log(house, run.id)


def test_unknown_parameters_fail_with_a_pointer(house: House) -> None:
    run = house.wait(house.queue({"behaviour": "sing"}), "failed")
    assert run.error is not None
    assert run.error["pointer"] == "/parameters/behaviour"
    run = house.wait(house.queue({}, algorithm="nobody"), "failed")
    assert run.error is not None
    assert run.error["code"] == "unknown_algorithm"


def test_cancel_is_final_at_once_and_frees_the_workers(house: House, tmp_path: Path) -> None:
    marker = tmp_path / "starts"
    run_id = house.queue({"seconds": 60, "marker": str(marker)}, {"seconds": 60}, {"seconds": 60})
    house.wait(run_id, "running")
    wait_for(marker.exists, "the algorithm runs")
    assert house.engine.cancel(run_id)
    assert house.run(run_id).state == "cancelled"
    assert not house.engine.cancel(run_id)
    started = time.monotonic()
    succeeded = house.wait(house.queue({}, {}), "succeeded")
    assert time.monotonic() - started < 10
    assert house.run(run_id).state == "cancelled"
    with pytest.raises(StateError, match="succeeded"):
        house.engine.cancel(succeeded.id)


def test_a_queued_run_is_cancelled_without_a_worker(house: House) -> None:
    blocking = house.queue({"seconds": 30}, {"seconds": 30})
    house.wait(blocking, "running")
    queued = house.queue({}, {}, {})
    assert house.engine.cancel(queued)
    assert house.engine.cancel(blocking)
    assert house.run(queued).started_at is None


@pytest.mark.slow
def test_a_worker_that_hangs_is_restarted(house: House, tmp_path: Path) -> None:
    marker = tmp_path / "starts"
    run_id = house.queue({"behaviour": "hang", "seconds": 300, "marker": str(marker)})
    # The file is there before what is written into it.
    pid = int(wait_for(lambda: marker.exists() and marker.read_text(), "the algorithm runs"))
    house.engine.cancel(run_id)
    wait_for(lambda: not psutil.pid_exists(pid), "the hanging worker is gone", 15)
    wait_for(lambda: house.engine.status().workers == 2, "both workers are back")
    house.wait(house.queue({}, {}), "succeeded")
    assert marker.read_text().splitlines() == [str(pid)]


def test_a_block_whose_worker_died_is_computed_again(house: House, tmp_path: Path) -> None:
    run = house.wait(house.queue({"behaviour": "die_once", "marker": str(tmp_path / "m")}), "succeeded", "failed")
    assert run.state == "succeeded"
    assert "the worker died; it is computed again, alone" in log(house, run.id)


@pytest.mark.slow  # three workers die in turn
def test_a_deadly_block_fails_its_run_and_spares_the_others(house: House, tmp_path: Path) -> None:
    marker = tmp_path / "starts"
    deadly = house.queue({"behaviour": "die", "marker": str(marker)})
    others = [house.queue({"seconds": 0.3}) for _ in range(4)]
    run = house.wait(deadly, "failed")
    assert run.error is not None
    assert run.error["code"] == "worker_died"
    assert len(marker.read_text().splitlines()) == 3
    for other in others:
        done = house.wait(other, "succeeded", "failed")
        assert done.state == "succeeded", (done.error, log(house, other))


def test_a_late_run_does_not_wait_for_all_of_an_early_one(house: House) -> None:
    # A worker that another test killed comes back, and loads what it needs, before it can be of use to anybody.
    wait_for(lambda: house.engine.status().workers == 2, "both workers are back")
    house.wait(house.queue({"seconds": 0.3}, {"seconds": 0.3}), "succeeded")
    early = house.queue(*[{"seconds": 0.5}] * 8)
    house.wait(early, "running")
    late = house.wait(house.queue({}), "succeeded")
    assert house.run(early).state == "running"
    assert house.wait(early, "succeeded").finished_at > late.finished_at  # type: ignore[operator]


def test_status_counts(house: House) -> None:
    wait_for(lambda: house.engine.status().workers == 2, "workers that earlier tests killed are back")
    run_id = house.queue(*[{"seconds": 30}] * 3)
    house.wait(run_id, "running")
    waiting = house.queue({})
    status = house.engine.status()
    assert (status.state, status.workers) == ("ready", 2)
    # The second run gets a worker only when one of the first's blocks lands, and these take 30 s.
    assert (status.running, status.queued) == (1, 1)
    house.engine.cancel(run_id)
    house.wait(waiting, "succeeded")
    with house.database.read() as connection:
        assert runs.count_runs(connection, "running") == 0
