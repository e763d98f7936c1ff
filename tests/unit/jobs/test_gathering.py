"""Blocks of trials gathered as they come are those gathered in order, whichever came first."""

from __future__ import annotations

import random

import pytest

from algorithms.registry import scenarios_by_name
from backend.db.runs import Entry
from backend.jobs import trial_results, work
from backend.jobs.gathering import Arrays, Gathering, gathered
from backend.jobs.ledger import trials_block
from backend.jobs.outcome import block_arrays
from backend.jobs.plan import TrialsPlan, trials_plan


@pytest.fixture(scope="module")
def plan() -> TrialsPlan:
    assert "duration_s" in scenarios_by_name()["four_station_circuit"].parameters.model_fields
    declared = {"preset": "four_station_circuit", "parameters": {"duration_s": 6.0, "legs": []}}
    sweep = {"scenario.sigma_altitude_m": [10.0, 300.0]}
    return trials_plan(declared, [Entry("rdfv", "rdfv", {})], sweep, trials=200, batches_per_task=1, keep_every=1)


@pytest.fixture(scope="module")
def blocks(plan: TrialsPlan) -> dict[int, Arrays]:
    outcomes = [work.run_block(trials_block(plan, p, token="t", seed=3), lambda _: None) for p in range(plan.size)]
    return {position: block_arrays(outcome) for position, outcome in enumerate(outcomes)}


def test_any_order_gives_the_same_bytes(plan: TrialsPlan, blocks: dict[int, Arrays]) -> None:
    expected = trial_results.compose(gathered(plan, blocks))
    for seed in range(3):
        gathering = Gathering(plan)
        order = list(blocks)
        random.Random(seed).shuffle(order)
        for k, position in enumerate(order):
            assert sorted(gathering.missing) == sorted(order[k:])
            gathering.add(position, blocks[position])
        assert gathering.missing == []
        gathering.add(0, blocks[0])
        found = trial_results.compose(gathering)
        assert found.tables == expected.tables
        assert all(found.arrays[name].tobytes() == array.tobytes() for name, array in expected.arrays.items())
