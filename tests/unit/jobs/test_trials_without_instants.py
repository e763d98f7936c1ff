"""An algorithm that gives one answer for each trial: metrics and comparisons, no curves, and studies that judge it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from algorithms.recording import ToaMarks
from algorithms.registry import scenarios_by_name
from algorithms.result import Metric, Output, Result, Table
from algorithms.scores import Sample, Scores, Tally
from algorithms.spec import Algorithm, Parameters, Reference, RunContext, parameter
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict
from algorithms.toolbox.monte_carlo.batches import BATCH
from backend.db.runs import Entry
from backend.jobs import trial_results, work
from backend.jobs.gathering import gathered
from backend.jobs.ledger import trials_block
from backend.jobs.outcome import block_arrays
from backend.jobs.plan import TrialsPlan, trials_plan

TRIALS = 2 * BATCH + 6
CLAIM = Claim("1", "half of the first pulses are late", "0.5")


class Threshold(Parameters):
    late_m: float = parameter(0.0, title="Late from")


def first_errors(recording: ToaMarks) -> np.ndarray:
    """(L,) m: how much later the first pulse came at the first station than its neighbours of other trials."""
    toa = recording.toa_s[0, 0]
    assert recording.site is not None
    distance = np.linalg.norm(recording.truth_m[0] - recording.site.station_positions()[0])
    late: np.ndarray = toa * 299_792_458.0 - distance
    return late


def run(recording: ToaMarks, parameters: Threshold, context: RunContext) -> Result:
    return Result({"late_m": first_errors(recording)})


def score(recording: ToaMarks, parameters: Threshold, context: RunContext) -> Scores:
    error = first_errors(recording)
    late = (error > parameters.late_m).astype(float)
    tally = Tally("probability_late", "1", late, np.ones_like(late), compared=True, share=True)
    return Scores((tally,), (Sample("late_m", "m", error.astype(np.float32)),))


def tabulate(recording: ToaMarks, result: Result) -> dict[str, Table]:
    return {"decisions": Table({"row": recording.row[:1], "distance": result.arrays["late_m"][:1]})}


def measure(recording: ToaMarks, result: Result) -> list[Metric]:
    return []


def judge(found: StudyRun) -> Sequence[Verdict]:
    share = found.metric("probability_late", "late")
    word = "reproduced" if share.low <= 0.5 <= share.high else "not"
    return (Verdict(CLAIM, share.value, "1", word, "Counted.", share.low, share.high),)  # type: ignore[arg-type]


ALGORITHM = Algorithm(
    name="late",
    title="Late",
    summary="Says whether the first pulse was late.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=Threshold,
    outputs=(Output("late_m", ("trial",), "m"),),
    charts=(),
    references=(),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
STUDY = Study(
    name="late_first",
    title="Late",
    summary="Late.",
    family="multilateration",
    paper=Reference("chugunov2023"),
    item="1",
    scenario="four_station_circuit",
    entries=(StudyEntry("late", "late"),),
    claims=(CLAIM,),
    judge=judge,
)


@pytest.fixture
def plan() -> TrialsPlan:
    declared = {"preset": "four_station_circuit", "parameters": {"duration_s": 3.0, "legs": []}}
    entries = [Entry("late", "late", {}), Entry("late", "later", {"late_m": 3.0})]
    return trials_plan(declared, entries, {}, trials=TRIALS, batches_per_task=1, keep_every=1)


@pytest.fixture
def blocks(plan: TrialsPlan, monkeypatch: pytest.MonkeyPatch) -> dict[int, Any]:
    monkeypatch.setattr(work, "algorithms_by_name", lambda: {"late": ALGORITHM})
    monkeypatch.setattr(trial_results, "studies_by_name", lambda: {STUDY.name: STUDY})
    out = {}
    for position in range(plan.size):
        outcome = work.run_block(trials_block(plan, position, token="t", seed=3), lambda _: None)
        assert outcome.kind == "done", outcome.trace
        out[position] = block_arrays(outcome)
    return out


def rows(composed: Any, name: str) -> list[dict[str, Any]]:
    (table,) = (t for t in composed.tables if t.name == name)
    return [dict(zip([n for n, _ in table.columns], row, strict=True)) for row in table.rows]


def test_metrics_comparisons_and_claims_without_a_single_instant(plan: TrialsPlan, blocks: dict[int, Any]) -> None:
    composed = trial_results.compose(gathered(plan, blocks), STUDY.name)
    whole = scenarios_by_name()["four_station_circuit"]
    recording = whole.simulate(whole.parameters(duration_s=3.0, legs=[]), tuple(range(TRIALS)), 3)
    late = first_errors(recording)  # type: ignore[arg-type]
    found = {(r["metric"], r["label"]): r for r in rows(composed, "metrics")}
    assert found["probability_late", "late"]["value"] == pytest.approx((late > 0).mean())
    assert found["probability_late", "later"]["value"] == pytest.approx((late > 3).mean())
    assert found["median_late_m", "late"]["value"] == pytest.approx(np.median(late), abs=0.2)
    assert found["probability_late", "late"]["n"] == TRIALS
    (pair,) = rows(composed, "comparisons")
    assert abs(pair["difference"]) == pytest.approx((late > 0).mean() - (late > 3).mean())
    (claim,) = rows(composed, "claims")
    assert claim["verdict"] == "reproduced"
    assert not [name for name in composed.arrays if name.startswith("tables/curves/")]
    assert [entry["tables"] for entry in composed.entries] == [{"decisions": 1}, {"decisions": 1}]


def test_a_live_run_has_no_curves_either(plan: TrialsPlan, blocks: dict[int, Any]) -> None:
    composed = trial_results.compose(gathered(plan, {p: blocks[p] for p in blocks}))
    assert composed.summary["probability_late"].keys() == {"late", "later"}
    statistics = gathered(plan, blocks).statistics
    assert trial_results.curves_of(plan, statistics, {}) is None
