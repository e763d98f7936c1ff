from __future__ import annotations

import datetime as dt
from collections import deque

import pytest

from backend.db.runs import Entry, Run
from backend.jobs.plan import plan_of
from backend.jobs.schedule import ActiveRun, Flight, choose


def active(name: str, blocks: int = 3, second: int = 0) -> ActiveRun:
    run = Run(
        id=name,
        state="running",
        label="",
        tags=(),
        created_at=dt.datetime(2026, 1, 1, 0, 0, second, tzinfo=dt.UTC),
        started_at=None,
        finished_at=None,
        source={},
        algorithms=tuple(Entry("a", f"a{i}", {}) for i in range(blocks)),
        seed=0,
        trials=1,
        progress_done=0,
        progress_total=100 * blocks,
        error=None,
        summary=None,
        entries=None,
        software=None,
        result_sha256=None,
    )
    return ActiveRun(run, plan_of(run), deque(range(blocks)), set())


def flight(run_id: str, position: int = 0, *, alone: bool = False) -> Flight:
    return Flight(f"{run_id}{position}", run_id, position, "w", None, alone)


def test_the_oldest_run_comes_first() -> None:
    choice = choose([active("b", second=1), active("a", second=0)], [])
    assert choice is not None
    assert (choice.active.run.id, choice.position, choice.alone) == ("a", 0, False)


def test_a_late_run_gets_the_next_worker_and_the_early_one_goes_on() -> None:
    early, late = active("a", second=0), active("b", second=1)
    choice = choose([early, late], [flight("a")])
    assert choice is not None
    assert choice.active is late
    choice = choose([early, late], [flight("a"), flight("b")])
    assert choice is not None
    assert choice.active is early


def test_nothing_waits() -> None:
    run = active("a")
    run.waiting.clear()
    assert choose([run], []) is None
    assert choose([], []) is None


def test_a_suspect_goes_alone() -> None:
    suspect, other = active("a"), active("b")
    suspect.deaths[1] = 1
    assert choose([other, suspect], [flight("b")]) is None, "first everything else must land"
    choice = choose([other, suspect], [])
    assert choice is not None
    assert (choice.active, choice.position, choice.alone) == (suspect, 1, True)
    assert choose([other, suspect], [flight("a", 1, alone=True)]) is None, "nothing flies beside it"


def test_progress_counts_finished_blocks_and_shares() -> None:
    run = active("a", blocks=4)
    run.finished = {0, 1}
    run.shares = {0: 0.3, 2: 0.5}
    assert run.done == pytest.approx(250)
    assert not run.is_complete
    run.finished = {0, 1, 2, 3}
    assert run.done == 400
    assert run.is_complete
