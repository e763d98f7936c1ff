"""One target alone: in charts, tables and comparisons."""

from __future__ import annotations

import csv
import io
from typing import Any

import httpx2
import pytest

from tests.api.conftest import finished, problem


@pytest.fixture(scope="module")
def run_url(run: dict[str, Any]) -> str:
    return f"/api/v1/runs/{run['id']}"


@pytest.fixture(scope="module")
def recording_url(recording: dict[str, Any]) -> str:
    return f"/api/v1/recordings/{recording['id']}"


def test_targets_are_listed_with_their_marks(api: httpx2.Client, recording_url: str, marks: bytes) -> None:
    names = [row["target"] for row in csv.DictReader(io.StringIO(marks.decode()))]
    items = api.get(f"{recording_url}/targets").raise_for_status().json()["items"]
    assert {i["name"]: i["marks"] for i in items} == {name: names.count(name) for name in sorted(set(names))}
    assert all(i["time_span_s"][0] < i["time_span_s"][1] for i in items)
    own = api.get(f"{recording_url}/targets", params={"row": 5}).json()["items"]
    assert [i["name"] for i in own] == [names[4]]
    assert api.get(f"{recording_url}/targets", params={"row": 10**9}).json()["items"] == []
    problem(api.get(f"{recording_url}/targets", params={"row": 0}), 422, "validation", "/query/row")


def test_a_recording_without_names_has_no_targets(api: httpx2.Client, upload: Any) -> None:
    data = b"time_s,toa_1_ns,toa_2_ns,toa_3_ns,toa_4_ns\n0,1,2,3,4\n1,1,2,3,4\n"
    made = upload("nameless", data=data).raise_for_status().json()
    assert api.get(f"/api/v1/recordings/{made['id']}/targets").json()["items"] == []


def test_every_chart_and_its_numbers_follow_the_target(
    api: httpx2.Client, run_url: str, recording_url: str, marks: bytes
) -> None:
    rows = {i: row["target"] for i, row in enumerate(csv.DictReader(io.StringIO(marks.decode())), 1)}
    for base in (run_url, recording_url):
        for chart in api.get(f"{base}/charts").json()["items"]:
            address = f"{base}/charts/{chart['name']}"
            text = api.get(f"{address}.csv", params={"target": "OVR202"}).raise_for_status().text
            drawn = [int(float(r["row"])) for r in csv.DictReader(io.StringIO(text)) if r["row"]]
            assert {rows[i] for i in drawn} <= {"OVR202"}, address
            # What is said of the receivers is said of all marks.
            assert (text == api.get(f"{address}.csv").text) == (chart["name"] == "receiver_delays")
            page = api.get(f"{address}.html", params={"target": "OVR202"}).raise_for_status()
            assert page.headers["etag"] != api.get(f"{address}.html").headers["etag"]
            problem(api.get(f"{address}.json", params={"target": "nobody"}), 422, "unknown_target", "/query/target")


def test_tables_follow_the_target(api: httpx2.Client, run_url: str) -> None:
    for item in api.get(f"{run_url}/tables").json()["items"]:
        one = api.get(item["json_url"], params={"target": "ARR101"})
        if item["name"] in ("receivers", "receiver_delays"):
            problem(one, 422, "table_without_targets", "/query/target")
            continue
        table = one.json()
        at = table["columns"].index("target")
        assert {row[at] for row in table["rows"]} == {"ARR101"}, item["name"]
        assert 0 < table["total"] == len(table["rows"]) < item["rows"]
        as_csv = api.get(item["csv_url"], params={"target": "ARR101"}).text
        assert len(list(csv.reader(io.StringIO(as_csv)))) == table["total"] + 1
        problem(api.get(item["json_url"], params={"target": "nobody"}), 422, "unknown_target", "/query/target")


def test_an_overlaid_chart_follows_the_target(
    api: httpx2.Client, run: dict[str, Any], recording: dict[str, Any]
) -> None:
    body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf"}], "label": "second"}
    other = finished(api, api.post("/api/v1/runs", json=body).raise_for_status().headers["location"])
    query: dict[str, Any] = {"run": [run["id"], other["id"]], "target": "OVR202"}
    answer = api.get("/api/v1/compare/charts/nis.csv", params=query).raise_for_status()
    whole = api.get("/api/v1/compare/charts/nis.csv", params={"run": query["run"]}).text
    assert 0 < answer.text.count("\n") < whole.count("\n")
    problem(
        api.get("/api/v1/compare/charts/nis.json", params={**query, "target": "nobody"}),
        422,
        "unknown_target",
        "/query/target",
    )
