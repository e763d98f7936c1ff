"""Runs over the recordings of several radars, with an algorithm that says what reached it."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest

from algorithms.recording import PolarPlots, recording_from_arrays
from tests.api.conftest import finished, problem, start_server

PLUGIN = Path(__file__).parent / "plugin"
HEADER = "time_s,range_m,azimuth_deg,elevation_deg\n"
ONE = {
    "origin": {"latitude_deg": 55.0, "longitude_deg": 37.0},
    "radars": [{"name": "radar", "east_m": 0, "north_m": 0}],
}
OTHER = ONE | {"origin": {"latitude_deg": 55.0, "longitude_deg": 38.0}}
NOWHERE = {"radars": ONE["radars"]}


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory, repository: Path) -> Iterator[httpx2.Client]:
    paths = os.pathsep.join(map(str, (repository, PLUGIN)))
    running = start_server(
        tmp_path_factory.mktemp("joined") / "data", "--no-samples", "--workers", "1", PYTHONPATH=paths
    )
    try:
        with running.client() as client:
            yield client
    finally:
        running.stop()


def uploaded(api: httpx2.Client, name: str, site: dict[str, Any] | None, rows: str, **options: Any) -> str:
    fields = {"options": json.dumps({"name": name, **options})} | ({"site": json.dumps(site)} if site else {})
    answer = api.post("/api/v1/recordings", files=[("file", (f"{name}.csv", HEADER + rows))], data=fields)
    assert answer.status_code in (200, 201), answer.text
    assert answer.json()["state"] == "ready", answer.text
    return str(answer.json()["id"])


@pytest.fixture(scope="module")
def pair(api: httpx2.Client) -> tuple[str, str]:
    return (
        uploaded(api, "west", ONE, "0,40000,90,0\n2,41000,90,0\n"),
        uploaded(api, "east", OTHER, "1,24000,270,0\n3,23000,270,0\n"),
    )


def started(api: httpx2.Client, ids: list[str]) -> httpx2.Response:
    return api.post("/api/v1/runs", json={"algorithms": [{"name": "echo"}], "recording_ids": ids})


def test_an_algorithm_gets_one_recording_of_all_radars(api: httpx2.Client, pair: tuple[str, str]) -> None:
    answer = started(api, list(pair))
    assert answer.status_code == 202, answer.text
    run = finished(api, answer.headers["location"])
    assert run["state"] == "succeeded", run
    assert run["source"] == {
        "recording_ids": list(pair),
        "first_rows": [1, 3],
        "name": "west + east",
        "kind": "polar_plots",
    }
    assert run["summary"]["continuity"]["echo"]["value"] == 2
    notes = [n["code"] for n in run["notes"]["echo"]]
    assert notes == ["one_clock", "radar_renamed", "rows_numbered_on"]
    rows = api.get(f"/api/v1/runs/{run['id']}/tables/decisions.json").json()["rows"]
    assert [r[1:] for r in rows] == [[1, 0.0, "radar"], [3, 1.0, "radar (2)"], [2, 2.0, "radar"], [4, 3.0, "radar (2)"]]
    with np.load(io.BytesIO(api.get(f"/api/v1/runs/{run['id']}/result.npz").content)) as arrays:
        kept = recording_from_arrays(
            {n.removeprefix("recording/"): arrays[n] for n in arrays if n.startswith("recording/")}
        )
        assert arrays["echo/range_m"].tolist() == [40e3, 24e3, 41e3, 23e3]
    assert isinstance(kept, PolarPlots)
    # The plan draws all of it, the report says what it was made of, and each recording lists the run.
    plan = api.get(f"/api/v1/runs/{run['id']}/charts/plan.json").json()
    names = [name for trace in plan["data"] for name in (trace.get("text") or []) if trace["meta"]["role"] == "station"]
    assert names == ["radar", "radar (2)"]
    report = api.get(f"/api/v1/runs/{run['id']}/report.html").text
    assert "west.csv" in report
    assert "east.csv" in report
    for one in pair:
        assert [r["id"] for r in api.get("/api/v1/runs", params={"recording": one}).json()["items"]] == [run["id"]]
        problem(api.delete(f"/api/v1/recordings/{one}"), 409, "recording_in_use")


def test_one_of_recording_ids_is_a_run_on_that_recording(api: httpx2.Client, pair: tuple[str, str]) -> None:
    answer = started(api, [pair[0]])
    assert answer.status_code == 202, answer.text
    assert answer.json()["source"]["recording_id"] == pair[0]


def test_recordings_that_cannot_be_joined_name_the_field(api: httpx2.Client, pair: tuple[str, str]) -> None:
    first = pair[0]
    row = "0,1000,90,0\n"
    bare, adrift = uploaded(api, "bare", None, row), uploaded(api, "adrift", NOWHERE, row)
    dated = uploaded(api, "dated", ONE, row, start_utc="2026-01-01T00:00:00Z")
    for ids, code, pointer in (
        ([first, bare], "site_missing", "/recording_ids/1/site"),
        ([first, adrift], "origin_missing", "/recording_ids/1/site/origin"),
        ([dated, first], "mixed_time_bases", "/recording_ids/1/start_utc"),
        ([first, first], "recording_repeated", "/recording_ids/1"),
        ([first, "none"], "recording_not_found", "/recording_ids/1"),
        ([], "source_missing", "/recording_ids"),
    ):
        problem(started(api, ids), 422, code, pointer)


def test_an_estimate_is_of_all_recordings(api: httpx2.Client, pair: tuple[str, str]) -> None:
    body = {"algorithms": [{"name": "echo"}], "recording_ids": list(pair)}
    answer = api.post("/api/v1/runs/estimate", json=body)
    assert answer.status_code == 200, answer.text
    single = api.post("/api/v1/runs/estimate", json=body | {"recording_ids": [pair[0]]}).json()
    assert answer.json()["memory_bytes"] > 2 * single["memory_bytes"]
