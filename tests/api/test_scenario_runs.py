"""Monte Carlo runs over HTTP: start, sweep, tables, the same bytes again, and what cannot start."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest

from tests.api import conftest
from tests.api.conftest import problem

START = {"mode": "truth", "sd": [500, 50, 1]}
SHORT = {"preset": "four_station_circuit", "parameters": {"duration_s": 59, "legs": [
    {"name": "first", "start_s": 0, "stop_s": 30}, {"name": "second", "start_s": 30, "stop_s": 60}]}}  # fmt: skip


AT_START = {"time_s": 0.0, "east_m": 0.0, "north_m": 9e3, "altitude_m": 5e3}


def flown(target: dict[str, Any]) -> dict[str, Any]:
    """A scenario in which one target flies like this."""
    return {"scenario": {"preset": "four_station_circuit", "parameters": {"targets": [target], "legs": []}}}


def body(**changes: Any) -> dict[str, Any]:
    entries = [{"name": name, "parameters": {"profile": "article", "start": START}} for name in ("rdf", "rdfv")]
    return {"algorithms": entries, "scenario": SHORT, "trials": 70, "seed": 3} | changes


def finished(api: httpx2.Client, run_id: str) -> dict[str, Any]:
    return conftest.finished(api, f"/api/v1/runs/{run_id}")


def newest(api: httpx2.Client) -> list[str]:
    return [run["id"] for run in api.get("/api/v1/runs?limit=1").json()["items"]]


def rows(api: httpx2.Client, run: dict[str, Any], table: str) -> list[dict[str, Any]]:
    found = api.get(f"/api/v1/runs/{run['id']}/tables/{table}.json").json()
    return [dict(zip(found["columns"], row, strict=True)) for row in found["rows"]]


@pytest.fixture(scope="module")
def run(api: httpx2.Client) -> dict[str, Any]:
    return finished(api, api.post("/api/v1/runs", json=body()).json()["id"])


def test_metrics_come_with_intervals_over_trials(api: httpx2.Client, run: dict[str, Any]) -> None:
    assert run["state"] == "succeeded", run["error"]
    assert run["trials"] == 70
    assert run["progress"] == {"done": 70, "total": 70, "eta_s": None}
    headline = run["summary"]["rms_horizontal_m"]
    assert set(headline) == {"rdf", "rdfv"}
    low, high = headline["rdf"]["ci95"]
    assert low < headline["rdf"]["value"] < high
    metrics = rows(api, run, "metrics")
    assert {row["segment"] for row in metrics} == {"", "first", "second"}
    (whole,) = (r for r in metrics if (r["metric"], r["label"], r["segment"]) == ("rms_horizontal_m", "rdf", ""))
    assert whole["value"] == headline["rdf"]["value"]
    assert whole["n"] == 70 * 60


def test_pairs_are_compared_and_curves_have_a_bound(api: httpx2.Client, run: dict[str, Any]) -> None:
    pairs = [r for r in rows(api, run, "comparisons") if (r["metric"], r["segment"]) == ("rms_horizontal_m", "")]
    assert [(p["label"], p["against"], p["n"]) for p in pairs] == [("rdf", "rdfv", 70)]
    assert pairs[0]["verdict"] == "larger", "the altitude helps from the first minute on"
    curves = rows(api, run, "curves")
    assert len(curves) == 2 * 60
    for row in curves[5:60]:
        assert row["bound_horizontal_m"] == pytest.approx(row["claimed_horizontal_m"], rel=0.2)
        assert row["rms_horizontal_m_low"] < row["rms_horizontal_m"] < row["rms_horizontal_m_high"]
    assert {r["verdict"] for r in rows(api, run, "consistency")} <= {"honest", "optimistic", "pessimistic", "mixed"}
    assert len(rows(api, run, "states")) == 2 * 60, "the first trial as an example"


def test_charts_draw_the_statistics_and_the_example(api: httpx2.Client, run: dict[str, Any]) -> None:
    names = [c["name"] for c in api.get(f"/api/v1/runs/{run['id']}/charts").json()["items"]]
    assert names[:4] == ["trials_error", "trials_gain", "trials_consistency", "trials_lost"]
    assert "trials_sweep" not in names, "a sweep's chart only where one is"
    assert "not_applicable" not in api.get(f"/api/v1/runs/{run['id']}/charts/trials_gain.json").json()["layout"]["meta"]
    for name in names:
        figure = api.get(f"/api/v1/runs/{run['id']}/charts/{name}.json").json()
        assert figure["data"] or figure["layout"]["meta"]["not_applicable"] == "nothing_lost", name


def test_the_same_run_gives_the_same_bytes(api: httpx2.Client, run: dict[str, Any]) -> None:
    again = finished(api, api.post("/api/v1/runs", json=body()).json()["id"])
    assert again["result_sha256"] == run["result_sha256"]


def test_a_sweep_has_a_column_for_each_name(api: httpx2.Client) -> None:
    sweep = {"scenario.sigma_toa_ns": [5, 20], "rdfv.sigma_altitude_m": [30, 100, 300]}
    run = finished(api, api.post("/api/v1/runs", json=body(sweep=sweep, trials=4)).json()["id"])
    names = [c["name"] for c in api.get(f"/api/v1/runs/{run['id']}/charts").json()["items"]]
    assert {"trials_sweep", "trials_times"} <= set(names)
    assert run["state"] == "succeeded", run["error"]
    assert run["progress"]["total"] == 8
    metrics = [r for r in rows(api, run, "metrics") if (r["metric"], r["segment"]) == ("rms_horizontal_m", "")]
    cells = [(r["label"], r["scenario.sigma_toa_ns"], r["rdfv.sigma_altitude_m"]) for r in metrics]
    times = rows(api, run, "computing_times")
    assert [(r["label"], r["scenario.sigma_toa_ns"], r["rdfv.sigma_altitude_m"]) for r in times] == cells
    assert all(r["seconds_per_trial"] > 0 and r["trials"] == 4 for r in times)
    assert cells == [("rdf", s, None) for s in (5, 20)] + [("rdfv", s, h) for h in (30, 100, 300) for s in (5, 20)]
    assert all(a["value"] < b["value"] for a, b in zip(metrics[::2], metrics[1::2], strict=True)), (
        "more noise, more error"
    )
    assert len(rows(api, run, "curves")) == 8 * 60
    assert set(run["settings"]["rdfv"]["sigma_altitude_m"]["value"]) == {30, 100, 300}


@pytest.mark.parametrize(
    ("change", "code", "pointer"),
    [
        ({"scenario": {"preset": "nowhere"}}, "scenario_not_found", "/scenario/preset"),
        ({"scenario": {"preset": "four_station_circuit", "parameters": {"sigma_toa_ns": 0}}}, "validation",
         "/scenario/parameters/sigma_toa_ns"),
        (flown({"segments": [{"duration_s": 99, "climb_rate_mps": -99}]}), "validation",
         "/scenario/parameters/targets/0/segments/0/climb_rate_mps"),
        (flown({"segments": [{"duration_s": 99, "acceleration_mps2": 120}]}), "validation",
         "/scenario/parameters/targets/0/segments/0/acceleration_mps2"),
        (flown({"speed_mps": 3e8, "segments": [{"duration_s": 1}]}), "validation",
         "/scenario/parameters/targets/0/speed_mps"),
        (flown({"points": [AT_START, AT_START | {"time_s": 1e-3, "east_m": 4e5}]}), "validation",
         "/scenario/parameters/targets/0/points/0"),
        (flown({"segments": [{"duration_s": 0}]}), "validation",
         "/scenario/parameters/targets/0/segments/0/duration_s"),
        ({"sweep": {"scenario.duration_s": [59, 0]}}, "validation", "/sweep/scenario.duration_s"),
        ({"sweep": {"scenario.period_s": [1, 1e-4]}}, "validation", "/sweep/scenario.period_s"),
        ({"algorithms": [{"name": "rdf", "label": "a"}, {"name": "rdfv", "label": "a"}]}, "label_repeated",
         "/algorithms/1/label"),
        ({"algorithms": [{"name": "nothing"}]}, "algorithm_not_found", "/algorithms/0/name"),
        ({"trials": 0}, "validation", "/trials"),
        ({"trials": 10**9}, "validation", "/trials"),
        ({"sweep": {"nobody.sigma_altitude_m": [1]}}, "sweep_unknown", "/sweep/nobody.sigma_altitude_m"),
        ({"sweep": {"rdf.sigma_altitude_m": [1]}}, "sweep_unknown", "/sweep/rdf.sigma_altitude_m"),
        ({"sweep": {"rdfv.sigma_altitude_m": [100, -1]}}, "validation", "/sweep/rdfv.sigma_altitude_m"),
        ({"sweep": {"scenario.sigma_toa_ns": [5, 0]}}, "validation", "/sweep/scenario.sigma_toa_ns"),
        ({"sweep": {"rdfv.sigma_altitude_m": [1, 1]}}, "sweep_repeated", "/sweep/rdfv.sigma_altitude_m"),
        ({"sweep": {"rdfv.sigma_altitude_m": []}}, "validation", "/sweep/rdfv.sigma_altitude_m"),
        ({"recording_id": "x"}, "source_missing", "/scenario"),
    ],
)  # fmt: skip
def test_what_cannot_start(api: httpx2.Client, change: dict[str, Any], code: str, pointer: str) -> None:
    before = newest(api)
    found = problem(api.post("/api/v1/runs", json=body(**change)), 422, code, pointer)
    assert all(e["detail"].endswith(".") for e in found["errors"]), found["errors"]
    assert newest(api) == before, "nothing half done"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (flown({"segments": [{"duration_s": 99, "climb_rate_mps": -99}]}), ("below the ground", "start higher")),
        (flown({"segments": [{"duration_s": 99, "acceleration_mps2": 120}]}), ("12030 m/s", "Keep the speed between")),
        ({"scenario": {"preset": "nowhere"}}, ("'nowhere'", "four_station_circuit")),
        ({"sweep": {"nobody.sigma_altitude_m": [1]}}, ("'nobody'", "rdf, rdfv")),
        ({"algorithms": [{"name": "nothing"}]}, ("'nothing'", "rdfv")),
        ({"trials": 10**9}, ("1000000", "less than or equal to")),
    ],
)  # fmt: skip
def test_the_answer_says_what_is_wrong_and_what_would_be_right(
    api: httpx2.Client, change: dict[str, Any], words: tuple[str, str]
) -> None:
    answer = api.post("/api/v1/runs", json=body(**change))
    assert answer.status_code == 422
    (found,) = answer.json()["errors"]
    assert all(word in found["detail"] for word in words), found["detail"]


def test_a_sweep_of_a_million_cells_is_refused_with_the_count(api: httpx2.Client) -> None:
    before = newest(api)
    sweep = {
        "scenario.sigma_toa_ns": list(range(1, 1001)),
        "rdfv.sigma_altitude_m": list(range(1, 501)),
        "rdf.sigma_jerk_mps3": list(range(1, 501)),
    }
    found = problem(api.post("/api/v1/runs", json=body(sweep=sweep)), 422, "sweep_too_large", "/sweep")
    assert "1,000,000" in found["detail"]
    assert newest(api) == before, "before anything starts"


def test_a_study_runs_and_judges_its_claims(api: httpx2.Client) -> None:
    (study,) = (s for s in api.get("/api/v1/studies").json()["items"] if s["name"] == "multilateration_figure_3")
    assert api.get(f"/api/v1/studies/{study['name']}").json() == study
    queued = api.post("/api/v1/runs", json={"study": study["name"], "trials": 2})
    assert queued.status_code == 202, queued.text
    run = finished(api, queued.json()["id"])
    assert run["state"] == "succeeded", run["error"]
    assert (run["label"], run["source"]["study"], run["seed"]) == (study["title"], study["name"], study["seed"])
    claims = rows(api, run, "claims")
    assert [c["claim"] for c in claims] == [c["claim"] for c in study["claims"]]
    assert {c["verdict"] for c in claims} <= {"reproduced", "partly", "not", "shown"}
    assert claims[2]["value"] == pytest.approx(471.94 / 454.52, abs=0.001), "specification 8.1, first line"


@pytest.mark.parametrize(
    ("body", "code", "pointer"),
    [
        ({"study": "nothing"}, "study_not_found", "/study"),
        ({"study": "multilateration_figure_3", "sweep": {"a.b": [1]}}, "study_is_whole", "/sweep"),
    ],
)
def test_what_is_no_study(api: httpx2.Client, body: dict[str, Any], code: str, pointer: str) -> None:
    problem(api.post("/api/v1/runs", json=body), 422, code, pointer)
    problem(api.get("/api/v1/studies/nothing"), 404, "study_not_found")
