"""Which variants of a sweep are held against each other."""

from __future__ import annotations

from backend.db.runs import Entry
from backend.jobs.plan import trials_plan
from backend.jobs.trial_results import comparable


def test_variants_that_sweep_one_name_are_compared_at_the_same_value() -> None:
    entries = [Entry("window_estimator", label, {}) for label in ("a", "b")] + [Entry("imm_tracker", "c", {})]
    sweep = {"a.window_plots": [4, 8], "b.window_plots": [4, 8]}
    scenario = {"preset": "steady_motions", "parameters": {}}
    plan = trials_plan(scenario, entries, sweep, trials=2, batches_per_task=1, keep_every=1)
    found = {
        (x.label, *x.values.values(), y.label, *y.values.values())
        for i, x in enumerate(plan.variants)
        for y in plan.variants[i + 1 :]
        if comparable(x, y)
    }
    # Those of one label, those with as many plots, and everybody with what is not swept.
    assert found == {
        ("a", 4, "a", 8), ("b", 4, "b", 8), ("a", 4, "b", 4), ("a", 8, "b", 8),
        ("a", 4, "c"), ("a", 8, "c"), ("b", 4, "c"), ("b", 8, "c"),
    }  # fmt: skip
