"""Runs from the request to the headline: checks before the start, idempotency, cancelling, lists, renaming."""

from __future__ import annotations

import secrets
from typing import Any

import httpx2
import pytest

from backend.api.run_schemas import LISTED_METRICS, RunPage
from tests.api.conftest import FINAL, Upload, finished, problem


def body_of(recording: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"recording_id": recording["id"], "algorithms": [{"name": "single_mark"}], **more}


def test_run_is_accepted_with_its_address(api: httpx2.Client, recording: dict[str, Any]) -> None:
    answer = api.post("/api/v1/runs", json=body_of(recording, label="accepted", seed=7))
    assert answer.status_code == 202
    assert answer.headers["retry-after"] == "1"
    run = answer.json()
    assert answer.headers["location"] == f"/api/v1/runs/{run['id']}"
    assert run["state"] in ("queued", "running", "succeeded")
    assert run["source"]["recording_id"] == recording["id"]
    assert (run["seed"], run["trials"], run["label"]) == (7, 1, "accepted")
    assert finished(api, answer.headers["location"])["state"] == "succeeded"


def test_finished_run_has_headline_settings_and_software(run: dict[str, Any]) -> None:
    assert run["state"] == "succeeded", run["error"]
    assert run["progress"]["done"] == run["progress"]["total"] > 0
    headline = run["summary"]["rms_horizontal_m"]
    assert set(headline) == {"rdf", "rdfv 50 m"}
    assert 10 < headline["rdfv 50 m"]["value"] < 1000
    assert headline["rdf"]["unit"] == "m"
    assert run["settings"]["rdfv 50 m"]["sigma_altitude_m"] == {"value": 50, "source": "run"}
    assert run["software"]["numpy"]
    assert run["created_at"] <= run["started_at"] <= run["finished_at"]


def test_a_run_cites_its_papers_in_full(api: httpx2.Client, run: dict[str, Any]) -> None:
    cited = {(r["key"], r["place"]): r["text"] for r in run["references"]}
    assert set(cited) == {
        (r["key"], r["place"])
        for entry in run["algorithms"]
        for r in api.get(f"/api/v1/algorithms/{entry['name']}").json()["references"]
    }
    assert len(cited) == len(run["references"]), "each once, although two algorithms cite it"
    assert "DOI 10.17212/1727-2769-2023-4-77-90" in cited["chugunov2023", "eqs. (5)-(23)"]
    assert min(len(text) for text in cited.values()) > 60


def test_a_list_shows_of_a_run_what_its_own_page_shows_but_for_what_is_long(
    api: httpx2.Client, run: dict[str, Any]
) -> None:
    answer = api.get("/api/v1/runs", params={"tag": "kept"})
    (listed,) = answer.json()["items"]
    shown = {k: v for k, v in run.items() if k not in ("settings", "notes", "seconds", "references")}
    headline = {m: v for m, v in run["summary"].items() if m in LISTED_METRICS}
    assert headline
    assert len(headline) < len(run["summary"])
    assert listed == shown | {"summary": headline}
    # The list is written without the checks of the schema that describes it.
    assert RunPage.model_validate_json(answer.content, strict=True).model_dump(mode="json") == answer.json()


@pytest.mark.parametrize(
    ("change", "code", "pointer"),
    [
        ({"algorithms": []}, "validation", "/algorithms"),
        ({"algorithms": [{"name": "nope"}]}, "algorithm_not_found", "/algorithms/0/name"),
        ({"algorithms": [{"name": "rdf"}, {"name": "rdf"}]}, "label_repeated", "/algorithms/1/label"),
        ({"algorithms": [{"name": "rdf", "label": "a/b"}]}, "validation", "/algorithms/0/label"),
        ({"algorithms": [{"name": "rdf", "label": "tables"}]}, "validation", "/algorithms/0/label"),
        (
            {"algorithms": [{"name": "rdf"}, {"name": "rdfv", "parameters": {"sigma_toa_ns": -1}}]},
            "validation",
            "/algorithms/1/parameters/sigma_toa_ns",
        ),
        (
            {"algorithms": [{"name": "rdf", "parameters": {"sigma_toa_ns": "10"}}]},
            "validation",
            "/algorithms/0/parameters/sigma_toa_ns",
        ),
        (
            {"algorithms": [{"name": "rdf", "parameters": {"sigma": 1}}]},
            "validation",
            "/algorithms/0/parameters/sigma",
        ),
        ({"recording_id": "none"}, "recording_not_found", "/recording_id"),
        ({"recording_id": None}, "source_missing", "/recording_id"),
        ({"recording_ids": ["a", "b"], "recording_id": None}, "recording_not_found", "/recording_ids/0"),
        ({"scenario": {"preset": "x"}}, "source_missing", "/scenario"),
        ({"scenario": {"preset": "x"}, "recording_id": None}, "scenario_not_found", "/scenario/preset"),
        ({"study": "x"}, "study_is_whole", "/algorithms"),
        ({"sweep": {"a.b": [1]}}, "sweep_of_a_recording", "/sweep"),
        ({"trials": 2}, "trials_of_a_recording", "/trials"),
        ({"seed": -1}, "validation", "/seed"),
        ({"unknown": 1}, "validation", "/unknown"),
        ({"label": "a\u0000b"}, "validation", "/label"),
        ({"tags": [" "]}, "validation", "/tags/0"),
    ],
)
def test_what_cannot_start_names_the_field(
    api: httpx2.Client, recording: dict[str, Any], change: dict[str, Any], code: str, pointer: str
) -> None:
    problem(api.post("/api/v1/runs", json=body_of(recording) | change), 422, code, pointer)


def test_everything_wrong_is_said_at_once(api: httpx2.Client, recording: dict[str, Any]) -> None:
    entries = [{"name": "nope"}, {"name": "rdf", "parameters": {"sigma_toa_ns": 0, "typo": 1}}]
    found = problem(api.post("/api/v1/runs", json=body_of(recording, algorithms=entries)), 422, "validation")
    assert [e["pointer"] for e in found["errors"]] == [
        "/algorithms/0/name",
        "/algorithms/1/parameters/sigma_toa_ns",
        "/algorithms/1/parameters/typo",
    ]


def test_run_without_a_site_is_told_to_name_it(api: httpx2.Client, upload: Upload) -> None:
    bare = upload("bare", site=None).json()
    found = problem(api.post("/api/v1/runs", json=body_of(bare)), 422, "site_missing", "/site")
    assert "site" in found["detail"]


def test_algorithm_of_another_kind_is_refused(api: httpx2.Client, upload: Upload) -> None:
    plots = upload("plots", data=b"time_s,range_m,azimuth_deg\n1,1000,10\n2,1100,11\n", site=None).json()
    problem(api.post("/api/v1/runs", json=body_of(plots)), 422, "kind_mismatch", "/algorithms/0/name")


def test_idempotency_key_makes_one_run(api: httpx2.Client, recording: dict[str, Any]) -> None:
    key = {"Idempotency-Key": secrets.token_hex(8)}
    first = api.post("/api/v1/runs", json=body_of(recording, label="once"), headers=key)
    again = api.post("/api/v1/runs", json=body_of(recording, label="once"), headers=key)
    assert (first.status_code, again.status_code) == (202, 202)
    assert first.headers["location"] == again.headers["location"]
    other = api.post("/api/v1/runs", json=body_of(recording, label="twice"), headers=key)
    problem(other, 422, "idempotency_key_reused", "/header/Idempotency-Key")
    assert len(api.get("/api/v1/runs?text=once").json()["items"]) == 1
    finished(api, first.headers["location"])


def test_cancel_and_delete_follow_the_state(api: httpx2.Client, recording: dict[str, Any]) -> None:
    entries = [{"name": "rdf", "label": f"rdf {i}"} for i in range(20)]
    location = api.post("/api/v1/runs", json=body_of(recording, algorithms=entries)).headers["location"]
    problem(api.delete(location), 409, "run_live")
    problem(api.get(f"{location}/tables"), 409, "no_result")
    problem(api.get(f"{location}/result.npz"), 409, "no_result")
    problem(api.get(f"{location}/charts/plan.json"), 409, "no_result")
    cancelled = api.post(f"{location}/cancel")
    assert cancelled.status_code == 202
    assert cancelled.json()["state"] == "cancelled"
    assert api.post(f"{location}/cancel").status_code == 200
    assert "Cancelled" in api.get(f"{location}/log").text
    assert api.delete(location).status_code == 204
    problem(api.get(location), 404, "run_not_found")
    problem(api.post(f"{location}/cancel"), 404, "run_not_found")


def test_finished_run_cannot_be_cancelled(api: httpx2.Client, run: dict[str, Any]) -> None:
    problem(api.post(f"/api/v1/runs/{run['id']}/cancel"), 409, "run_finished")


def test_failed_run_says_why(api: httpx2.Client, upload: Upload, site: dict[str, Any]) -> None:
    # Two stations: a recording that reads, and from which no position can be solved.
    two = {**site, "stations": site["stations"][:2]}
    data = b"time_s,toa_1_ns,toa_2_ns\n1,1000,2000\n2,1000,2000\n"
    few = upload("two stations", data=data, site=two).json()
    run = finished(api, api.post("/api/v1/runs", json=body_of(few)).headers["location"])
    assert run["state"] in FINAL
    if run["state"] == "failed":
        assert run["error"]["code"]
        assert run["error"]["detail"]


def test_list_is_filtered(api: httpx2.Client, run: dict[str, Any], recording: dict[str, Any]) -> None:
    def ids(**query: Any) -> list[str]:
        return [r["id"] for r in api.get("/api/v1/runs", params=query).json()["items"]]

    assert run["id"] in ids(limit=500)
    assert ids(tag="kept") == [run["id"]]
    assert run["id"] in ids(algorithm="rdfv", recording=recording["id"], limit=500)
    assert run["id"] not in ids(algorithm="single_mark", limit=500)
    assert run["id"] in ids(text="RDFV 50", limit=500)
    assert ids(text="kept SAMPLE finished") == [run["id"]], "words of tag, recording and label"
    assert ids(text="kept nowhere") == []
    assert run["id"] in ids(state=["failed", "succeeded"], limit=500)
    assert run["id"] not in ids(state="failed", limit=500)
    assert run["id"] not in ids(created_after=run["created_at"], limit=500)
    assert run["id"] not in ids(created_before=run["created_at"], limit=500)


def test_pages_do_not_slip_when_runs_are_added(api: httpx2.Client, recording: dict[str, Any]) -> None:
    def start() -> str:
        location = api.post("/api/v1/runs", json=body_of(recording, tags=["paged"])).headers["location"]
        return location.rsplit("/", 1)[-1]

    ids = [start() for _ in range(3)]
    first = api.get("/api/v1/runs?tag=paged&limit=2").json()
    late = start()
    second = api.get("/api/v1/runs", params={"tag": "paged", "limit": 2, "cursor": first["next_cursor"]}).json()
    assert [r["id"] for r in first["items"] + second["items"]] == ids[::-1]
    oldest = api.get("/api/v1/runs?tag=paged&order=created_at").json()
    assert [r["id"] for r in oldest["items"]] == [*ids, late]
    for run_id in (*ids, late):
        finished(api, f"/api/v1/runs/{run_id}")


def test_run_is_renamed_and_its_tag_changes(api: httpx2.Client, run: dict[str, Any]) -> None:
    url = f"/api/v1/runs/{run['id']}"
    etag = api.get(url).headers["etag"]
    assert api.get(url, headers={"If-None-Match": etag}).status_code == 304
    changed = api.patch(url, json={"label": "renamed"})
    assert changed.status_code == 200
    assert (changed.json()["label"], changed.json()["tags"]) == ("renamed", ["kept"])
    assert api.get(url, headers={"If-None-Match": etag}).status_code == 200
    assert api.get("/api/v1/runs?text=renamed").json()["items"][0]["id"] == run["id"]
    problem(api.patch(url, json={"state": "failed"}), 422, "validation", "/state")
    problem(api.patch("/api/v1/runs/none", json={"label": ""}), 404, "run_not_found")
    assert api.patch(url, json={"label": run["label"]}).json()["label"] == run["label"]


def test_disk_used_by_a_run_is_the_size_of_its_result(api: httpx2.Client, run: dict[str, Any]) -> None:
    size = len(api.get(f"/api/v1/runs/{run['id']}/result.npz").content)
    assert api.get(f"/api/v1/runs/{run['id']}").json()["size_bytes"] == size > 10_000
    assert api.get("/api/v1/runs?tag=kept").json()["items"][0]["size_bytes"] == size


def test_tags_are_listed(api: httpx2.Client, run: dict[str, Any]) -> None:
    assert {"tag": "kept", "runs": 1} in api.get("/api/v1/tags").json()["items"]


def test_log_is_text(api: httpx2.Client, run: dict[str, Any]) -> None:
    answer = api.get(f"/api/v1/runs/{run['id']}/log")
    assert answer.headers["content-type"] == "text/plain; charset=utf-8"
    assert "Succeeded." in answer.text
    problem(api.get("/api/v1/runs/none/log"), 404, "run_not_found")


def test_misspelt_filter_is_refused(api: httpx2.Client) -> None:
    problem(api.get("/api/v1/runs?stat=failed"), 422, "validation", "/query/stat")
    problem(api.get("/api/v1/runs?state=done"), 422, "validation", "/query/state/0")
    problem(api.get("/api/v1/runs?limit=0"), 422, "validation", "/query/limit")


def test_algorithms_are_described(api: httpx2.Client) -> None:
    answer = api.get("/api/v1/algorithms")
    items = {a["name"]: a for a in answer.json()["items"]}
    assert {"single_mark", "rdf", "rdfv"} <= set(items)
    rdfv = api.get("/api/v1/algorithms/rdfv").json()
    assert rdfv == items["rdfv"]
    assert rdfv["takes"] == ["toa_marks"]
    schema = rdfv["parameters_schema"]["properties"]["sigma_altitude_m"]
    assert (schema["unit"], schema["group"]) == ("m", "measurement")
    assert all(r["text"] for r in rdfv["references"])
    etag = answer.headers["etag"]
    assert api.get("/api/v1/algorithms", headers={"If-None-Match": etag}).status_code == 304
    problem(api.get("/api/v1/algorithms/nope"), 404, "algorithm_not_found")
