"""Kill -9 of the server while trials run, at twenty moments: the result is the undisturbed one, byte for byte."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest
from sqlalchemy import text

from backend.db import outcomes
from tests.recovery.conftest import House, settle, wait_for
from tests.recovery.served import server

pytestmark = [pytest.mark.recovery, pytest.mark.slow]
KILLS = 20
START = {"mode": "truth", "sd": [500, 50, 1]}
ENTRIES = [{"name": name, "parameters": {"profile": "article", "start": START}} for name in ("rdf", "rdfv")]


def body(trials: int) -> dict[str, object]:
    scenario = {"preset": "four_station_circuit"}
    return {"algorithms": ENTRIES, "scenario": scenario, "trials": trials, "seed": 3,
            "sweep": {"scenario.sigma_altitude_m": [30, 300]}}  # fmt: skip


def finished(house: House, run_id: str) -> set[int]:
    with house.database.read() as connection:
        return set(outcomes.finished_blocks(connection, run_id))


def another_block(house: House, run_id: str, before: set[int]) -> None:
    wait_for(lambda: finished(house, run_id) > before, "another block", 240)


def sound(house: House) -> bool:
    with house.database.read() as connection:
        return connection.execute(text("PRAGMA integrity_check")).scalar() == "ok"


def undisturbed(folder: Path, trials: int, workers: int) -> str:
    house = settle(folder)
    with server(house, workers) as one:
        run_id = one.start(body(trials))
        sha256 = wait_for(lambda: house.run(run_id).result_sha256, "the undisturbed run", 400)
        assert house.run(run_id).state == "succeeded", house.run(run_id).error
    house.database.close()
    return str(sha256)


def test_one_and_two_workers_give_the_same_bytes(tmp_path: Path) -> None:
    assert undisturbed(tmp_path / "one", 200, 1) == undisturbed(tmp_path / "two", 200, 2)


# Two minutes on a machine of its own; beside other work the twenty-one starts of a server take longest.
@pytest.mark.timeout(900)
def test_twenty_kills_at_any_moment_lose_and_double_nothing(tmp_path: Path) -> None:
    trials = 4_800
    house = settle(tmp_path / "data")
    moments = random.Random(20)
    with server(house) as first:
        run_id = first.start(body(trials))
        first.kill()
    done = finished(house, run_id)
    grown = 0
    for kill in range(1, KILLS):
        with server(house) as one:
            if kill % 2:
                # From its first breath to some time after the workers are there.
                time.sleep(moments.uniform(0, 3))
            else:
                # Whatever the machine is busy with: well inside the work, somewhere between two blocks.
                another_block(house, run_id, done)
                time.sleep(moments.uniform(0, 0.5))
            one.kill()
        now = finished(house, run_id)
        run = house.run(run_id)
        assert sound(house), kill
        assert run.state in ("queued", "running"), (kill, run.state, run.error)
        assert now >= done, "a finished block is not computed twice"
        grown += now > done
        done = now
    assert grown >= KILLS // 2 - 1, "kills hit a run that was being computed"
    with server(house):
        sha256 = wait_for(lambda: house.run(run_id).result_sha256, "the disturbed run", 400)
    assert house.run(run_id).state == "succeeded"
    assert finished(house, run_id) == set(), "its blocks are folded into the result"
    house.database.close()
    assert sha256 == undisturbed(tmp_path / "other", trials, 2)
