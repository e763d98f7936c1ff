"""Recorded tracks become the targets of a scenario, which is then looked at, simulated and stored."""

from __future__ import annotations

import gzip
import json
from typing import Any

import httpx2
import pymap3d
import pytest

from tests.api.conftest import problem

# Two aircraft that fly north and east, a report every five seconds; feet.
LINES = "".join(
    f",,2026-05-01T10:00:{5 * i:02d}.250Z,{name},{55 + i * north:.5f},{37 + i * east:.5f},{10_000 + 100 * i},\n"
    for name, north, east in (("A", 0.01, 0.0), ("B", 0.0, 0.02))
    for i in range(12)
)
ORIGIN = {"latitude_deg": 55.0, "longitude_deg": 37.0, "height_m": 0.0}


def sent(api: httpx2.Client, content: bytes = LINES.encode(), **options: Any) -> httpx2.Response:
    asked = {"preset": "four_station_circuit", **options}
    return api.post(
        "/api/v1/scenarios/from-tracks",
        files=[("file", ("tracks.csv", content))],
        data={"options": json.dumps(asked)},
    )


def test_recorded_tracks_are_flown_again(api: httpx2.Client) -> None:
    answer = sent(api, gzip.compress(LINES.encode()), parameters={"origin": ORIGIN, "sigma_toa_ns": 5.0})
    assert answer.status_code == 200, answer.text
    made = answer.json()
    assert made["start_utc"] == "2026-05-01T10:00:00Z"
    assert [(t["name"], t["reports"], t["points"], t["problem"]) for t in made["tracks"]] == [
        ("A", 12, 5, ""),
        ("B", 12, 5, ""),
    ]
    assert made["parameters"]["sigma_toa_ns"] == 5.0
    assert made["parameters"]["legs"] == []
    request = {"preset": made["preset"], "parameters": made["parameters"]}
    shown = api.post("/api/v1/scenarios/preview", json=request)
    assert shown.json()["targets"] == ["A", "B"]
    stored = api.post("/api/v1/scenarios/recording", json={**request, "name": "flown again"})
    assert stored.status_code == 201, stored.text
    lines = api.get(f"/api/v1/recordings/{stored.json()['id']}/data.csv").text.splitlines()
    names = lines[0].split(",")
    place = [names.index(n) for n in ("true_east_m", "true_north_m", "true_up_m")]
    last = [line.split(",") for line in lines[1:] if line.split(",")[names.index("target")] == "B"][-1]
    # 55.25 s after the whole second: what the last report of B says, in the frame of the origin.
    assert float(last[names.index("time_s")]) == pytest.approx(55.25)
    expected = pymap3d.geodetic2enu(55.0, 37.22, 11_100 * 0.3048, 55.0, 37.0, 0.0)
    assert [float(last[k]) for k in place] == pytest.approx(expected, abs=0.1)


def test_without_an_origin_the_middle_of_the_tracks_is_one(api: httpx2.Client) -> None:
    made = sent(api).json()
    assert made["parameters"]["origin"] == {"latitude_deg": 55.0, "longitude_deg": 37.0, "height_m": 0.0}


def test_a_track_that_cannot_be_flown_is_told_and_the_others_stay(api: httpx2.Client) -> None:
    # C climbs 60 km in ten seconds and is back: no jump from report to report, but a curve into the ground.
    dive = "".join(
        f",,2026-05-01T10:00:{s:02d}Z,C,55.1,37.1,{feet},\n" for s, feet in ((0, 0), (20, 0), (40, 60_000), (59, 0))
    )
    made = sent(api, (LINES + dive).encode(), parameters={"origin": ORIGIN}).json()
    assert [(t["name"], bool(t["problem"])) for t in made["tracks"]] == [("A", False), ("B", False), ("C", True)]
    assert [t["name"] for t in made["parameters"]["targets"]] == ["A", "B"]
    assert "ground" in made["tracks"][2]["problem"]


@pytest.mark.parametrize(
    ("change", "code", "pointer"),
    [
        ({"preset": "nowhere"}, "scenario_not_found", "/options/preset"),
        ({"parameters": {"targets": []}}, "parameter", "/options/parameters/targets"),
        ({"parameters": {"sigma_toa_ns": -1}}, "validation", "/options/parameters/sigma_toa_ns"),
        ({"tracks": {"targets": ["Z"]}}, "track_unknown", "/options/tracks/targets/0"),
        ({"tracks": {"spacing_s": -1}}, "validation", "/options/tracks/spacing_s"),
        ({"content": b"time_s,range_m\n0,1\n"}, "missing_column", "/file"),
    ],
)
def test_what_cannot_be_made_names_the_field(
    api: httpx2.Client, change: dict[str, Any], code: str, pointer: str
) -> None:
    problem(sent(api, **change), 422, code, pointer)


def test_a_form_must_be_complete(api: httpx2.Client) -> None:
    files = [("file", ("tracks.csv", LINES.encode()))]
    problem(api.post("/api/v1/scenarios/from-tracks", files=files), 422, "validation", "/options")
    both = {"options": "{}", "site": "{}"}
    problem(api.post("/api/v1/scenarios/from-tracks", files=files, data=both), 422, "validation", "/site")
    problem(api.post("/api/v1/scenarios/from-tracks", json={}), 415, "unsupported_media_type")
