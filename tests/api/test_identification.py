"""Plots of separated radars through the HTTP API: one file per radar given to one run, or one file with a column."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import httpx2
import numpy as np
import pytest

from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from tests.api.conftest import finished, problem

ALGORITHMS = ("assignment", "pairwise_test", "multi_radar_assignment", "track_association")


def flights(**parameters: Any) -> PolarPlots:
    """Two flights 6 km apart, seen by two radars 30 km apart."""
    scenario = scenarios_by_name()["two_radars_tracks"]
    found = scenario.simulate(scenario.parameters(scans=30, speed_mps=250, offset_along_m=6000, **parameters), (0,), 3)
    assert isinstance(found, PolarPlots)
    return found


def site(radars: tuple[int, ...]) -> dict[str, Any]:
    """As each radar's owner would describe it: places in one local frame, with accuracies."""
    described = [
        {"name": "west", "east_m": 0, "north_m": 0, "up_m": 0},
        {"name": "east", "east_m": 30_000, "north_m": 0, "up_m": 0},
    ]
    common = {"sigma_range_m": 100, "sigma_azimuth_deg": 1, "range_kind": "ground"}
    return {
        "origin": {"latitude_deg": 55.0, "longitude_deg": 37.0},
        "radars": [described[k] | common for k in radars],
    }


def text(plots: PolarPlots, rows: np.ndarray, *, named: bool) -> bytes:
    lines = ["time_s,range_m,azimuth_deg,scan" + (",radar" if named else "")]
    for k in rows:
        values = [
            f"{plots.time_s[k]:.3f}", f"{plots.range_m[k, 0]:.3f}", f"{np.degrees(plots.azimuth_rad[k, 0]):.6f}",
            str(plots.scan[k]),
        ]  # fmt: skip
        lines.append(",".join([*values, ("west", "east")[plots.radar[k]]] if named else values))
    return "\n".join(lines).encode()


def uploaded(api: httpx2.Client, name: str, data: bytes, described: dict[str, Any]) -> str:
    answer = api.post(
        "/api/v1/recordings",
        files=[("file", (f"{name}.csv", data, "text/csv"))],
        data={"options": json.dumps({"name": name}), "site": json.dumps(described)},
    )
    assert answer.status_code in (200, 201), answer.text
    found = answer.json()
    assert found["state"] == "ready", found
    return str(found["id"])


def ran(api: httpx2.Client, source: dict[str, Any], *names: str) -> dict[str, Any]:
    body = source | {"algorithms": [{"name": n, "parameters": _told(n)} for n in names]}
    answer = api.post("/api/v1/runs", json=body)
    assert answer.status_code == 202, answer.text
    run = finished(api, answer.headers["location"])
    assert run["state"] == "succeeded", run
    return run


def _told(name: str) -> dict[str, Any]:
    return {"decision": "most_likely"} if name == "track_association" else {}


def table(api: httpx2.Client, run: dict[str, Any], name: str, label: str) -> list[dict[str, Any]]:
    found = api.get(f"/api/v1/runs/{run['id']}/tables/{name}.json", params={"limit": 1000}).raise_for_status().json()
    names = found["columns"]
    rows = [dict(zip(names, row, strict=True)) for row in found["rows"]]
    return [row for row in rows if row["label"] == label]


@pytest.fixture(scope="module")
def parted(api: httpx2.Client) -> dict[str, Any]:
    """A run on one recording per radar."""
    plots = flights()
    ids = [
        uploaded(api, name, text(plots, np.flatnonzero(plots.radar == k), named=False), site((k,)))
        for k, name in enumerate(("west", "east"))
    ]
    return ran(api, {"recording_ids": ids}, *ALGORITHMS)


def test_one_file_per_radar_gives_pairs_with_probabilities_and_fused_places(
    api: httpx2.Client, parted: dict[str, Any]
) -> None:
    plots = flights()
    assert parted["source"]["name"] == "west + east"
    for label in ALGORITHMS[:3]:
        pairs = [row for row in table(api, parted, "associations", label) if row["decision"] == "accepted"]
        assert len(pairs) > 40
        assert {(p["radar_1"], p["radar_2"]) for p in pairs} == {("west", "east")}
        # Rows go on from recording to recording: the second begins where the first one ends.
        assert {p["row_1"] <= 60 < p["row_2"] for p in pairs} == {True}
        places = table(api, parted, "states", label)
        assert len(places) == len(pairs)
        assert {p["used"] for p in places} == {"west east"}
        assert all(0 < p["sigma_east_m"] < 3000 and 0 < p["sigma_north_m"] < 3000 for p in places)
        truth = plots.truth_m[:, :2]
        for place in places:
            miss = np.hypot(*(truth[plots.time_s == place["time_s"]] - [place["east_m"], place["north_m"]]).T)
            assert miss.min() < 6 * place["drms_m"]
    accepted = [r for r in table(api, parted, "associations", "assignment") if r["decision"] == "accepted"]
    assert all(0.95 <= row["probability"] <= 1 for row in accepted)
    assert len([r for r in table(api, parted, "associations", "track_association") if r["decision"] == "accepted"]) == 2


def test_a_column_and_a_file_per_radar_are_the_same_run(api: httpx2.Client, parted: dict[str, Any]) -> None:
    plots = flights()
    one = uploaded(api, "both", text(plots, np.arange(len(plots)), named=True), site((0, 1)))
    whole = ran(api, {"recording_id": one}, "assignment")

    def pairs(run: dict[str, Any]) -> list[tuple[float, float]]:
        rows = table(api, run, "associations", "assignment")
        return sorted((r["statistic"], r["probability"]) for r in rows if r["decision"] == "accepted")

    assert np.array(pairs(whole)) == pytest.approx(np.array(pairs(parted)), rel=1e-6)


def test_charts_and_the_summary_of_several_recordings(api: httpx2.Client, parted: dict[str, Any]) -> None:
    for name in ("pairs_plan", "association_matrix", "pair_statistic", "plan"):
        chart = api.get(f"/api/v1/runs/{parted['id']}/charts/{name}.json").raise_for_status().json()
        assert chart["data"], name
    assert not [n for notes in parted["notes"].values() for n in notes if n["code"] == "registration_alarm"]


def test_a_radar_whose_clock_is_late_is_measured_and_said(api: httpx2.Client) -> None:
    plots = flights(time_offset_s=4.0)
    ids = [
        uploaded(api, f"late {name}", text(plots, np.flatnonzero(plots.radar == k), named=False), site((k,)))
        for k, name in enumerate(("west", "east"))
    ]
    run = ran(api, {"recording_ids": ids}, "assignment")
    said = [n["detail"] for n in run["notes"]["assignment"] if n["code"].startswith("registration_")]
    assert any("too early" in detail for detail in said)
    row = next(r for r in table(api, run, "registration", "assignment") if r["offset"] == "time")
    assert (row["radar"], row["unit"]) == ("east", "s")
    assert row["value"] == pytest.approx(4.0, abs=4 * row["sd"])


def test_radars_that_look_at_different_instants_are_brought_to_one(api: httpx2.Client) -> None:
    plots = flights(time_offset_s=4.0, course_deg=45.0)
    told = replace(plots, time_s=plots.time_s + np.where(plots.radar == 1, 4.0, 0.0))
    told = told.take(np.argsort(told.time_s, kind="stable"))
    both = uploaded(api, "turning", text(told, np.arange(len(told)), named=True), site((0, 1)))
    run = ran(api, {"recording_id": both}, "assignment")
    (note,) = run["notes"]["assignment"]
    assert (note["code"], note["count"]) == ("moved_to_one_instant", 120)
    assert "up to 4 s apart" in note["detail"]
    for place in table(api, run, "states", "assignment"):
        # Half way between the plots of the two radars.
        later = place["time_s"] - told.time_s
        at = (told.truth_m + later[:, None] * told.truth_velocity_mps)[np.abs(np.abs(later) - 2) < 1e-3, :2]
        miss = np.hypot(*(at - [place["east_m"], place["north_m"]]).T)
        assert miss.min() < 5 * place["drms_m"]
    chart = api.get(f"/api/v1/runs/{run['id']}/charts/pair_closeup.json").raise_for_status().json()
    said = [n["text"] for n in chart["layout"]["meta"]["notes"] if n["code"] == "one_instant"]
    assert said == ["The second plot was measured 4.00 s after the first and is drawn as of its instant."]


def test_what_cannot_be_compared_names_the_field(api: httpx2.Client) -> None:
    plots = flights()
    west = uploaded(api, "alone", text(plots, np.flatnonzero(plots.radar == 0), named=False), site((0,)))
    answer = api.post("/api/v1/runs", json={"recording_ids": [west], "algorithms": [{"name": "assignment"}]})
    if answer.status_code == 202:
        run = finished(api, answer.headers["location"])
        assert run["state"] == "failed"
        assert run["error"]["code"] == "one_radar"
    else:
        problem(answer, 422, "one_radar")
    body = {"recording_ids": [west], "algorithms": [{"name": "assignment", "parameters": {"exact_plots": 19}}]}
    problem(api.post("/api/v1/runs", json=body), 422, "validation", "/algorithms/0/parameters/exact_plots")
