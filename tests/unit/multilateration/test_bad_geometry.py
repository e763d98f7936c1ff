"""Bad geometry and bad data: the status says what is the matter; no number that the data cannot support is shown."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.multilateration import mlat_imm, rdf, rdfv, single_mark
from algorithms.multilateration.lanes import REASON_CODES, STATUS
from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.receivers import assess_receivers
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.site import Site
from algorithms.spec import LocalContext

C = 299_792_458.0
FLAT = ((5_000.0, 8_660.0, 15.0), (5_000.0, -8_660.0, 15.0), (-10_000.0, 0.0, 15.0), (0.0, 0.0, 15.0))
LINE = ((-10_000.0, 0.0, 10.0), (-3_000.0, 0.0, 10.0), (4_000.0, 0.0, 10.0), (10_000.0, 0.0, 10.0))
FILTERS = (rdf, rdfv, mlat_imm)
METHODS = (single_mark, *FILTERS)


def flight(place: tuple[float, float, float], velocity: tuple[float, float, float], marks: int = 40) -> np.ndarray:
    return np.array(place) + np.arange(marks)[:, None] * np.array(velocity)


def heard(stations: Any, truth: np.ndarray, *, altitude: bool, by: tuple[int, ...] | None = None) -> ToaMarks:
    """Marks a second apart, with 10 ns of noise and exact altitudes."""
    places = np.array(stations)
    distance = np.linalg.norm(truth[:, None] - places, axis=2)
    toa = distance / C + np.random.default_rng(3).standard_normal(distance.shape) * 10e-9
    if by is not None:
        toa[:, [s for s in range(len(places)) if s not in by]] = np.nan
    height = np.hypot(6_371_000.0 + truth[:, 2], np.hypot(truth[:, 0], truth[:, 1])) - 6_371_000.0
    names = tuple(str(i + 1) for i in range(len(places)))
    site = {"stations": [
        {"name": n, "east_m": p[0], "north_m": p[1], "up_m": p[2]} for n, p in zip(names, places, strict=True)
    ], "sigma_toa_ns": 10.0, "sigma_altitude_m": 30.0}  # fmt: skip
    return ToaMarks(
        time_s=np.arange(len(truth), dtype=float), row=np.arange(1, len(truth) + 1), target=np.zeros(len(truth), int),
        truth_m=truth, toa_s=toa[:, :, None], stations=names, site=Site.model_validate(site),
        altitude_m=height[:, None] if altitude else np.full((len(truth), 1), np.nan),
    )  # fmt: skip


def run(module: Any, recording: ToaMarks) -> Result:
    result: Result = module.run(recording, module.ALGORITHM.parameters(), LocalContext())
    return result


def reasons(result: Result) -> set[str]:
    return {REASON_CODES[i] for i in result.arrays["reason"][:, 0]} - {"", "too_few_marks"}


def statuses(result: Result) -> list[str]:
    return [STATUS[i] for i in result.arrays["status"][:, 0]]


def errors(recording: ToaMarks, result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal error and claim of every mark."""
    a = result.arrays
    off = np.hypot(*(a["state"][:, [0, 3], 0] - recording.truth_m[:, :2]).T)
    last = 9 if a["covariance"].shape[1] == 45 else 2
    return off, np.sqrt(a["covariance"][:, 0, 0] + a["covariance"][:, last, 0])


@pytest.mark.parametrize("altitude", [True, False])
@pytest.mark.parametrize("module", METHODS)
def test_stations_in_one_line_show_no_position_and_say_so(module: Any, altitude: bool) -> None:
    recording = heard(LINE, flight((5_000, 20_000, 3_000), (100, 20, 0)), altitude=altitude)
    result = run(module, recording)
    assert not np.isfinite(result.arrays["state"][:, 0, 0]).any()
    assert "stations_in_line" in {note.code for note in result.notes}
    if module is not single_mark:
        assert reasons(result) == {"several_positions"}
    beside = (*LINE[:3], (10_000.0, 8_000.0, 10.0))
    assert "stations_in_line" not in {n.code for n in run(module, replace_site(recording, beside)).notes}


def replace_site(recording: ToaMarks, stations: Any) -> ToaMarks:
    return heard(stations, recording.truth_m, altitude=True)


@pytest.mark.parametrize("module", METHODS)
def test_two_receptions_by_the_same_pair_for_ever_show_nothing(module: Any) -> None:
    recording = heard(FLAT, flight((20_000, 20_000, 3_000), (-100, 20, 0)), altitude=True, by=(0, 1))
    result = run(module, recording)
    assert not np.isfinite(result.arrays["state"][:, 0, 0]).any()
    assert reasons(result) == {"no_start_from_one_mark"} if module is single_mark else {"same_pair"}


@pytest.mark.parametrize("module", METHODS)
@pytest.mark.parametrize("height", [3_000.0, 16.0])
def test_an_emitter_above_a_station_is_found_within_its_claim(module: Any, height: float) -> None:
    """One metre above it too, where its direction turns by half a turn within a mark."""
    recording = heard(FLAT, flight((-20, 0, height), (1, 0, 0)), altitude=height < 100)
    off, claim = errors(recording, run(module, recording))
    assert np.isfinite(off).all()
    assert (off < 4 * claim).all()
    assert off.max() < 20


def test_roots_that_cannot_be_told_apart_stay_ambiguous() -> None:
    """Specification 9.3: an emitter that stands still, three stations and an altitude."""
    recording = heard(FLAT, flight((5_000, 22_000, 5_960), (0, 0, 0), 12), altitude=True, by=(1, 2, 3))
    result = run(single_mark, recording)
    assert set(statuses(result)) == {"ambiguous"}
    assert not np.isfinite(result.arrays["state"][:, 0, 0]).any()
    roots = result.arrays["roots_m"][:, :, :2, 0]
    true = np.hypot(*(roots - recording.truth_m[:, None, :2]).transpose(2, 0, 1)).min(axis=1)
    assert np.median(true) < 400
    assert statuses(run(rdfv, recording))[0] == "initialised"
    assert reasons(run(rdfv, recording)) >= {"two_positions"}


def test_a_fix_below_the_ground_is_the_mirror_image_of_one_above() -> None:
    recording = heard(FLAT, flight((9_000, 3_000, 3_000), (0, 20, 0)), altitude=False)
    up = run(single_mark, recording).arrays["state"][:, 6, 0]
    assert (up > 0).all()
    assert np.median(np.abs(up - 3_000)) < 200


def test_a_clock_that_jumps_is_left_out_named_and_seen_in_the_statuses() -> None:
    recording = heard(FLAT, flight((30_000, 10_000, 3_000), (-100, 20, 0), 120), altitude=True)
    toa = recording.toa_s.copy()
    toa[60:, 1] += 5e-6
    jumped = replace(recording, toa_s=toa)
    result = run(mlat_imm, jumped)
    off, claim = errors(jumped, result)
    assert off.max() < 4 * claim.max()
    assert off[60:].max() < 300, "a jump of 1500 m"
    assert {REASON_CODES[i] for i in result.arrays["reason"][60:, 0]} == {"reception_left_out"}
    assert not result.arrays["used"][60:, 1].any()
    assert set(statuses(run(single_mark, jumped))[60:]) == {"residual_gate"}
    words = statuses(run(rdf, jumped))
    assert set(words[1:60]) == {"updated"}
    assert "updated" not in words[60:], "without altitude nothing tells which one lies, but that one does"


def test_without_altitude_a_jumped_clock_does_not_throw_the_track_about() -> None:
    """A jump of 300 m is impossible from some sides only. Fixes that fit no place restart nothing."""
    recording = heard(FLAT, flight((20_000, 12_000, 3_000), (-150, 0, 0), 300), altitude=False)
    toa = recording.toa_s.copy()
    toa[150:, 1] += 1e-6
    jumped = replace(recording, toa_s=toa)
    result = run(rdf, jumped)
    words, why = statuses(result), [REASON_CODES[i] for i in result.arrays["reason"][:, 0]]
    assert words.count("reinitialised") <= 2
    assert {"impossible_reception", "doubtful_reception", "residual"} <= set(why)
    off, claim = errors(jumped, result)
    shown = np.isfinite(off)
    assert off[shown].max() < 6_000, "98 km when every fix was believed"
    assert not result.arrays["used"][:, 1, 0][[w == "doubtful_reception" for w in why]].any()
    row = mlat_imm.tabulate(jumped, result)["decisions"].columns
    assert any(r.endswith("station 2") for r in row["reason"] if "a moment ago" in r)
    assert (off[:150] < 5 * claim[:150]).all()


def test_one_late_reception_leaves_its_station_believed() -> None:
    recording = heard(FLAT, flight((20_000, 12_000, 3_000), (-150, 0, 0), 40), altitude=False)
    toa = recording.toa_s.copy()
    toa[20, 1] += 60e-6
    result = run(rdf, replace(recording, toa_s=toa))
    assert [REASON_CODES[i] for i in result.arrays["reason"][20:23, 0]] == ["impossible_reception", "", ""]
    assert result.arrays["used"][21:, 1].all()


def test_a_position_below_the_ground_is_not_shown() -> None:
    """Stations on hills tell above from below; a state below the ground beyond its own error ends the track."""
    hills = ((5_000.0, 8_660.0, 1_500.0), (5_000.0, -8_660.0, 300.0), (-10_000.0, 0.0, 15.0), (0.0, 0.0, 900.0),
             (9_000.0, 14_000.0, 2_500.0))  # fmt: skip
    under = heard(hills, flight((9_000, 3_000, -3_000), (0, 20, 0)), altitude=False)
    state = np.zeros(9)
    state[[0, 3, 4, 6]] = 9_000, 3_000, 20, -3_000
    for module in FILTERS:
        start = {"mode": "given", "state": tuple(state), "sd": (100.0, 10.0, 1.0)}
        told = module.ALGORITHM.parameters.model_validate({"start": start})
        result: Result = module.run(under, told, LocalContext())
        assert "impossible_height" in reasons(result), module
        assert not np.isfinite(result.arrays["state"][:, 0]).any(), module
    assert not np.isfinite(run(single_mark, under).arrays["state"]).any()


@pytest.mark.parametrize("module", [rdfv, mlat_imm])
def test_between_two_roots_the_claim_reaches_to_the_other(module: Any) -> None:
    recording = heard(FLAT, flight((5_000, 22_000, 5_960), (100, 0, 0)), altitude=True, by=(1, 2, 3))
    result = run(module, recording)
    off, claim = errors(recording, result)
    open_ = np.array([w in ("ambiguous", "initialised") for w in statuses(result)])
    assert open_.sum() >= 2
    assert off[open_].max() > 5_000, "the wrong one is shown at first"
    assert (off < 4 * claim).all()
    assert claim[~open_].max() < 500


def test_a_station_that_lies_is_named() -> None:
    five = (*FLAT, (9_000.0, 14_000.0, 60.0))
    recording = heard(five, flight((30_000, 10_000, 3_000), (-150, 20, 0), 200), altitude=True)
    toa = recording.toa_s.copy()
    toa[:, 2] += 1e-6
    verdicts = assess_receivers(replace(recording, toa_s=toa), AltitudeParameters())
    assert [i for i, v in enumerate(verdicts) if v.suspect] == [2]
