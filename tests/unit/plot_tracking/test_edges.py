"""Situations at the edge of what a tracker can do: it goes on, and says what it left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.measures import measure
from algorithms.plot_tracking.outputs import LEFT_OUT
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.plot_tracking.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

TRACKERS: dict[str, Callable[[PolarPlots], Result]] = {
    "joint": lambda r: imm_tracker.run(r, ImmParameters(), LocalContext()),
    "nearest": lambda r: imm_tracker.run(r, ImmParameters(association="nearest"), LocalContext()),
    "curvature": lambda r: curvature_tracker.run(r, CurvatureParameters(), LocalContext()),
}
each = pytest.mark.parametrize("tracker", TRACKERS.values(), ids=TRACKERS)


def simulated(name: str = "straight_aircraft", trials: int = 1, **parameters: object) -> PolarPlots:
    scenario = scenarios_by_name()[name]
    recording = scenario.simulate(scenario.parameters(**parameters), tuple(range(trials)), 3)
    assert isinstance(recording, PolarPlots)
    return recording


def flight(speed: float, east: float, north: float, trials: int = 2, **parameters: Any) -> PolarPlots:
    target = {"east_m": east, "north_m": north, "altitude_m": 0, "heading_deg": 90, "speed_mps": speed,
              "segments": [{"duration_s": 300}]}  # fmt: skip
    return simulated(trials=trials, targets=[target], legs=[], duration_s=300.0, **parameters)


def metrics(recording: PolarPlots, result: Result) -> dict[str, float]:
    return {m.metric: m.value for m in measure(recording, result) if not m.target and m.value is not None}


@each
@pytest.mark.parametrize("speed", [0.1])
def test_a_hovering_target_keeps_its_place_and_has_no_course(tracker: Callable[..., Result], speed: float) -> None:
    recording = flight(speed, -20e3, 30e3)
    result = tracker(recording)
    found = metrics(recording, result)
    assert found["switches"] == 0
    assert found["rms_horizontal_m"] < 190
    course = tabulate(recording, result)["states"].columns["course_deg"]
    unknown = float(np.isnan(np.asarray(course, float)).mean())
    assert unknown > 0.5
    fast = flight(200.0, -20e3, 30e3)
    course = tabulate(fast, tracker(fast))["states"].columns["course_deg"]
    assert np.isnan(np.asarray(course, float)).mean() < 0.1


@each
@pytest.mark.parametrize("abeam_m", [0.0, 500.0])
def test_a_passage_over_the_radar_costs_no_number(tracker: Callable[..., Result], abeam_m: float) -> None:
    recording = flight(200.0, -30e3, abeam_m)
    found = metrics(recording, tracker(recording))
    assert (found["confirmed_tracks"], found["switches"]) == (1, 0)


@each
def test_a_scan_of_the_same_instant_is_left_out_and_counted(tracker: Callable[..., Result]) -> None:
    recording = simulated()
    late = np.isin(recording.scan, (15, 30))
    moved = replace(recording, time_s=np.where(late, recording.time_s - 5.0, recording.time_s))
    moved = moved.take(np.argsort(moved.time_s, kind="stable"))
    result = tracker(moved)
    assert [(n.code, n.count) for n in result.notes] == [("plots_left_out", 2)]
    assert int((result.arrays["decision"] == LEFT_OUT).sum()) == 2
    clean = tracker(recording.take(np.flatnonzero(~late)))
    assert result.arrays["estimate_state"].tobytes() == clean.arrays["estimate_state"].tobytes()


@each
def test_plots_that_coincide_are_a_track_that_stands_still(tracker: Callable[..., Result]) -> None:
    recording = simulated()
    still = replace(recording, range_m=np.full_like(recording.range_m, 50e3),
                    azimuth_rad=np.full_like(recording.azimuth_rad, 1.0))  # fmt: skip
    state = tracker(still).arrays["estimate_state"]
    assert state.size
    np.testing.assert_allclose(state[:, 0], 50e3 * np.sin(1.0), atol=1.0)
    np.testing.assert_allclose(state[:, 2:], 0.0, atol=0.5)


@each
@pytest.mark.parametrize("rows", [0, 1])
def test_nothing_and_one_plot_are_no_tracks(tracker: Callable[..., Result], rows: int) -> None:
    recording = simulated().take(np.arange(rows))
    result = tracker(recording)
    assert result.arrays["estimate_state"].shape == (0, 4)
    assert len(tabulate(recording, result)["states"]) == 0


def test_a_sure_detection_and_fewer_plots_than_tracks() -> None:
    recording = simulated("ten_aircraft", trials=2, detection_probability=0.5)
    result = imm_tracker.run(recording, ImmParameters(detection_probability=1.0), LocalContext())
    assert np.isfinite(result.arrays["estimate_state"]).all()
    assert metrics(recording, result)["tracked_share"] > 0.5


@pytest.mark.parametrize(("tracker", "delay", "false"), [("curvature", 25, 0.031), ("nearest", 20, 0.003)])
def test_when_a_manoeuvre_is_called_and_how_often_for_nothing(tracker: str, delay: float, false: float) -> None:
    """Specification 9.1: 25 s and 0.035 for the paper's tracker; a turn is called again and again while it lasts."""
    recording = simulated("wide_turn", trials=24)
    found = metrics(recording, TRACKERS[tracker](recording))
    assert (found["true_manoeuvres"], found["manoeuvre_detected"]) == (1, pytest.approx(1, abs=0.09))
    assert found["median_manoeuvre_delay_s"] == pytest.approx(delay, abs=5)
    assert found["manoeuvre_false_share"] == pytest.approx(false, abs=0.012)
    straight = simulated(trials=24)
    found = metrics(straight, TRACKERS[tracker](straight))
    assert "manoeuvre_detected" not in found
    assert found["manoeuvre_false_share"] == found["manoeuvre_share"] < 0.055


@pytest.mark.parametrize(
    ("factor", "low", "high", "outside"),
    [
        (0.5, 0.0, 0.005, (0.0, 0.0005)),
        (1.0, 0.02, 0.055, (0.0, 0.006)),
        (1.25, 0.055, 0.1, (0.001, 0.02)),
        (2.0, 0.1, 0.2, (0.025, 0.06)),
    ],
)
def test_wrong_accuracies_show_in_the_outer_ring_and_outside(
    factor: float, low: float, high: float, outside: tuple[float, float]
) -> None:
    """Specification 10: 0.0, 4.0, 7.6 and 15.5 % for true errors of 0.5, 1, 1.25 and 2 times the believed ones."""
    recording = simulated(trials=32)
    believed = CurvatureParameters(sigma_range_m=200 / factor, sigma_azimuth_deg=8 / 60 / factor)
    found = metrics(recording, curvature_tracker.run(recording, believed, LocalContext()))
    assert low <= found["outer_share"] <= high
    assert outside[0] <= found["outside_share"] <= outside[1]
    shares = [found[f"{name}_share"] for name in ("inner", "middle", "outer", "outside")]
    assert sum(shares) == pytest.approx(1.0)


def test_a_plot_just_outside_a_gate_is_no_start_of_nothing_but_named_with_its_track() -> None:
    recording = simulated(trials=32)
    result = curvature_tracker.run(recording, CurvatureParameters(sigma_range_m=140.0), LocalContext())
    table = curvature_tracker.ALGORITHM.tabulate(recording, result)["decisions"]
    outside = np.isfinite(np.asarray(table.columns["outside"], float))
    assert outside.any()
    # Nobody took them: they may begin a track, or be the second plot of another.
    words = {d for d, o in zip(table.columns["decision"], outside, strict=True) if o}
    assert words <= {"started"}
    false = simulated(trials=8, false_plots=50.0)
    found = metrics(false, curvature_tracker.run(false, CurvatureParameters(), LocalContext()))
    assert found["outside_share"] < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "inner"), [(0.5, 0.99), (1.0, 0.83), (1.25, 0.70), (2.0, 0.41)])
def test_interacting_models_show_them_too(factor: float, inner: float) -> None:
    recording = simulated(trials=16)
    believed = ImmParameters(sigma_range_m=200 / factor, sigma_azimuth_deg=8 / 60 / factor)
    found = metrics(recording, imm_tracker.run(recording, believed, LocalContext()))
    assert found["inner_share"] == pytest.approx(inner, abs=0.04)
