"""What becomes of single marks: every status and edge case of specification 11 that an algorithm decides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.errors import ParameterError, RecordingError
from algorithms.multilateration import lanes, rdf, rdfv, single_mark
from algorithms.multilateration.concluding import _repair
from algorithms.multilateration.scenario import CircuitParameters, four_stations, simulate
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.site import Site
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.symmetric import unpack

C = 299_792_458.0


def straight(marks: int = 60, trials: int = 1, step: float = 1.0) -> ToaMarks:
    """Return the start of the circuit, nearer to the stations: complete marks on a straight leg."""
    recording = simulate(CircuitParameters(sigma_altitude_m=30.0), tuple(range(trials)), 4)
    part = recording.take(np.arange(300, 300 + marks))
    return replace(part, time_s=np.arange(marks) * step, row=np.arange(1, marks + 1))


def filtered(recording: ToaMarks, altitude: bool = True, **parameters: object) -> Result:
    module = rdfv if altitude else rdf
    declared = module.ALGORITHM.parameters
    return module.run(recording, declared(**parameters), LocalContext())


def solved(recording: ToaMarks, **parameters: object) -> Result:
    return single_mark.run(recording, single_mark.SingleMarkParameters(**parameters), LocalContext())


def words(result: Result) -> list[str]:
    return [lanes.STATUS[i] for i in result.arrays["status"][:, 0]]


def changed(recording: ToaMarks, k: int, toa: object = None, altitude: float | None = None) -> ToaMarks:
    toa_s, altitude_m = recording.toa_s.copy(), recording.altitude_m.copy()
    if toa is not None:
        toa_s[k, :, 0] = toa
    if altitude is not None:
        altitude_m[k, 0] = altitude
    return replace(recording, toa_s=toa_s, altitude_m=altitude_m)


NONE = [np.nan] * 4


def test_a_clean_recording_starts_once_and_updates() -> None:
    result = filtered(straight())
    assert words(result)[0] == "initialised"
    assert words(result)[1:] == ["updated"] * 59
    assert (result.arrays["track"] == 1).all()


def test_no_reception_and_no_altitude_coasts() -> None:
    recording = changed(straight(), 30, NONE, np.nan)
    result = filtered(recording)
    assert words(result)[30] == "coast"
    p = result.arrays["covariance"][:, 0, 0]
    assert p[30] > p[29], "the claimed error grows while coasting"
    assert result.arrays["dof"][30, 0] == 0
    assert np.isnan(result.arrays["nis"][30, 0])


def test_altitude_alone_updates_rdfv_and_not_rdf() -> None:
    recording = changed(straight(), 30, NONE)
    assert words(filtered(recording))[30] == "altitude_only"
    assert words(filtered(recording, altitude=False))[30] == "coast"
    one = changed(straight(), 30, [0.0, np.nan, np.nan, np.nan])
    assert words(filtered(one))[30] == "altitude_only"
    assert filtered(one).arrays["dof"][30, 0] == 1


def test_infinite_values_are_dropped_item_by_item() -> None:
    recording = straight()
    toa = recording.toa_s[30, :, 0].copy()
    toa[1] = np.inf
    result = filtered(changed(recording, 30, toa, np.inf))
    assert words(result)[30] == "updated"
    assert result.arrays["used"][30, :, 0].tolist() == [True, False, True, True]
    assert not result.arrays["altitude_used"][30, 0]
    assert result.arrays["dof"][30, 0] == 2


def test_what_a_row_used_is_told_in_words() -> None:
    recording = straight(trials=2)
    toa, altitude = recording.toa_s.copy(), recording.altitude_m.copy()
    toa[30, 1, 1] = np.nan
    altitude[31, 0] = np.nan
    toa[32, :, 0] = np.nan
    altitude[32, 0] = np.nan
    recording = replace(recording, toa_s=toa, altitude_m=altitude)
    words = rdfv.ALGORITHM.tabulate(recording, filtered(recording))["states"].columns["used"]
    every = " ".join(recording.stations)
    assert words[30] == f"{every} altitude", "rows go trial by trial"
    assert words[31] == every
    assert words[32] is None
    names = [name for i, name in enumerate(recording.stations) if i != 1]
    assert words[60 + 30] == " ".join([*names, "altitude"])


def test_an_impossible_reception_is_left_out_and_named() -> None:
    recording = straight()
    toa = recording.toa_s[30, :, 0].copy()
    toa[0] += 1e-3  # 300 km between stations 17 km apart
    bad, gone = toa.copy(), toa.copy()
    gone[0] = np.nan
    for method in (filtered, solved):
        result = method(changed(recording, 30, bad))
        assert lanes.REASON_CODES[result.arrays["reason"][30, 0]] == "impossible_reception"
        assert result.arrays["used"][30, :, 0].tolist() == [False, True, True, True]
        without = method(changed(recording, 30, gone))
        np.testing.assert_array_equal(result.arrays["state"], without.arrays["state"])
        decisions = rdfv.ALGORITHM.tabulate(changed(recording, 30, bad), result)["decisions"].columns
        assert any(str(r).endswith("the others did; station 1") for r in decisions["reason"])


def test_an_impossible_spread_that_no_single_reception_explains_rejects_the_mark() -> None:
    recording = straight()
    toa = recording.toa_s[30, :, 0].copy()
    toa[0] += 1e-3
    toa[1] -= 1e-3
    two = np.array([toa[0], toa[1], np.nan, np.nan])
    for wrong in (toa, two):
        for result in (filtered(changed(recording, 30, wrong)), solved(changed(recording, 30, wrong))):
            assert words(result)[30] == "impossible_toa"
            assert not result.arrays["used"][30].any()
    assert np.isfinite(filtered(changed(recording, 30, toa)).arrays["state"][30, 0, 0]), "the track goes on"
    # The article's profile has no such rule.
    started = {"mode": "given", "state": tuple(filtered(recording).arrays["state"][29, :, 0]), "sd": (50, 20, 1)}
    article = filtered(
        changed(recording, 30, recording.toa_s[30, :, 0] * [1e4, 1, 1, 1]), profile="article", start=started
    )
    assert words(article)[30] == "impossible_toa"


def test_a_late_reception_is_downweighted_and_does_no_harm() -> None:
    recording = straight()
    toa = recording.toa_s[40, :, 0].copy()
    toa[1] += 5e-6  # 1 500 m
    result = filtered(changed(recording, 40, toa))
    assert words(result)[40] == "downweighted"
    error = np.linalg.norm(result.arrays["state"][:, [0, 3], 0] - recording.truth_m[:, :2], axis=1)
    assert error[41:].max() < 400
    article = filtered(changed(recording, 40, toa), profile="article")
    assert words(article)[40] == "updated"
    lost = np.linalg.norm(article.arrays["state"][:, [0, 3], 0] - recording.truth_m[:, :2], axis=1)
    assert lost[40:].max() > 5_000, "without a rule one such mark destroys the track"


def test_a_gap_closes_the_track_and_a_new_one_starts() -> None:
    recording = straight()
    time = recording.time_s.copy()
    time[30:] += 61.0
    recording = replace(recording, time_s=time)
    result = filtered(recording)
    assert words(result)[30] == "initialised"
    assert result.arrays["track"][29:31, 0].tolist() == [1, 2]
    table = rdfv.ALGORITHM.tabulate(recording, result)["tracks"]
    assert list(table.columns["reason"]) == ["no update for 60 s", "end of the recording"]


def test_equal_times_update_without_prediction_noise() -> None:
    recording = straight()
    time = recording.time_s.copy()
    time[31] = time[30]
    result = filtered(replace(recording, time_s=time), profile="article")
    p = result.arrays["covariance"][:, 0, 0]
    assert words(result)[31] == "updated"
    assert p[31] < p[30]


def test_pairs_alone_never_start_and_say_why() -> None:
    recording = straight()
    toa = recording.toa_s.copy()
    toa[:, :2] = np.nan
    result = filtered(replace(recording, toa_s=toa))
    assert set(words(result)) == {"not_initialised"}
    decisions = rdfv.ALGORITHM.tabulate(recording, result)["decisions"]
    assert len(decisions) == 60
    assert set(decisions.columns["code"]) == {"too_few_marks", "same_pair"}
    assert "the same two stations all the time" in decisions.columns["reason"][-1]
    assert np.isnan(result.arrays["state"]).all()


def test_rdf_starts_from_four_and_goes_on_with_two() -> None:
    recording = straight()
    toa = recording.toa_s.copy()
    toa[:5, 1] = np.nan
    toa[20:, :2] = np.nan
    result = filtered(replace(recording, toa_s=toa), altitude=False)
    assert words(result)[:6] == ["not_initialised"] * 5 + ["initialised"]
    assert set(words(result)[20:]) == {"updated"}


def test_two_roots_are_both_kept_until_a_mark_decides() -> None:
    """Emitter behind the triple (specification 9.3): one hypothesis each, then the fourth station decides."""
    site = four_stations(sigma_toa_ns=10.0, sigma_altitude_m=30.0)
    stations = site.station_positions()
    marks = 12
    truth = np.column_stack([5_000 + 150.0 * np.arange(marks), np.full(marks, 22_000.0), np.full(marks, 5_960.0)])
    toa = np.linalg.norm(truth[:, None] - stations, axis=2) / C
    toa[:6, 0] = np.nan
    recording = ToaMarks(
        time_s=np.arange(marks, dtype=float), row=np.arange(1, marks + 1), target=np.zeros(marks, np.int64),
        truth_m=truth, site=site, toa_s=toa[:, :, None], altitude_m=np.full((marks, 1), 6_000.0),
        stations=("1", "2", "3", "4"),
    )  # fmt: skip
    single = solved(recording)
    assert words(single)[:6] == ["ambiguous"] * 6
    roots = single.arrays["roots_m"][0, :, :, 0]
    assert min(np.linalg.norm(roots - truth[0], axis=1)) < 1.0
    assert min(np.linalg.norm(roots - [-1436.2, 3425.5, 5998.9], axis=1)) < 1.0
    assert np.isnan(single.arrays["state"][0, 0, 0]), "two answers are no answer"
    result = filtered(recording)
    assert words(result)[0] == "initialised"
    assert "ambiguous" in words(result)[1:7]
    error = np.linalg.norm(result.arrays["state"][:, [0, 3], 0] - truth[:, :2], axis=1)
    assert error[-1] < 30, "the fourth station has decided for the right one"
    assert words(result)[-1] == "updated"


def test_five_receptions_with_a_wrong_one_fail_the_residual_gate() -> None:
    site = Site.model_validate(
        {
            "sigma_toa_ns": 10.0,
            "stations": [
                *four_stations().to_json()["stations"],
                {"name": "5", "east_m": 9_000.0, "north_m": 12_000.0, "up_m": 40.0},
            ],
        }
    )  # fmt: skip
    p = np.array([30_000.0, -12_000.0, 8_900.0])
    toa = np.linalg.norm(p - site.station_positions(), axis=1) / C
    recording = ToaMarks(
        time_s=np.zeros(2), row=np.arange(1, 3), target=np.zeros(2, np.int64), site=site,
        toa_s=np.stack([toa, toa + np.array([0, 0, 2e-6, 0, 0])])[:, :, None],
        altitude_m=np.full((2, 1), np.nan), stations=("1", "2", "3", "4", "5"),
    )  # fmt: skip
    result = solved(recording)
    assert words(result) == ["updated", "residual_gate"]
    assert result.arrays["state"][0, ::3, 0] == pytest.approx(p, abs=1e-3)
    assert words(solved(recording, residual_gate_m=1e5)) == ["updated", "updated"]


def test_an_emitter_at_a_station_is_no_division_by_zero() -> None:
    site = four_stations(sigma_toa_ns=10.0)
    stations = site.station_positions()
    toa = np.linalg.norm(stations[0] - stations, axis=1) / C
    recording = ToaMarks(
        time_s=np.zeros(1), row=np.ones(1, np.int64), target=np.zeros(1, np.int64), site=site,
        toa_s=toa[None, :, None], altitude_m=np.full((1, 1), 15.0), stations=("1", "2", "3", "4"),
    )  # fmt: skip
    for result in (solved(recording), filtered(recording)):
        assert np.isfinite(result.arrays["state"][0, 0, 0]) or words(result)[0] != "updated"
        assert np.linalg.norm(result.arrays["state"][0, [0, 3], 0] - stations[0, :2]) < 50


def test_a_filter_started_far_off_restarts_instead_of_dying() -> None:
    state = np.zeros(9)
    recording = straight()
    state[[0, 3, 6]] = recording.truth_m[0] + [20_000, -15_000, 0]
    start = {"mode": "given", "state": tuple(state), "sd": (500, 300, 10)}
    result = filtered(recording, start=start)
    assert "reinitialised" in words(result)
    error = np.linalg.norm(result.arrays["state"][-1, [0, 3], 0] - recording.truth_m[-1, :2])
    assert error < 500


def test_a_track_whose_innovations_stay_too_large_is_called_inconsistent() -> None:
    """A site twenty times more accurate in the file than in truth: the innovations say so, track by track."""
    recording = straight()
    assert recording.site is not None
    honest = rdfv.ALGORITHM.tabulate(recording, filtered(recording))["tracks"]
    assert list(honest.columns["inconsistent_marks"]) == [0]
    site = recording.site.model_copy(update={"sigma_toa_ns": 3.5})
    boastful = replace(recording, site=site)
    table = rdfv.ALGORITHM.tabulate(boastful, filtered(boastful))["tracks"]
    assert max(table.columns["inconsistent_marks"]) > 10


def test_a_covariance_that_lost_its_meaning_is_repaired() -> None:
    """Rounding may leave a diagonal element at or below zero: the lane is repaired and the mark says so."""
    track = lanes.new_track()
    full = np.diag(np.r_[np.full(8, 4.0), -1.0])
    track.p[0, :, 0] = full[np.tril_indices(9)]
    _repair(0, track)
    repaired = unpack(track.p[0, :, 0])
    assert np.linalg.eigvalsh(repaired)[0] == pytest.approx(1e-9, rel=1e-3)
    np.testing.assert_allclose(np.diag(repaired)[:8], 4.0)


def test_clock_offsets_are_subtracted() -> None:
    recording = straight(5)
    assert recording.site is not None
    stations = [
        s.model_copy(update={"clock_offset_ns": 700.0 if s.name == "2" else 0.0}) for s in recording.site.stations
    ]
    toa = recording.toa_s.copy()
    toa[:, 1] += 700e-9
    corrected = replace(recording, toa_s=toa, site=recording.site.model_copy(update={"stations": tuple(stations)}))
    np.testing.assert_allclose(
        solved(corrected).arrays["state"][:, ::3], solved(recording).arrays["state"][:, ::3], atol=1e-3
    )


def test_defaults_come_from_the_site_and_the_run_wins() -> None:
    recording = straight(5)
    settings = filtered(recording).settings
    assert (settings["sigma_altitude_m"].value, settings["sigma_altitude_m"].source) == (30.0, "site")
    settings = filtered(recording, sigma_altitude_m=77.0, sigma_toa_ns=12.0).settings
    assert (settings["sigma_altitude_m"].value, settings["sigma_altitude_m"].source) == (77.0, "run")
    assert (settings["sigma_toa_ns"].value, settings["sigma_toa_ns"].source) == (12.0, "run")
    assert settings["earth"].value == "sphere"
    assert [n.code for n in filtered(recording).notes] == ["sphere_used"], "no origin, and that is said"


def test_a_recording_without_a_site_is_refused() -> None:
    with pytest.raises(RecordingError) as caught:
        filtered(replace(straight(5), site=None))
    assert caught.value.pointer == "/site"


def test_wgs84_without_an_origin_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        filtered(straight(5), earth="wgs84")
    assert caught.value.pointer == "/earth"


@pytest.mark.parametrize("field", ["sigma_toa_ns", "sigma_jerk_mps3", "sigma_altitude_m", "residual_gate_m"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_parameters_are_refused(field: str, value: float) -> None:
    with pytest.raises(ValidationError):
        rdfv.RdfvParameters(**{field: value})
