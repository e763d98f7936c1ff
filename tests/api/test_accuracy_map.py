"""The accuracy map over HTTP: numbers of table 8.5, its chart, subsets, clocks, and what cannot be computed."""

from __future__ import annotations

import base64
from typing import Any

import httpx2
import numpy as np
import pytest

STATIONS = [
    {"name": str(i + 1), "east_m": e, "north_m": n, "up_m": 15.0}
    for i, (e, n) in enumerate([(5000.0, 8660.254), (5000.0, -8660.254), (-10000.0, 0.0), (0.0, 0.0)])
]
SITE = {"stations": STATIONS, "sigma_toa_ns": 10.0}
# One cell of the map lies at 50 km to the east.
AXES = {
    "east_m": {"start_m": -50_000.0, "stop_m": 50_000.0, "count": 101},
    "north_m": {"start_m": -50_000.0, "stop_m": 50_000.0, "count": 101},
}


def ask(api: httpx2.Client, **body: Any) -> httpx2.Response:
    return api.post("/api/v1/accuracy-map", json={"site": SITE, **AXES, **body})


def values(answer: dict[str, Any]) -> np.ndarray[Any, Any]:
    packed = answer["values"]
    shape = tuple(int(n) for n in packed["shape"].split(","))
    return np.frombuffer(base64.b64decode(packed["bdata"]), packed["dtype"]).reshape(shape)


@pytest.mark.parametrize(
    ("variant", "printed"), [("space", 296.0), ("altitude_measured", 178.0), ("altitude_known", 123.0)]
)
def test_the_map_is_table_8_5(api: httpx2.Client, variant: str, printed: float) -> None:
    answer = ask(api, variant=variant, sigma_altitude_m=100.0).json()
    assert values(answer)[50, 100] == pytest.approx(printed, abs=0.6)
    ratio = ask(api, variant=variant, sigma_altitude_m=100.0, quantity="gdop").json()
    np.testing.assert_allclose(values(ratio), values(answer) / 2.99792458, rtol=1e-5)


def test_the_chart_holds_the_map_and_the_stations(api: httpx2.Client) -> None:
    answer = ask(api, stations=["1", "3", "4"], variant="altitude_known").json()
    heat, lines, words, stations = answer["chart"]["data"]
    assert lines["meta"]["role"] == words["meta"]["role"] == "bound"
    assert len(words["text"]) >= 3
    assert all(word.endswith(" m") for word in words["text"])
    assert heat["type"] == "heatmap"
    assert heat["z"]["shape"] == "101, 101"
    assert stations["text"] == ["1", "2", "3", "4"]
    assert stations["marker"]["symbol"].count("triangle-up-open") == 1, "the station that does not receive is hollow"
    layout = answer["chart"]["layout"]
    assert layout["xaxis"]["title"]["text"] == "East, km"
    assert layout["yaxis"]["scaleanchor"] == "x"


def test_subsets_and_clocks(api: httpx2.Client) -> None:
    answer = ask(api, variant="altitude_known", subsets=True).json()
    assert [s["stations"] for s in answer["subsets"]][:2] == [["1", "2", "3", "4"], ["1", "2", "3"]]
    assert len(answer["subsets"]) == 5
    whole = answer["subsets"][0]
    assert whole["common_ratio"] == 1.0
    assert all(s["common_ratio"] > 1.0 and s["median"] > whole["median"] for s in answer["subsets"][1:])
    assert [c["station"] for c in answer["clocks"]] == ["1", "2", "3", "4"]
    assert all(0 < c["median_m_per_ns"] < c["largest_m_per_ns"] for c in answer["clocks"])


def test_three_stations_in_space_have_no_number(api: httpx2.Client) -> None:
    answer = ask(api, stations=["1", "2", "3"]).json()
    assert answer["observable_share"] == 0
    assert answer["median"] is None
    assert answer["chart"]["layout"]["meta"]["not_applicable"] == "nothing_observable"


def test_the_site_of_a_preset(api: httpx2.Client) -> None:
    body = {"scenario": {"preset": "four_station_circuit"}, "variant": "altitude_gain"}
    answer = api.post("/api/v1/accuracy-map", json=body).json()
    assert len(answer["site"]["stations"]) == 4
    assert answer["median"] > 1, "a known altitude cannot cost accuracy"


@pytest.mark.parametrize(
    ("change", "status", "pointer"),
    [
        ({"site": {"stations": STATIONS[:1]}}, 422, "/site"),
        ({"site": {"radars": [{"name": "A", "east_m": 0.0, "north_m": 0.0}]}}, 422, "/site"),
        ({"site": {"stations": [*STATIONS, STATIONS[0] | {"name": "5"}]}}, 422, "/site"),
        ({"recording_id": "x"}, 422, ""),
        ({"stations": ["1", "9"]}, 422, "/stations/1"),
        ({"stations": ["1"]}, 422, "/stations"),
        ({"sigma_altitude_m": 0}, 422, "/sigma_altitude_m"),
        ({"east_m": {"start_m": 5.0, "stop_m": 1.0, "count": 10}}, 422, "/east_m"),
        ({"east_m": {"start_m": -1.0, "stop_m": 1.0, "count": 1000},
          "north_m": {"start_m": -1.0, "stop_m": 1.0, "count": 1000}}, 413, "/east_m/count"),
        ({"altitude": 3}, 422, "/altitude"),
    ],
)  # fmt: skip
def test_what_cannot_be_mapped_is_named(api: httpx2.Client, change: dict[str, Any], status: int, pointer: str) -> None:
    answer = ask(api, **change)
    assert answer.status_code == status, answer.text
    assert any(e["pointer"].startswith(pointer) for e in answer.json()["errors"]), answer.text


def test_an_unknown_recording_or_preset(api: httpx2.Client) -> None:
    assert api.post("/api/v1/accuracy-map", json={"recording_id": "nothing"}).status_code == 404
    answer = api.post("/api/v1/accuracy-map", json={"scenario": {"preset": "nothing"}})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["pointer"] == "/scenario/preset"


def test_a_map_wider_than_the_earth(api: httpx2.Client) -> None:
    wide = {"start_m": -2e6, "stop_m": 2e6, "count": 50}
    answer = ask(api, east_m=wide, north_m=wide)
    assert answer.status_code == 200, "two thousand kilometres are still on the Earth"
