"""Studies of the multilateration paper through the pipeline that users run: the verdict of every claim."""

from __future__ import annotations

from typing import Any

import pytest

from algorithms.registry import studies_by_name
from backend.db.runs import Entry
from backend.jobs import trial_results, work
from backend.jobs.gathering import gathered
from backend.jobs.ledger import trials_block
from backend.jobs.outcome import block_arrays
from backend.jobs.plan import trials_plan


def claims_of(name: str, trials: int) -> dict[str, dict[str, Any]]:
    """Rows of the table `claims` by their statement."""
    study = studies_by_name()[name]
    scenario = {"preset": study.scenario, "parameters": dict(study.scenario_parameters)}
    entries = [Entry(e.name, e.label, dict(e.parameters)) for e in study.entries]
    sweep = {key: list(values) for key, values in study.sweep.items()}
    plan = trials_plan(scenario, entries, sweep, trials=trials, batches_per_task=2, keep_every=1)
    blocks = {}
    for position in range(plan.size):
        outcome = work.run_block(trials_block(plan, position, token="t", seed=study.seed), lambda _: None)
        assert outcome.kind == "done", (outcome.error, outcome.trace)
        blocks[position] = block_arrays(outcome)
    composed = trial_results.compose(gathered(plan, blocks), study=name)
    (table,) = (t for t in composed.tables if t.name == "claims")
    names = [column for column, _ in table.columns]
    rows = [dict(zip(names, row, strict=True)) for row in table.rows]
    assert [(r["figure"], r["claim"]) for r in rows] == [(c.figure, c.claim) for c in study.claims]
    return {f"{row['figure']}: {row['verdict']}": row for row in rows}


def test_the_printed_sign_is_positive_feedback() -> None:
    """Erratum E1: 327 km after ten marks, from 152 m."""
    found = claims_of("multilateration_printed_sign", 8)
    assert found["(19): not"]["value"] > 1e5


@pytest.mark.slow
def test_the_printed_gradient_and_what_formulas_decide() -> None:
    found = claims_of("multilateration_printed_gradient", 16)
    assert found["(26): not"]["value"] > 20e3
    # Table 8.5: 593 and 1223 m.
    assert found["2: shown"]["value"] == pytest.approx(1223 / 593, rel=2e-3)
    assert found["text: not"]["ci95_low"] == pytest.approx(0.6321, abs=5e-5)
    assert found["text: not"]["ci95_high"] == pytest.approx(0.6827, abs=5e-5)


@pytest.mark.slow
def test_figures_4_to_7() -> None:
    """Table 8.2: 0.71 of the runs beyond 5 km against none, medians 9 to 24 times smaller."""
    found = claims_of("multilateration_figures_4_to_7", 200)
    assert set(found) == {"4: partly", "5: shown", "6: reproduced", "7: reproduced", "conclusion: reproduced"}
    assert found["5: shown"]["value"] <= 0.4
    assert found["conclusion: reproduced"]["value"] == pytest.approx(0.71, abs=0.15)
    assert 9 <= found["7: reproduced"]["value"] <= 24


@pytest.mark.slow
def test_a_biased_altitude() -> None:
    """Table 8.4: the weave with 10 m and a bias of 300 m is four times worse than without altitude."""
    found = claims_of("multilateration_altitude_bias", 48)
    assert set(found) == {"conclusion: reproduced", "(13): partly", "(13): shown"}
    assert found["(13): partly"]["value"] == pytest.approx(95 / 380, rel=0.25)
    assert found["(13): shown"]["value"] > 1.5
