"""Scenarios over HTTP: the catalogue, the preview, a stored recording that is read again, and what cannot be."""

from __future__ import annotations

import base64
import json
from typing import Any

import httpx2
import numpy as np
import pytest

from algorithms.registry import scenarios_by_name
from tests.api.conftest import problem, ready

URL = "/api/v1/scenarios"


def test_the_catalogue_has_every_preset_with_its_schema(api: httpx2.Client) -> None:
    items = api.get(URL).raise_for_status().json()["items"]
    assert [i["name"] for i in items] == list(scenarios_by_name())
    for item in items:
        assert api.get(f"{URL}/{item['name']}").json() == item
    found = {item["name"]: item for item in items}
    circuit, incomplete = found["four_station_circuit"], found["four_station_incomplete"]
    assert circuit["parameters_schema"]["properties"]["sigma_toa_ns"]["default"] == 10.0
    assert circuit["kind"] == "toa_marks"
    assert [r["key"] for r in circuit["references"]] == ["chugunov2023"]
    assert incomplete["parameters_schema"]["properties"]["timing"]["default"] == "irregular"
    problem(api.get(f"{URL}/four"), 404, "scenario_not_found")


def numbers(coded: Any) -> np.ndarray:
    return np.frombuffer(base64.b64decode(coded["bdata"]), coded["dtype"]) if isinstance(coded, dict) else coded


def test_a_preview_draws_one_recording(api: httpx2.Client) -> None:
    asked = {"preset": "two_aircraft_crossing", "parameters": {"sigma_toa_ns": 50}, "seed": 3, "points": 100}
    seen = api.post(f"{URL}/preview", json=asked).raise_for_status().json()
    assert {"plan", "measurements", "receptions"} <= set(seen["charts"])
    assert seen["targets"] == ["A", "B"]
    scenario = scenarios_by_name()["two_aircraft_crossing"]
    assert seen["rows"] == len(scenario.simulate(scenario.parameters(), (), 0))
    assert 0.3 < seen["complete_share"] < 0.9
    assert seen["site"]["sigma_toa_ns"] == 50
    assert [leg["name"] for leg in seen["legs"]] == ["apart", "crossing", "after"]
    truth = [t for t in seen["charts"]["plan"]["data"] if t.get("meta", {}).get("role") == "truth"]
    assert truth
    assert all(len(numbers(t["x"])) <= 220 for t in truth)
    assert api.post(f"{URL}/preview", json=asked).json() == seen
    assert api.post(f"{URL}/preview", json=asked | {"seed": 4}).json()["charts"] != seen["charts"]


def test_a_stored_recording_is_the_simulated_one_and_reads_again(api: httpx2.Client) -> None:
    changed = {"gaps": [{"start_s": 100, "stop_s": 200}], "reception_probability": 0.6, "decoding_probability": 0.5}
    asked = {"preset": "four_station_incomplete", "parameters": changed, "seed": 8}
    answer = api.post(f"{URL}/recording", json=asked)
    assert answer.status_code == 201, answer.text
    stored = ready(api, answer.headers["location"])
    assert answer.json()["id"] == stored["id"]
    assert stored["name"] == "four_station_incomplete, seed 8"
    assert stored["has_truth"]
    assert stored["rows"]["rejected"] == 0
    again = api.post(f"{URL}/recording", json=asked)
    assert (again.status_code, again.json()["id"]) == (200, stored["id"])

    scenario = scenarios_by_name()[asked["preset"]]
    made = scenario.simulate(scenario.parameters(**changed), (0,), 8)
    seen = api.post(f"{URL}/preview", json=asked).json()
    assert stored["rows"]["accepted"] == seen["rows"] - seen["unheard"] == len(made) - seen["unheard"]
    assert seen["unheard"] > 0
    assert stored["site"] == seen["site"] == made.site.to_json()

    text = api.get(f"/api/v1/recordings/{stored['id']}/data.csv").raise_for_status().content
    for form in ("csv", "parquet", "mat"):
        data = api.get(f"/api/v1/recordings/{stored['id']}/data.{form}").raise_for_status().content
        files = [("file", (f"again.{form}", data, "application/octet-stream"))]
        read = api.post("/api/v1/recordings", files=files, data={"site": json.dumps(stored["site"])})
        assert read.status_code == 201, read.text
        assert api.get(f"/api/v1/recordings/{read.json()['id']}/data.csv").content == text, form
    cells = [line.split(",") for line in text.decode().splitlines()]
    column = cells[0].index("toa_1_ns")
    measured = np.array([float(c[column]) * 1e-9 if c[column] else np.nan for c in cells[1:]])
    heard = np.isfinite(made.toa_s[:, :, 0]).any(axis=1) | np.isfinite(made.altitude_m[:, 0])
    np.testing.assert_allclose(measured, made.toa_s[heard, 0, 0], rtol=1e-15)


@pytest.mark.parametrize(
    ("preset", "parameters", "code", "pointer"),
    [
        ("four", {}, "scenario_not_found", "/preset"),
        ("four_station_circuit", {"sigma_toa_ns": -1}, "validation", "/parameters/sigma_toa_ns"),
        ("four_station_circuit", {"sigma_toa_ns": "10"}, "validation", "/parameters/sigma_toa_ns"),
        ("four_station_circuit", {"sigma": 1}, "validation", "/parameters/sigma"),
        ("four_station_circuit", {"duration_s": 0}, "validation", "/parameters/duration_s"),
        ("four_station_circuit", {"targets": [{"speed_mps": 3e8, "segments": [{"duration_s": 1}]}]}, "validation",
         "/parameters/targets/0/speed_mps"),
        ("four_station_circuit", {"targets": [{"segments": [{"duration_s": 0}]}]}, "validation",
         "/parameters/targets/0/segments/0/duration_s"),
        ("four_station_circuit", {"targets": [{"segments": [{"duration_s": 99, "climb_rate_mps": -99}]}]}, "parameter",
         "/parameters/targets/0/segments/0/climb_rate_mps"),
        ("four_station_circuit", {"period_s": 1e-4}, "parameter", "/parameters/period_s"),
        ("four_station_circuit", {"stations": [{"name": "A", "east_m": 0, "north_m": 0}]}, "validation",
         "/parameters/stations"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_place(
    api: httpx2.Client, preset: str, parameters: dict[str, Any], code: str, pointer: str
) -> None:
    for way in ("preview", "recording"):
        answer = api.post(f"{URL}/{way}", json={"preset": preset, "parameters": parameters})
        found = problem(answer, 422, code, pointer)
        assert all(e["detail"].endswith(".") for e in found["errors"])
    recordings = api.get("/api/v1/recordings").json()["items"]
    assert not [r for r in recordings if r["name"].startswith(f"{preset}, seed 0")], "nothing half done"
