"""A look into files: what they hold, what it may mean, what reading would give; and nothing is stored."""

from __future__ import annotations

import json
from typing import Any

import httpx2

from tests.api.conftest import ServerProcess, problem

FOREIGN = b"ToD (ms),Rho [NM],Theta,note\n" + b"".join(
    b"%d,%d,%d,%s\n" % (1000 * i, 20 + i, 30 * i, b"ab"[i % 2 : i % 2 + 1]) for i in range(12)
)


def look(api: httpx2.Client, data: bytes, **options: Any) -> httpx2.Response:
    fields = {"options": json.dumps(options)}
    return api.post("/api/v1/recordings/preview", files=[("file", ("foreign.csv", data))], data=fields)


def test_a_foreign_file_and_its_suggestion(api: httpx2.Client) -> None:
    found = look(api, FOREIGN).raise_for_status().json()
    assert found["format"] is None
    assert found["columns"] == ["ToD (ms)", "Rho [NM]", "Theta", "note"]
    assert found["rows"][1] == ["1000", "21", "30", "b"]
    assert found["trial"] is None
    assert found["error"]["code"] == "unsupported_format"
    assert found["suggestion"]["kind"] == "polar_plots"
    assert found["suggestion"]["mapping"]["range_m"] == {"column": "Rho [NM]", "unit": "NM", "minus": None}
    units = {c["name"]: c["units"] for c in found["native_columns"]["polar_plots"]}
    assert units["range_m"][0] == "m"
    assert "NM" in units["range_m"]


def test_the_suggestion_taken_as_it_is_can_be_read(api: httpx2.Client) -> None:
    mapping = look(api, FOREIGN).json()["suggestion"]["mapping"]
    found = look(api, FOREIGN, mapping=mapping, kind="polar_plots", where={"note": "a"}).json()
    assert found["trial"]["rows"] == {"read": 6, "accepted": 6, "rejected": 0}
    assert found["trial"]["time_span_s"] == [0, 10]
    assert found["error"] is None


def test_counts_and_reasons_of_rejected_rows(api: httpx2.Client, marks: bytes) -> None:
    found = look(api, marks.replace(b"\n", b"\nnoon,1,2,3,4,5,6,7,8,9\n", 1)).raise_for_status().json()
    assert found["format"] == "native_csv"
    assert found["trial"]["rows"]["rejected"] == 1
    assert found["trial"]["rejections"][0]["row"] == 1


def test_nothing_is_stored(api: httpx2.Client, server: ServerProcess) -> None:
    before = (api.get("/api/v1/recordings").json(), sorted((server.data / "store").rglob("*")))
    look(api, FOREIGN + b"99000,1,1,x\n").raise_for_status()
    assert (api.get("/api/v1/recordings").json(), sorted((server.data / "store").rglob("*"))) == before


def test_stored_bytes_with_other_options(api: httpx2.Client, recording: dict[str, Any]) -> None:
    again = {"from_recording_id": recording["id"]}
    found = api.post("/api/v1/recordings/preview", json=again).raise_for_status().json()
    assert found["trial"]["rows"] == recording["rows"]
    wrong = {**again, "options": {"mapping": {"time_s": "nowhere"}}}
    found = api.post("/api/v1/recordings/preview", json=wrong).raise_for_status().json()
    assert found["error"]["pointer"] == "/options/mapping/time_s/column"
    truth = {**again, "truth": "time_s,true_east_m\n1,2\n"}
    found = api.post("/api/v1/recordings/preview", json=truth).raise_for_status().json()
    assert found["error"]["pointer"] == "/truth"


def test_what_cannot_be_looked_into(api: httpx2.Client) -> None:
    problem(look(api, b"PK\x03\x04" + bytes(50)), 422, "damaged_archive", "/file")
    problem(look(api, FOREIGN, mapping=3), 422, "validation", "/options/mapping")
    problem(api.post("/api/v1/recordings/preview", files=[("sight", b"x")]), 422, "validation", "/file")
    problem(api.post("/api/v1/recordings/preview", content=b"x"), 415, "unsupported_media_type")
    problem(
        api.post("/api/v1/recordings/preview", json={"from_recording_id": "nobody"}),
        422, "recording_not_found", "/from_recording_id",
    )  # fmt: skip
