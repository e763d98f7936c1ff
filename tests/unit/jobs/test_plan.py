"""Into which blocks a stored run is cut: what was queued by an earlier version goes on with the same blocks."""

from __future__ import annotations

from dataclasses import replace

from backend.jobs.plan import TrialsPlan, plan_of
from tests.unit.jobs.test_schedule import active


def cut(**more: object) -> tuple[tuple[int, int], ...]:
    source = {"scenario": {"preset": "four_station_circuit"}, "batches_per_task": 4, "keep_every": 1, **more}
    plan = plan_of(replace(active("a", 1).run, source=source, trials=300))
    assert isinstance(plan, TrialsPlan)
    return plan.tasks


def test_tasks_of_a_new_run_are_alike() -> None:
    assert cut(even_tasks=True) == ((0, 96), (96, 192), (192, 300))


def test_a_run_of_an_earlier_version_keeps_its_tasks() -> None:
    assert cut() == ((0, 128), (128, 256), (256, 300))
