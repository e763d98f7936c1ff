"""Uploads in their three forms, what the answer says, round trip, reading again, deletion."""

from __future__ import annotations

import json
from typing import Any

import httpx2
import pytest

from tests.api.conftest import Upload, finished, problem, ready

MARKS = (
    b"time_s,toa_1_ns,toa_2_ns,toa_3_ns,toa_4_ns\n1,1000,2000,3000,4000\n2,1000,2000,x,4000\n3,1500,2500,3500,4500\n"
)


def test_answer_tells_what_was_read(recording: dict[str, Any], marks: bytes) -> None:
    rows = marks.count(b"\n") - 1
    assert recording["kind"] == "toa_marks"
    assert recording["format"] == "native_csv"
    assert recording["rows"] == {"read": rows, "accepted": rows, "rejected": 0}
    assert recording["has_truth"] is True
    assert recording["time_span_s"][0] < recording["time_span_s"][1]
    assert recording["site"]["stations"][0]["name"] == "1"
    assert [f["role"] for f in recording["files"]] == ["data", "site"]


def test_new_upload_is_201_with_its_address(upload: Upload, api: httpx2.Client) -> None:
    answer = upload("new")
    assert answer.status_code == 201
    assert answer.headers["location"] == f"/api/v1/recordings/{answer.json()['id']}"
    assert api.get(answer.headers["location"]).json() == answer.json()


def test_same_bytes_read_in_the_same_way_are_one_recording(upload: Upload, recording: dict[str, Any]) -> None:
    again = upload("sample")
    assert again.status_code == 200
    assert again.json()["id"] == recording["id"]


def test_another_site_makes_another_recording(upload: Upload, site: dict[str, Any], recording: dict[str, Any]) -> None:
    moved = json.loads(json.dumps(site))
    moved["stations"][0]["up_m"] += 1
    other = upload("sample", site=moved)
    assert other.status_code == 201
    assert other.json()["id"] != recording["id"]
    assert other.json()["sha256"] == recording["sha256"]


def test_rejected_rows_are_listed_with_reasons(upload: Upload, api: httpx2.Client) -> None:
    found = upload("one bad row", data=MARKS, site=None).json()
    assert found["rows"] == {"read": 3, "accepted": 2, "rejected": 1}
    assert found["rejections"][0]["row"] == 2
    lines = api.get(found["rejections_url"]).text.splitlines()
    assert lines[0] == "row,code,detail,file"
    assert lines[1].startswith("2,")
    assert len(lines) == 2


def test_raw_body_with_options_in_the_query(api: httpx2.Client) -> None:
    answer = api.post(
        "/api/v1/recordings?name=raw&kind=toa_marks",
        content=MARKS,
        headers={"Content-Type": "application/octet-stream"},
    )
    assert answer.status_code == 201, answer.text
    assert answer.json()["name"] == "raw"


def test_several_files_are_merged_by_time(api: httpx2.Client) -> None:
    later = MARKS.replace(b"\n1,", b"\n1.5,").replace(b"\n2,", b"\n2.5,").replace(b"\n3,", b"\n3.5,")
    answer = api.post("/api/v1/recordings", files=[("file", ("a.csv", MARKS)), ("file", ("b.csv", later))])
    assert answer.status_code == 201, answer.text
    assert answer.json()["rows"]["read"] == 6
    assert answer.json()["time_span_s"] == [1, 3.5]
    assert answer.json()["name"] == "a.csv and 1 more"


def test_stored_bytes_are_read_again_with_a_site(upload: Upload, api: httpx2.Client, site: dict[str, Any]) -> None:
    bare = upload("no site yet", site=None).json()
    assert bare["site"] is None
    again = api.post("/api/v1/recordings", json={"from_recording_id": bare["id"], "site": site})
    assert again.status_code == 201, again.text
    assert again.json()["site"]["stations"]
    assert again.json()["name"] == "no site yet"
    assert again.json()["sha256"] == bare["sha256"]
    away = api.post("/api/v1/recordings", json={"from_recording_id": again.json()["id"], "site": None})
    assert away.status_code == 200
    assert away.json()["id"] == bare["id"]


def test_reading_again_needs_an_existing_recording(api: httpx2.Client) -> None:
    answer = api.post("/api/v1/recordings", json={"from_recording_id": "none"})
    problem(answer, 422, "recording_not_found", "/from_recording_id")


def test_csv_reads_back_as_the_same_recording(upload: Upload, api: httpx2.Client, recording: dict[str, Any]) -> None:
    answer = api.get(f"/api/v1/recordings/{recording['id']}/data.csv")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/csv")
    back = upload("round trip", data=answer.content).json()
    assert back["rows"] == recording["rows"]
    again = api.get(f"/api/v1/recordings/{back['id']}/data.csv")
    assert again.content == answer.content


@pytest.mark.parametrize(
    ("fields", "files", "code", "pointer"),
    [
        ({"options": "{}"}, [], "validation", "/file"),
        ({"option": "{}"}, [("file", ("a.csv", MARKS))], "validation", "/option"),
        ({"options": '{"nmae": "x"}'}, [("file", ("a.csv", MARKS))], "validation", "/options/nmae"),
        ({"options": "{"}, [("file", ("a.csv", MARKS))], "validation", "/options"),
        ({"site": '{"stations": 3}'}, [("file", ("a.csv", MARKS))], "site_invalid", "/site/stations"),
        ({}, [("file", ("a.csv", b""))], "empty_file", "/file"),
        ({}, [("file", ("a.csv", b"%PDF-1.7 not a table"))], "unsupported_format", "/file"),
    ],
)
def test_what_cannot_be_read_names_the_field(
    api: httpx2.Client, fields: dict[str, str], files: list[Any], code: str, pointer: str
) -> None:
    before = len(api.get("/api/v1/recordings?limit=500").json()["items"])
    form = [*files, *((name, (None, text)) for name, text in fields.items())]
    found = problem(api.post("/api/v1/recordings", files=form), 422, code)
    assert any(e["pointer"].startswith(pointer) for e in found["errors"]), found
    assert len(api.get("/api/v1/recordings?limit=500").json()["items"]) == before, "a refused upload leaves nothing"


def test_file_name_is_only_a_label(upload: Upload, api: httpx2.Client, server: Any) -> None:
    data = MARKS.replace(b"4500", b"4501")
    answer = api.post("/api/v1/recordings", files=[("file", ("../../../etc/passwd.csv", data))])
    assert answer.status_code == 201
    assert answer.json()["files"][0]["name"] == "passwd.csv"
    assert not (server.data.parent / "etc").exists()


def test_form_that_ends_early_is_refused(api: httpx2.Client) -> None:
    body = b'--x\r\nContent-Disposition: form-data; name="file"; filename="a.csv"\r\n\r\ntime_s,to'
    answer = api.post("/api/v1/recordings", content=body, headers={"Content-Type": "multipart/form-data; boundary=x"})
    problem(answer, 400, "malformed_request")


def test_big_upload_answers_at_once_and_is_ready_later(api: httpx2.Client) -> None:
    # Long numbers rather than many rows: what counts are the bytes.
    row = b"%d," + b",".join(b"%d.%020d" % (i, 0) for i in (1000, 2000, 3000, 4000)) + b"\n"
    data = b"time_s,toa_1_ns,toa_2_ns,toa_3_ns,toa_4_ns\n" + b"".join(row % i for i in range(100_000))
    assert 8 * 2**20 < len(data) < 16 * 2**20
    answer = api.post("/api/v1/recordings", files=[("file", ("big.csv", data))])
    assert answer.status_code == 201
    assert answer.json()["state"] == "parsing"
    body = {"recording_id": answer.json()["id"], "algorithms": [{"name": "rdf"}]}
    problem(api.post("/api/v1/runs", json=body), 409, "recording_not_ready")
    problem(api.get(answer.headers["location"] + "/data.csv"), 409, "recording_not_ready")
    assert ready(api, answer.headers["location"])["rows"]["read"] == 100_000
    assert api.delete(answer.headers["location"]).status_code == 204


def test_list_pages_do_not_slip_when_rows_are_added(upload: Upload, api: httpx2.Client) -> None:
    names = [f"page {i}" for i in range(4)]
    for name in names:
        upload(name, data=MARKS, site=None).raise_for_status()
    first = api.get("/api/v1/recordings?text=page&limit=2")
    assert first.headers["link"].endswith('; rel="next"')
    upload("page late", data=MARKS, site=None).raise_for_status()
    second = api.get("/api/v1/recordings", params={"text": "page", "limit": 2, "cursor": first.json()["next_cursor"]})
    seen = [r["name"] for r in first.json()["items"] + second.json()["items"]]
    assert seen == names[::-1]
    assert second.json()["next_cursor"] is None
    assert "link" not in second.headers


def test_cursor_of_another_list_is_refused(upload: Upload, api: httpx2.Client) -> None:
    for i in range(2):
        upload(f"cursor {i}", data=MARKS, site=None).raise_for_status()
    cursor = api.get("/api/v1/recordings?text=cursor&limit=1").json()["next_cursor"]
    problem(api.get("/api/v1/recordings", params={"cursor": cursor}), 422, "cursor", "/query/cursor")
    for nonsense in ("x", "e30=", "WzEsMiwzXQ==", "é"):
        problem(api.get("/api/v1/recordings", params={"cursor": nonsense}), 422, "cursor", "/query/cursor")


def test_recording_in_use_is_kept_unless_its_runs_go_too(upload: Upload, api: httpx2.Client) -> None:
    used = upload("in use").json()
    location = f"/api/v1/recordings/{used['id']}"
    body = {"recording_id": used["id"], "algorithms": [{"name": "single_mark"}]}
    run = finished(api, api.post("/api/v1/runs", json=body).headers["location"])
    assert api.get(location).json()["runs"] == 1
    problem(api.delete(location), 409, "recording_in_use")
    assert api.delete(location, params={"runs": "delete"}).status_code == 204
    problem(api.get(location), 404, "recording_not_found")
    problem(api.get(f"/api/v1/runs/{run['id']}"), 404, "run_not_found")
    problem(api.delete(location), 404, "recording_not_found")


def test_unchanged_recording_is_304(api: httpx2.Client, recording: dict[str, Any]) -> None:
    first = api.get(f"/api/v1/recordings/{recording['id']}")
    again = api.get(f"/api/v1/recordings/{recording['id']}", headers={"If-None-Match": first.headers["etag"]})
    assert again.status_code == 304
    assert again.content == b""


def test_charts_of_a_recording(api: httpx2.Client, recording: dict[str, Any]) -> None:
    charts = api.get(f"/api/v1/recordings/{recording['id']}/charts").json()["items"]
    assert {"plan", "receptions"} <= {c["name"] for c in charts}
    for chart in charts:
        url = f"/api/v1/recordings/{recording['id']}/charts/{chart['name']}"
        assert api.get(f"{url}.json").json()["data"], chart
        assert api.get(f"{url}.csv").text.startswith("label,trace,role")
        assert api.get(f"{url}.html").headers["content-security-policy"].startswith("sandbox")
