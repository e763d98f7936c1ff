"""What a study finds through the pipeline that users run, for the tests of papers."""

from __future__ import annotations

from typing import Any

from algorithms.registry import studies_by_name
from backend.db.runs import Entry
from backend.jobs import trial_results, work
from backend.jobs.gathering import gathered
from backend.jobs.ledger import trials_block
from backend.jobs.outcome import block_arrays
from backend.jobs.plan import trials_plan


def verdicts_of(name: str, trials: int) -> list[dict[str, Any]]:
    """Rows of the table `claims`."""
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
    return rows


def claims_of(name: str, trials: int) -> dict[str, dict[str, Any]]:
    """The same by figure and verdict."""
    return {f"{row['figure']}: {row['verdict']}": row for row in verdicts_of(name, trials)}
