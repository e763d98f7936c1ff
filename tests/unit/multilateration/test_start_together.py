"""Tracks started from several marks: when, with what claim, and every reason why not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multilateration import lanes, rdf, rdfv
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.symmetric import unpack


def pairs(marks: int = 40, trials: int = 1, first: int = 300) -> ToaMarks:
    """Return a straight leg where station 4 is heard with station 1, 2, 3 in turn."""
    recording = simulate(CircuitParameters(sigma_altitude_m=30.0), tuple(range(trials)), 4)
    part = recording.take(np.arange(first, first + marks))
    toa = part.toa_s.copy()
    for k in range(marks):
        toa[k, [s for s in range(3) if s != k % 3]] = np.nan
    return replace(part, time_s=np.arange(float(marks)), row=np.arange(1, marks + 1), toa_s=toa)


def filtered(recording: ToaMarks, module=rdf, **parameters: object) -> Result:
    return module.run(recording, module.ALGORITHM.parameters(**parameters), LocalContext())


def codes(result: Result, lane: int = 0) -> list[str]:
    return [lanes.REASON_CODES[i] for i in result.arrays["reason"][:, lane]]


@pytest.mark.parametrize("module", [rdf, rdfv])
def test_alternating_pairs_start_a_track_within_its_claim(module) -> None:
    recording = pairs()
    result = filtered(recording, module)
    found = codes(result)
    k = found.index("several_marks")
    assert 5 <= k < 10
    assert found[:4] == ["too_few_marks"] * 4
    assert lanes.STATUS[result.arrays["status"][k, 0]] == "initialised"
    assert set(found[k + 1 :]) == {""}
    error = result.arrays["state"][k, [0, 3], 0] - recording.truth_m[k, :2]
    covariance = unpack(result.arrays["covariance"][k, :, 0])
    assert error @ np.linalg.solve(covariance[np.ix_([0, 3], [0, 3])], error) < 14  # 0.999
    assert np.linalg.eigvalsh(covariance)[0] > 0
    speed = result.arrays["state"][k, [1, 4], 0] - recording.truth_velocity_mps[k, :2]
    assert (np.abs(speed) < 5 * np.sqrt(np.diag(covariance)[[1, 4]])).all()
    decisions = module.ALGORITHM.tabulate(recording, result)["decisions"]
    assert decisions.columns["code"][-1] == "several_marks", "a start together is a decision, and is listed"


def test_the_altitude_and_its_climb_come_from_the_decoded_altitudes() -> None:
    recording = pairs()
    result = filtered(replace(recording, altitude_m=recording.altitude_m + 500.0), rdfv)
    k = codes(result).index("several_marks")
    z = result.arrays["state"][k, 6, 0]
    sd = np.sqrt(result.arrays["covariance"][k, 27, 0])
    assert abs(z - recording.truth_m[k, 2] - 500.0) < 3 * sd
    assert 25 < sd < 31, "the error of an altitude is common to all marks: never better than one"


def test_the_same_pair_never_starts_and_says_how_wrong_it_would_be() -> None:
    recording = pairs(120)
    toa = recording.toa_s.copy()
    toa[:, 1:3] = np.nan
    result = filtered(replace(recording, toa_s=toa[::3].repeat(3, axis=0)))
    assert not np.isfinite(result.arrays["state"]).any()
    assert set(codes(result)) == {"too_few_marks", "same_pair"}
    decisions = rdf.ALGORITHM.tabulate(recording, result)["decisions"].columns
    told = [w for w, code in zip(decisions["reason"], decisions["code"], strict=True) if code == "same_pair"]
    start = "the same two stations all the time: no place along their hyperbola; predicted error "
    assert told
    assert all(w.startswith(start) and w.endswith(" km") for w in told)
    assert np.nanmin(result.arrays["start_error_m"]) > 10_000


def test_a_jump_is_no_straight_flight() -> None:
    recording = pairs(12)
    other = pairs(12, first=1_500)
    toa = np.where(np.arange(12)[:, None, None] < 3, other.toa_s, recording.toa_s)
    found = codes(filtered(replace(recording, toa_s=toa)))
    assert "not_straight" in found
    assert "several_marks" in codes(filtered(recording))
    later = pairs(40)
    toa = np.where(np.arange(40)[:, None, None] < 3, pairs(40, first=1_500).toa_s, later.toa_s)
    assert "several_marks" in codes(filtered(replace(later, toa_s=toa))), "the old half goes, the new one starts"


def test_a_triple_without_altitude_far_away_waits_for_better_geometry() -> None:
    recording = simulate(CircuitParameters(), (0,), 4).take(np.arange(1700, 1800))
    toa = recording.toa_s.copy()
    toa[:, 1] = np.nan
    result = filtered(replace(recording, time_s=np.arange(100.0), toa_s=toa))
    assert not np.isfinite(result.arrays["state"]).any()
    assert set(codes(result)) <= {"too_few_marks", "poor_geometry", "several_positions"}
    assert len(set(codes(result))) > 1


def test_old_marks_do_not_help() -> None:
    """Marks 20 s apart are never five within a minute; in a window of two minutes they are."""
    recording = replace(pairs(12), time_s=np.arange(12) * 20.0)
    assert set(codes(filtered(recording))) == {"too_few_marks"}
    assert set(codes(filtered(recording, start_window_s=120.0))) > {"too_few_marks"}


@pytest.mark.parametrize("parameters", [{"start_marks": 0}, {"profile": "article"}])
def test_no_start_together_where_it_is_switched_off(parameters: dict[str, object]) -> None:
    result = filtered(pairs(), **parameters)
    assert set(codes(result)) == {"no_start_from_one_mark"}
    assert result.settings["start_marks"].value == 0


def test_the_same_bytes_however_trials_are_cut() -> None:
    whole = pairs(30, trials=19)
    together = filtered(whole).arrays
    assert (together["reason"] == lanes.R_TOGETHER).any(axis=0).all()
    for lane in (0, 7, 18):
        one = replace(whole, toa_s=whole.toa_s[:, :, [lane]], altitude_m=whole.altitude_m[:, [lane]])
        alone = filtered(one).arrays
        for name in ("state", "covariance", "reason", "start_error_m"):
            assert together[name][..., [lane]].tobytes() == alone[name].tobytes(), name


def test_a_pile_survives_the_cut_between_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = filtered(pairs(30)).arrays["state"].tobytes()
    monkeypatch.setattr("algorithms.multilateration.tracker.SLICE_RECEPTIONS", 12)
    assert filtered(pairs(30)).arrays["state"].tobytes() == whole


def test_every_reason_has_a_code_of_its_own() -> None:
    assert len(lanes.REASON_CODES) == len(lanes.REASONS) == len(set(lanes.REASON_CODES))
