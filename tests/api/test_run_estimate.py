"""The estimate before a start: from what was measured, else null; it starts nothing."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest

from tests.api.conftest import problem

URL = "/api/v1/runs/estimate"


def test_it_is_told_from_earlier_runs(api: httpx2.Client, run: dict[str, Any], recording: dict[str, Any]) -> None:
    body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf"}]}
    found = api.post(URL, json=body).raise_for_status().json()
    assert found["basis"][0]["label"] == "rdf"
    assert found["basis"][0]["measured"] >= 1
    assert found["seconds"] == pytest.approx(found["basis"][0]["seconds"])
    assert 0 < found["seconds"] < 60
    assert found["memory_bytes"] > 1000
    assert found["queue_position"] >= 0


def test_one_worker_takes_entries_one_after_the_other(
    api: httpx2.Client, run: dict[str, Any], recording: dict[str, Any]
) -> None:
    entries = [{"name": "rdf", "label": f"rdf {i}"} for i in range(4)]
    found = api.post(URL, json={"recording_id": recording["id"], "algorithms": entries}).json()
    assert found["seconds"] == pytest.approx(sum(b["seconds"] for b in found["basis"]))


def test_it_starts_nothing_and_refuses_what_a_start_would(api: httpx2.Client, recording: dict[str, Any]) -> None:
    before = api.get("/api/v1/runs").json()["items"][:1]
    api.post(URL, json={"recording_id": recording["id"], "algorithms": [{"name": "rdf"}]}).raise_for_status()
    assert api.get("/api/v1/runs").json()["items"][:1] == before
    problem(
        api.post(URL, json={"recording_id": recording["id"], "algorithms": [{"name": "nobody"}]}),
        422, "algorithm_not_found", "/algorithms/0/name",
    )  # fmt: skip


def test_a_form_gets_what_is_wrong_as_an_answer(api: httpx2.Client, recording: dict[str, Any]) -> None:
    """A body that is none stays an error."""
    body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf", "parameters": {"nothing": 1}}]}
    checked = {"check": "true"}
    refused = problem(api.post(URL, json=body), 422, "validation", "/algorithms/0/parameters/nothing")
    told = api.post(URL, json=body, params=checked).raise_for_status().json()
    assert told["errors"] == refused["errors"]
    assert (told["seconds"], told["memory_bytes"], told["basis"]) == (None, None, [])
    sound = api.post(URL, json=body | {"algorithms": [{"name": "rdf"}]}, params=checked).raise_for_status().json()
    assert sound["errors"] == []
    assert sound["basis"]
    problem(api.post(URL, json=body | {"algorithms": 1}, params=checked), 422, "validation", "/algorithms")
