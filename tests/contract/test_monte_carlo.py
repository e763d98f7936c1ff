"""Every algorithm on every scenario of its kind: the same bytes however trials are cut, honest sums, cancel heard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.registry import algorithms_by_name, scenarios_by_name, studies_by_name
from algorithms.result import Table
from algorithms.spec import Algorithm, LocalContext, Scenario
from algorithms.studies import Study
from algorithms.toolbox.monte_carlo.batches import BATCH, tasks
from backend.db.runs import Entry
from backend.jobs import trial_results, work
from backend.jobs.gathering import gathered
from backend.jobs.ledger import trials_block
from backend.jobs.outcome import block_arrays
from backend.jobs.plan import TrialsPlan, trials_plan

# One of each family and kind: the first.
SCENARIOS = list({(s.family, s.kind): s for s in reversed(scenarios_by_name().values())}.values())
PAIRS = [
    pytest.param(a, s, id=f"{a.name}-{s.name}")
    for s in SCENARIOS
    for a in algorithms_by_name().values()
    if a.score is not None and s.kind in a.takes and s.family == a.family
]
TRIALS = BATCH + 6
SEED = 5


def short(scenario: Scenario) -> dict[str, Any]:
    """Parameters of a scenario of some dozen instants, where it can be made short."""
    return {"duration_s": 24.0, "legs": []} if "duration_s" in scenario.parameters.model_fields else {}


def plan_of(algorithm: Algorithm, scenario: Scenario, batches: int) -> TrialsPlan:
    entries = [Entry(algorithm.name, algorithm.name, {})]
    declared = {"preset": scenario.name, "parameters": short(scenario)}
    return trials_plan(declared, entries, {}, trials=TRIALS, batches_per_task=batches, keep_every=1)


def blocks_of(plan: TrialsPlan) -> dict[int, Any]:
    out = {}
    for position in range(plan.size):
        outcome = work.run_block(trials_block(plan, position, token="t", seed=SEED), lambda _: None)
        assert outcome.kind == "done", (outcome.error, outcome.trace)
        out[position] = block_arrays(outcome)
    return out


@pytest.fixture(scope="module")
def composed() -> Callable[[Algorithm, Scenario], Any]:
    known: dict[tuple[str, str], Any] = {}

    def compose(algorithm: Algorithm, scenario: Scenario) -> Any:
        key = (algorithm.name, scenario.name)
        if key not in known:
            plan = plan_of(algorithm, scenario, 2)
            known[key] = trial_results.compose(gathered(plan, blocks_of(plan)))
        return known[key]

    return compose


@pytest.mark.parametrize(("algorithm", "scenario"), PAIRS)
def test_the_same_bytes_under_another_cut(
    algorithm: Algorithm, scenario: Scenario, composed: Callable[..., Any]
) -> None:
    plan = plan_of(algorithm, scenario, 1)
    assert list(plan.tasks) == tasks(TRIALS, 1)
    fine, coarse = trial_results.compose(gathered(plan, blocks_of(plan))), composed(algorithm, scenario)
    assert fine.arrays.keys() == coarse.arrays.keys()
    for name, array in coarse.arrays.items():
        assert np.asarray(array).tobytes() == np.asarray(fine.arrays[name]).tobytes(), name
    assert fine.tables == coarse.tables
    assert fine.summary == coarse.summary


@pytest.mark.parametrize(("algorithm", "scenario"), PAIRS)
def test_metrics_hold_their_intervals_and_shares_are_shares(
    algorithm: Algorithm, scenario: Scenario, composed: Callable[..., Any]
) -> None:
    (metrics,) = (t for t in composed(algorithm, scenario).tables if t.name == "metrics")
    names = [name for name, _ in metrics.columns]
    rows = [dict(zip(names, row, strict=True)) for row in metrics.rows]
    assert rows
    for row in rows:
        if row["ci95_low"] is not None and row["value"] is not None:
            assert row["ci95_low"] <= row["value"] <= row["ci95_high"], row
        if row["metric"].endswith("_share") and row["value"] is not None:
            assert 0 <= row["value"] <= 1, row


@pytest.mark.parametrize(("algorithm", "scenario"), PAIRS)
def test_a_trial_scores_the_same_alone_and_among_others(algorithm: Algorithm, scenario: Scenario) -> None:
    assert algorithm.score is not None
    conditions = scenario.parameters(**short(scenario))
    parameters = algorithm.parameters()
    many = algorithm.score(scenario.simulate(conditions, (3, 4, 5), SEED), parameters, LocalContext(SEED, 3))
    one = algorithm.score(scenario.simulate(conditions, (4,), SEED), parameters, LocalContext(SEED, 4))
    for tally, alone in zip(many.tallies, one.tallies, strict=True):
        assert np.array_equal(tally.numerator[..., 1], alone.numerator[..., 0]), tally.metric
        assert (tally.denominator >= 0).all(), tally.metric
        assert np.isfinite(tally.numerator).all(), tally.metric
    assert (np.diff(many.time_s) >= 0).all()


@pytest.mark.parametrize(("algorithm", "scenario"), PAIRS)
def test_a_bound_is_a_length_at_every_instant(algorithm: Algorithm, scenario: Scenario) -> None:
    if algorithm.bound is None:
        pytest.skip("declares no bound")
    recording = scenario.simulate(scenario.parameters(**short(scenario)), (0, 1), SEED)
    bound = algorithm.bound(recording, algorithm.parameters())
    assert bound is None or (bound.shape == recording.time_s.shape and (bound[np.isfinite(bound)] > 0).all())


def test_a_cancelled_block_of_trials_stops_between_batches() -> None:
    algorithm, scenario = PAIRS[0].values
    plan = plan_of(algorithm, scenario, 2)
    work.cancel(["gone"])
    assert work.run_block(trials_block(plan, 0, token="gone", seed=SEED), lambda _: None).kind == "cancelled"


@pytest.mark.parametrize("study", list(studies_by_name().values()), ids=lambda s: s.name)
def test_a_study_names_what_exists(study: Study) -> None:
    assert study.scenario in scenarios_by_name()
    kind = scenarios_by_name()[study.scenario].kind
    scenarios_by_name()[study.scenario].parameters.model_validate(dict(study.scenario_parameters))
    labels = [e.label for e in study.entries]
    assert len(set(labels)) == len(labels)
    for entry in study.entries:
        algorithm = algorithms_by_name()[entry.name]
        assert kind in algorithm.takes
        algorithm.parameters.model_validate(dict(entry.parameters))
    for name in study.sweep:
        owner, _, parameter = name.rpartition(".")
        model = scenarios_by_name()[study.scenario].parameters if owner == "scenario" else None
        if model is None:
            (entry,) = (e for e in study.entries if e.label == owner)
            model = algorithms_by_name()[entry.name].parameters
        assert parameter in model.model_fields
    assert study.claims


def test_a_table_of_a_cell_survives_the_file(composed: Callable[..., Any]) -> None:
    algorithm, scenario = PAIRS[0].values
    arrays = composed(algorithm, scenario).arrays
    curves = Table.from_arrays(arrays, f"tables/curves/{algorithm.name}")
    assert {"target", "time_s", "trials", "bound_horizontal_m"} <= set(curves.names)
    assert replace(curves) == curves


def test_cells_of_different_length_keep_their_values_and_thinning_is_told() -> None:
    algorithm, scenario = algorithms_by_name()["rdf"], scenarios_by_name()["four_station_circuit"]
    entries = [Entry(algorithm.name, algorithm.name, {})]
    plan = trials_plan(
        {"preset": scenario.name, "parameters": {"legs": []}}, entries, {"scenario.duration_s": [12.0, 24.0]},
        trials=3, batches_per_task=1, keep_every=2,
    )  # fmt: skip
    composed = trial_results.compose(gathered(plan, blocks_of(plan)))
    kept = [composed.arrays[f"{algorithm.name}/trials/horizontal_m/{i}"].shape for i in range(2)]
    assert kept == [(7, 3), (13, 3)]
    assert [len(composed.arrays[f"{algorithm.name}/trials/kept_time_s/{i}"]) for i in range(2)] == [7, 13]
    assert [n["code"] for n in composed.entries[0]["notes"]].count("quantiles_thinned") == 1
