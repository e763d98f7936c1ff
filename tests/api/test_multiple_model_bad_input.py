"""What specification 17 refuses of a file or before a run, as a client sees it; the rest: unit test_bad_input.py."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest

from tests.api.conftest import problem
from tests.api.test_multiple_model import ANTENNA, ran, table, uploaded

HEAD = "time_s,range_m,bicone_elevation_deg,bicone_azimuth_deg"
TWO = [{"kind": "cv", "sigma_mps2": 1}, {"kind": "ca", "sigma_mps2": 1}]
ROOTLESS = {"models": TWO, "transition": [[0.1, 0.9], [0.9, 0.1]], "transition_step_s": 1.0}
"""Its half power has no probabilities; its whole powers have."""
CALM = {"models": TWO, "transition": [[0.9, 0.1], [0.1, 0.9]]}


def recorded(api: httpx2.Client, name: str, times: list[Any]) -> str:
    """An object that comes nearer by 100 m/s, seen at these times."""
    rows = [f"{t},{100_000 - 100 * float(t):g},10,5" for t in times]
    return uploaded(api, name, "\n".join([HEAD, *rows]).encode(), {"radars": [ANTENNA]})


def asked(api: httpx2.Client, parameters: dict[str, Any], **source: Any) -> httpx2.Response:
    return api.post(
        "/api/v1/runs", json={"algorithms": [{"name": "multiple_model", "parameters": parameters}], **source}
    )


def test_late_and_endless_times_are_said_of_the_recording(api: httpx2.Client) -> None:
    """A late row is brought into order and said so; a time that is none is a rejected row. The filter sees neither."""
    found = recorded(api, "late and endless", [0, 1, "inf", 3, 2, 4])
    recording = api.get(f"/api/v1/recordings/{found}").json()
    assert [w["code"] for w in recording["warnings"]] == ["rows_out_of_order"]
    assert [(r["row"], r["code"]) for r in recording["rejections"]] == [(3, "not_finite")]
    run = ran(api, found, [{"name": "multiple_model"}])
    assert [row["time_s"] for row in table(api, run, "states")] == [0, 1, 2, 3, 4]


def test_an_accuracy_of_zero_is_no_site(api: httpx2.Client) -> None:
    files = [("file", ("zero.csv", f"{HEAD}\n0,1,1,1".encode(), "text/csv"))]
    site = '{"radars": [{"name": "a", "east_m": 0, "north_m": 0, "up_m": 0, "sigma_range_m": 0}]}'
    answer = api.post("/api/v1/recordings", files=files, data={"options": "{}", "site": site})
    problem(answer, 422, "site_invalid", "/site/radars/0/sigma_range_m")


def test_a_matrix_without_a_root_is_refused_before_a_run(api: httpx2.Client) -> None:
    """Of a recording and of a scenario; whole powers are legal. A swept matrix is named as the sweep's."""
    where = "/algorithms/0/parameters/transition"
    uneven = recorded(api, "uneven", [0, 1, 2.5, 3])
    found = problem(asked(api, ROOTLESS, recording_id=uneven), 422, "validation", where)
    assert found["errors"][0]["code"] == "transition_root"
    assert "irregular times" in found["errors"][0]["detail"]
    irregular = {"preset": "aeroballistic", "parameters": {"timing": "irregular", "rate_hz": 1, "duration_s": 20}}
    found = problem(asked(api, ROOTLESS, scenario=irregular, trials=2), 422, "validation", where)
    assert found["errors"][0]["code"] == "transition_root"
    sweep = {"multiple_model.transition": [CALM["transition"], ROOTLESS["transition"]]}
    swept = asked(api, CALM | {"transition_step_s": 1.0}, scenario=irregular, trials=2, sweep=sweep)
    problem(swept, 422, "validation", "/sweep/multiple_model.transition")
    assert ran(api, recorded(api, "even", [0, 1, 2, 3]), [{"name": "multiple_model", "parameters": ROOTLESS}])


@pytest.mark.parametrize(
    ("region", "where", "words"),
    [
        ({"corners": [[0, 0], [1, 1]]}, "/corners", "2 distinct corners and needs three"),
        ({"corners": [[0, 0], [1, 1], [2, 2]]}, "/corners", "area is zero"),
        (
            {"name": "bow", "corners": [[0, 0], [9, 9], [9, 0], [0, 9]]},
            "/corners",
            "Region 2 'bow': the edge from corner 1 to 2",
        ),
        ({"corners": [[0, 0], [1, 1], [1e9, 2]]}, "/corners/2/0", "10000000"),
        ({"lowest_up_m": 5, "highest_up_m": 1}, "", "above its lowest"),
        ({"transition": [[0.9, 0.1], [0.1, 0.8]]}, "/transition/1", "Row 2"),
    ],
)
def test_a_region_that_is_none_is_named(api: httpx2.Client, region: dict[str, Any], where: str, words: str) -> None:
    regions = [{"transition": CALM["transition"]}, {"transition": CALM["transition"], **region}]
    answer = asked(api, {**CALM, "regions": regions}, scenario={"preset": "straight_flight"}, trials=2)
    found = problem(answer, 422, "validation", f"/algorithms/0/parameters/regions/1{where}")
    assert words in found["errors"][0]["detail"]
