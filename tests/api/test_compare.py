"""Several runs side by side: tables, overlaid charts, and what cannot be compared."""

from __future__ import annotations

import csv
import io
from typing import Any

import httpx2
import pytest

from tests.api.conftest import Upload, finished, problem


def start(api: httpx2.Client, recording: dict[str, Any], label: str, *entries: dict[str, Any]) -> dict[str, Any]:
    body = {"recording_id": recording["id"], "label": label, "algorithms": list(entries)}
    run = finished(api, api.post("/api/v1/runs", json=body).raise_for_status().headers["location"])
    assert run["state"] == "succeeded", run["error"]
    return run


@pytest.fixture(scope="module")
def pair(api: httpx2.Client, recording: dict[str, Any]) -> list[dict[str, Any]]:
    """Two runs on one recording; they share `rdf`, and `rdfv` differs in one parameter."""
    coarse = {"name": "rdfv", "parameters": {"sigma_altitude_m": 300}}
    return [
        start(api, recording, "fine", {"name": "rdf"}, {"name": "rdfv", "parameters": {"sigma_altitude_m": 30}}),
        start(api, recording, "coarse", {"name": "rdf"}, coarse),
    ]


@pytest.fixture(scope="module")
def far(api: httpx2.Client, upload: Upload, site: dict[str, Any]) -> dict[str, Any]:
    """A run on the same marks, read with a frame that lies elsewhere."""
    origin = {"latitude_deg": 10.0, "longitude_deg": 20.0, "height_m": 0.0}
    moved = upload("elsewhere", site={**site, "origin": origin}).json()
    return start(api, moved, "elsewhere", {"name": "rdf"})


def compare(api: httpx2.Client, *ids: str, path: str = "", **more: Any) -> httpx2.Response:
    return api.get(f"/api/v1/compare{path}", params={"run": list(ids), **more})


def test_tables_stand_side_by_side(api: httpx2.Client, pair: list[dict[str, Any]]) -> None:
    found = compare(api, *(r["id"] for r in pair)).raise_for_status().json()
    assert [r["title"] for r in found["runs"]] == ["fine", "coarse"]
    assert [e["label"] for e in found["entries"]] == ["fine / rdf", "fine / rdfv", "coarse / rdf", "coarse / rdfv"]
    assert [e["index"] for e in found["entries"]] == [0, 1, 2, 3]
    parameters = {p["name"]: p for p in found["parameters"]}
    altitude = parameters["sigma_altitude_m"]
    assert [v and v["value"] for v in altitude["values"]] == [None, 30, None, 300]
    assert altitude["differs"]
    assert not parameters["sigma_jerk_mps3"]["differs"]
    given = {row["name"]: row for row in found["given"]}
    assert given["algorithm"]["values"] == ["rdf", "rdfv", "rdf", "rdfv"]
    assert (given["algorithm"]["differs"], given["recording"]["differs"]) == (True, False)
    assert found["same_recording"]
    metric = next(m for m in found["metrics"] if m["metric"] == "rms_horizontal_m")
    values = [v["value"] for v in metric["values"]]
    assert values[:2] == [pair[0]["summary"]["rms_horizontal_m"][name]["value"] for name in ("rdf", "rdfv")]
    assert values[0] == values[2] != values[1]
    assert metric["best"] == [i for i, v in enumerate(values) if v == min(values)]
    claimed = next(m for m in found["metrics"] if m["metric"] == "claimed_horizontal_m")
    assert claimed["best"] == [], "a smaller claim is not a better one"


def test_metrics_of_one_target(api: httpx2.Client, pair: list[dict[str, Any]]) -> None:
    ids = [r["id"] for r in pair]
    found = compare(api, *ids).json()
    assert "" in found["targets"]
    target = next(name for name in found["targets"] if name)
    one = compare(api, *ids, target=target).json()["metrics"]
    assert one
    assert compare(api, *ids, target="nobody").json()["metrics"] == []


def test_runs_of_one_name_are_told_apart(api: httpx2.Client, recording: dict[str, Any]) -> None:
    runs = [start(api, recording, "twin", {"name": "rdf"}) for _ in range(2)]
    found = compare(api, *(r["id"] for r in runs)).json()
    assert [e["label"] for e in found["entries"]] == [f"twin {r['id'][:6]} / rdf" for r in runs]
    metric = next(m for m in found["metrics"] if m["metric"] == "rms_horizontal_m")
    assert (metric["differs"], metric["best"]) == (False, []), "the same numbers: nothing is best"


@pytest.mark.parametrize("chart", ["plan", "drms", "nis", "altitude", "receptions"])
def test_charts_are_overlaid(api: httpx2.Client, pair: list[dict[str, Any]], chart: str) -> None:
    ids = [r["id"] for r in pair]
    answer = compare(api, *ids, path=f"/charts/{chart}.json", points=100).raise_for_status()
    figure = answer.json()
    entries = {t["meta"]["index"]: t["meta"]["label"] for t in figure["data"] if t["meta"]["label"]}
    assert entries == {0: "fine / rdf", 1: "fine / rdfv", 2: "coarse / rdf", 3: "coarse / rdfv"}
    series = [t for t in figure["data"] if t["meta"]["role"] == "series" and t["meta"]["label"]]
    colors = {t["meta"]["index"]: t.get("line", t.get("marker"))["color"] for t in series}
    assert len(set(colors.values())) == len(colors)
    etag = {"If-None-Match": answer.headers["etag"]}
    same = api.get("/api/v1/compare/charts/" + chart + ".json", params={"run": ids, "points": 100}, headers=etag)
    assert same.status_code == 304
    rows = list(csv.DictReader(io.StringIO(compare(api, *ids, path=f"/charts/{chart}.csv").text)))
    assert {"fine / rdf", "coarse / rdfv"} <= {r["label"] for r in rows}


def test_the_true_path_is_drawn_once(api: httpx2.Client, pair: list[dict[str, Any]]) -> None:
    figure = compare(api, *(r["id"] for r in pair), path="/charts/plan.json").json()
    assert [t["meta"]["role"] for t in figure["data"]].count("truth") == 1


def test_what_cannot_be_compared_is_said(api: httpx2.Client, pair: list[dict[str, Any]]) -> None:
    first, second = (r["id"] for r in pair)
    for path in ("", "/charts/plan.json", "/charts/plan.csv"):
        problem(compare(api, first, path=path), 422, "validation", "/query/run")
        problem(compare(api, *(f"{i}" for i in range(11)), path=path), 422, "validation", "/query/run")
        problem(compare(api, first, "gone", path=path), 404, "run_not_found", "/query/run/1")
        problem(compare(api, first, second, first, path=path), 422, "run_repeated", "/query/run/2")
    problem(compare(api, first, second, path="/charts/none.json"), 404, "chart_not_found")
    problem(compare(api, first, second, typo="1"), 422, "validation", "/query/typo")


def test_a_run_without_a_result_is_named(
    api: httpx2.Client, pair: list[dict[str, Any]], recording: dict[str, Any]
) -> None:
    entries = [{"name": "rdf", "label": f"rdf {i}"} for i in range(20)]
    body = {"recording_id": recording["id"], "label": "unfinished", "algorithms": entries}
    location = api.post("/api/v1/runs", json=body).headers["location"]
    api.post(f"{location}/cancel")
    run_id = location.rsplit("/", 1)[-1]
    found = problem(compare(api, pair[0]["id"], run_id), 409, "no_result", "/query/run/1")
    assert "unfinished" in found["detail"]
    assert "cancelled" in found["detail"]


def test_frames_elsewhere_are_not_overlaid(api: httpx2.Client, pair: list[dict[str, Any]], far: dict[str, Any]) -> None:
    ids = pair[0]["id"], far["id"]
    found = compare(api, *ids).json()
    assert not found["same_recording"]
    assert all(m["best"] == [] for m in found["metrics"])
    obstacles = {c["name"]: c["obstacle"] for c in found["charts"]}
    assert "origin" in obstacles["plan"]
    assert "different recordings" in obstacles["receptions"]
    assert obstacles["drms"] is None
    problem(compare(api, *ids, path="/charts/plan.json"), 409, "recordings_differ")
    figure = compare(api, *ids, path="/charts/drms.json").raise_for_status().json()
    assert {t["meta"]["label"] for t in figure["data"]} >= {"fine / rdf", "elsewhere / rdf"}


def test_the_same_frame_read_again_is_overlaid(
    api: httpx2.Client, pair: list[dict[str, Any]], upload: Upload, marks: bytes
) -> None:
    half = b"\n".join(marks.splitlines()[:600]) + b"\n"
    run = start(api, upload("first half", data=half).json(), "half", {"name": "rdf"})
    figure = compare(api, pair[0]["id"], run["id"], path="/charts/plan.json").raise_for_status().json()
    assert [t["meta"]["role"] for t in figure["data"]].count("truth") == 2, "each recording has its own"
