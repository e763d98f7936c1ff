"""What a tracker is given: scans, turns of the antenna, frames, and what is wrong with a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.errors import RecordingError
from algorithms.plot_tracking.curvature_tracker import run
from algorithms.plot_tracking.outputs import LEFT_OUT
from algorithms.plot_tracking.parameters import CurvatureParameters
from algorithms.plot_tracking.radars import feeds_of
from algorithms.plot_tracking.turns import turning_period, turns_of
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.spec import LocalContext


def simulated(name: str = "wide_turn", **parameters: object) -> PolarPlots:
    scenario = scenarios_by_name()[name]
    recording = scenario.simulate(scenario.parameters(**parameters), (0,), 3)
    assert isinstance(recording, PolarPlots)
    return recording


def test_turns_are_told_from_azimuths() -> None:
    """An antenna of 4.97 s believed to need 5 s: 60 turns, and plots just beside north."""
    rng = np.random.default_rng(1)
    azimuth = np.concatenate([rng.uniform(0, 2 * np.pi, 400), [1e-4, 2 * np.pi - 1e-4] * 20])
    turn = np.concatenate([rng.integers(0, 60, 400), np.arange(40)])
    time = 4.97 * (turn + azimuth / (2 * np.pi))
    order = np.argsort(time)
    found = turns_of(time[order], azimuth[order], 5.0)
    assert np.array_equal(found, turn[order])
    period = turning_period(time[order], azimuth[order])
    assert period == pytest.approx(4.97, rel=1e-3)


def test_plots_of_one_instant_are_no_turning_antenna() -> None:
    rng = np.random.default_rng(2)
    assert turning_period(np.repeat(np.arange(30.0), 3), rng.uniform(0, 2 * np.pi, 90)) is None
    assert turning_period(np.arange(90.0), rng.uniform(0, 2 * np.pi, 90)) is None


def test_rows_of_a_turning_antenna_become_scans() -> None:
    recording = simulated("ten_aircraft")
    late = recording.time_s + 5.0 * np.mod(recording.azimuth_rad[:, 0], 2 * np.pi) / (2 * np.pi)
    order = np.argsort(late)
    turning = replace(recording, time_s=late, scan=np.full(len(recording), -1)).take(order)
    (feed,), _, _ = feeds_of(turning, CurvatureParameters())
    assert len(feed.plots.scans) == 61
    assert {scan.rho.size for scan in feed.plots.scans} == {10}


def test_what_cannot_be_a_plot_is_left_out_and_the_rest_is_as_without_it() -> None:
    clean = simulated(duration_s=100.0)
    range_m, azimuth = clean.range_m.copy(), clean.azimuth_rad.copy()
    n = len(clean)
    again = np.concatenate([np.arange(n), [3, 5, 7, 9]])
    order = np.argsort(again, kind="stable")
    dirty = clean.take(again[order])
    extra = np.flatnonzero(np.diff(again[order]) == 0) + 1
    range_m, azimuth = dirty.range_m.copy(), dirty.azimuth_rad.copy()
    range_m[extra[1]], range_m[extra[2]], azimuth[extra[3]] = -5.0, 2e6, np.nan
    dirty = replace(dirty, range_m=range_m, azimuth_rad=azimuth)
    a, b = (run(r, CurvatureParameters(), LocalContext()) for r in (clean, dirty))
    assert (b.arrays["decision"][extra, 0] == LEFT_OUT).all()
    assert a.arrays["estimate_state"].tobytes() == b.arrays["estimate_state"].tobytes()
    assert sum(note.count for note in b.notes) == 4


def test_azimuths_in_degrees_are_refused() -> None:
    recording = simulated(duration_s=60.0)
    wrong = replace(recording, azimuth_rad=np.degrees(recording.azimuth_rad))
    with pytest.raises(RecordingError) as caught:
        run(wrong, CurvatureParameters(), LocalContext())
    assert caught.value.code == "azimuth_unit"


def test_a_radar_without_accuracy_is_refused() -> None:
    recording = replace(simulated(duration_s=60.0), site=None)
    with pytest.raises(RecordingError) as caught:
        run(recording, CurvatureParameters(), LocalContext())
    assert caught.value.code == "accuracy_missing"
    known = CurvatureParameters(sigma_range_m=200, sigma_azimuth_deg=0.1333)
    assert run(recording, known, LocalContext()).arrays["estimate_state"].size


def test_turning_all_plots_turns_all_tracks_and_a_mirror_turns_the_curvature() -> None:
    recording = simulated("tight_turn")
    p = CurvatureParameters()
    angle = 2.5
    turned = replace(recording, azimuth_rad=np.mod(recording.azimuth_rad + angle, 2 * np.pi))
    mirrored = replace(recording, azimuth_rad=np.mod(-recording.azimuth_rad, 2 * np.pi))
    plain, other, mirror = (run(r, p, LocalContext()).arrays for r in (recording, turned, mirrored))
    e, n = plain["estimate_state"][:, 0], plain["estimate_state"][:, 1]
    c, s = np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(other["estimate_state"][:, 0], c * e + s * n, atol=0.01)
    np.testing.assert_allclose(other["estimate_state"][:, 1], c * n - s * e, atol=0.01)
    np.testing.assert_allclose(mirror["estimate_state"][:, 0], -e, atol=0.01)
    np.testing.assert_allclose(mirror["estimate_motion"][:, 1], -plain["estimate_motion"][:, 1], atol=1e-4)


def test_a_gap_of_four_scans_keeps_the_number_and_five_do_not() -> None:
    def numbers(missing: int) -> set[int]:
        recording = simulated("straight_aircraft")
        keep = (recording.scan < 20) | (recording.scan >= 20 + missing)
        found = run(recording.take(np.flatnonzero(keep)), CurvatureParameters(), LocalContext())
        return set(found.arrays["estimate_track"].tolist())

    assert numbers(4) == {1}
    assert numbers(5) == {1, 2}


def test_slant_ranges_become_ground_ranges_with_an_altitude() -> None:
    target = {"east_m": -20e3, "north_m": 10e3, "altitude_m": 10e3, "heading_deg": 90, "speed_mps": 200,
              "segments": [{"duration_s": 200}]}  # fmt: skip
    given = {"targets": [target], "range_kind": "slant", "duration_s": 200.0, "legs": [], "sigma_range_m": 20.0}
    with_height = simulated(**given, transponders="altitude")
    without = simulated(**given)

    def worst(recording: PolarPlots) -> float:
        a = run(recording, CurvatureParameters(), LocalContext()).arrays
        late = a["estimate_time_s"] > 60
        truth = np.stack([np.interp(a["estimate_time_s"], recording.time_s, recording.truth_m[:, i]) for i in (0, 1)])
        error = np.hypot(*(a["estimate_state"][:, :2].T - truth))
        return float(np.median(error[late]))

    assert worst(with_height) < 100
    assert worst(without) > 1000


def test_a_single_target_that_passes_by_is_no_turning_antenna() -> None:
    """Its azimuth grows with time too: taken for an antenna of some minutes, all its plots would be one scan."""
    time = 5.0 * np.arange(40)
    azimuth = np.mod(np.arctan2(-20e3 + 180 * time, np.full(40, 12e3)), 2 * np.pi)
    assert turning_period(time, azimuth) is None
