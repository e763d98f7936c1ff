"""Radars that disagree as a whole: which one, in what, and by how much; and what the geometry cannot tell apart."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.identification.registration import Accepted, hypotheses_of, notes_of
from algorithms.identification.velocities import joined_tracks, velocities
from algorithms.recording import PolarPlots
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.result import Note, Result
from algorithms.spec import LocalContext

SPREAD = {"targets": 6, "looks": 30, "region_side_m": 60_000}
FLIGHT = {"scans": 40, "speed_mps": 250, "offset_along_m": 6000}


def simulated(preset: str, seed: int = 3, **parameters: Any) -> PolarPlots:
    """A recording that names no targets, as radars give it."""
    scenario = scenarios_by_name()[preset]
    recording = scenario.simulate(scenario.parameters(**parameters), (0,), seed)
    assert isinstance(recording, PolarPlots)
    return replace(recording, target=np.zeros(len(recording), np.int64), targets=("",))


def ran(recording: PolarPlots, algorithm: str = "assignment", **parameters: Any) -> Result:
    found = algorithms_by_name()[algorithm]
    return found.run(recording, found.parameters(**parameters), LocalContext())


def of(result: Result, code: str) -> list[Note]:
    return [note for note in result.notes if note.code == code]


def best(recording: PolarPlots, result: Result, algorithm: str = "assignment") -> dict[str, Any]:
    """First row of the table of explanations."""
    table = algorithms_by_name()[algorithm].tabulate(recording, result)["registration"]
    return dict(zip(table.names, next(iter(table.rows())), strict=True))


@pytest.mark.parametrize("turn", [0.5, *(pytest.param(turn, marks=pytest.mark.slow) for turn in (3.0, -20.0))])
def test_a_turn_of_any_size_is_measured(turn: float) -> None:
    plots = simulated("two_radars_cluster", **SPREAD, azimuth_bias_deg=turn)
    result = ran(plots)
    row = best(plots, result)
    assert (row["radar"], row["against"], row["offset"], row["unit"]) == ("2", "1", "azimuth", "deg")
    assert row["value"] == pytest.approx(turn, abs=3 * row["sd"])
    assert row["sd"] < 0.1
    (note,) = of(result, "registration_alarm")
    assert note.detail.startswith("Radar 2 is turned by")
    assert bool(of(result, "radars_disagree")) == (abs(turn) > 10)


@pytest.mark.parametrize(
    ("east", "north"),
    [(1000.0, 0.0), *(pytest.param(*far, marks=pytest.mark.slow) for far in ((5000.0, 2000.0), (-30_000.0, 40_000.0)))],
)
def test_a_shift_of_any_size_is_measured(east: float, north: float) -> None:
    plots = simulated("two_radars_tracks", **FLIGHT, site_error_east_m=east, site_error_north_m=north)
    result = ran(plots)
    table = algorithms_by_name()["assignment"].tabulate(plots, result)["registration"]
    rows = [row for row in table.rows() if row[2] in ("east", "north")][:2]
    assert [row[0] for row in rows] == ["2", "2"]
    for row, expected in zip(rows, (east, north), strict=True):
        assert row[3] == pytest.approx(expected, abs=4 * row[4])
    (note,) = of(result, "registration_alarm")
    assert note.detail.startswith("Radar 2 places targets")


@pytest.mark.parametrize("algorithm", ["assignment", "pairwise_test", "track_association", "multi_radar_assignment"])
@pytest.mark.parametrize("late", [2.0, 5.0, 25.0])
def test_a_clock_that_is_wrong_by_any_part_of_a_look_is_measured(late: float, algorithm: str) -> None:
    """Looks are 10 s apart. With one course a displaced radar looks the same, which is said too."""
    plots = simulated("two_radars_tracks", **FLIGHT, time_offset_s=late)
    result = ran(plots, algorithm)
    rows = algorithms_by_name()[algorithm].tabulate(plots, result)["registration"].rows()
    row = next(row for row in rows if row[2] == "time")
    assert row[3] == pytest.approx(late, abs=4 * row[4])
    assert row[4] < 0.6
    said = [note.detail for code in ("registration_alarm", "registration_ambiguous") for note in of(result, code)]
    assert any("too early" in detail for detail in said)
    assert any("east and" in detail for detail in said)


def test_targets_on_different_courses_tell_a_clock_from_a_place() -> None:
    one = simulated("two_radars_tracks", **FLIGHT, time_offset_s=5.0)
    other = simulated(
        "two_radars_tracks", **FLIGHT | {"course_deg": 100.0, "offset_along_m": 20_000}, time_offset_s=5.0
    )
    both = replace(
        one,
        **{
            name: np.concatenate([getattr(one, name), getattr(other, name)])
            for name in ("time_s", "target", "truth_m", "truth_velocity_mps", "range_m", "azimuth_rad", "elevation_rad",
                         "altitude_m", "east_m", "north_m", "radar", "radar_east_m", "radar_north_m", "scan", "address",
                         "callsign")
        },
        row=np.arange(1, 1 + len(one) + len(other)),
    )  # fmt: skip
    plots = both.take(np.argsort(both.time_s, kind="stable"))
    result = ran(plots)
    row = best(plots, result)
    assert row["offset"] == "time"
    assert row["value"] == pytest.approx(5.0, abs=4 * row["sd"])
    assert not of(result, "registration_ambiguous")


def test_of_three_radars_the_wrong_one_is_named() -> None:
    three = simulated("two_radars_cluster", **SPREAD | {"targets": 3}, radars=3)
    turned = np.where((three.radar == 2)[:, None], three.azimuth_rad + np.radians(2.0), three.azimuth_rad)
    plots = replace(three, azimuth_rad=np.mod(turned, 2 * np.pi))
    result = ran(plots, "multi_radar_assignment")
    row = best(plots, result, "multi_radar_assignment")
    assert (row["radar"], row["against"], row["offset"]) == ("3", "others", "azimuth")
    assert row["value"] == pytest.approx(2.0, abs=0.3)
    far = replace(three, azimuth_rad=np.mod(turned + np.where((three.radar == 2)[:, None], 0.4, 0.0), 2 * np.pi))
    result = ran(far, "multi_radar_assignment")
    row = best(far, result, "multi_radar_assignment")
    assert (row["radar"], row["offset"]) == ("3", "azimuth")
    assert row["value"] == pytest.approx(2.0 + np.degrees(0.4), abs=4 * row["sd"])


def accepted(place: np.ndarray, moved: np.ndarray, sites: np.ndarray, sigma_m: float = 100.0) -> Accepted:
    """Pairs whose second plot is moved, all errors round."""
    n = len(place)
    noise = np.random.default_rng(5).standard_normal((n, 2)) * sigma_m
    covariance = np.tile([sigma_m**2, sigma_m**2, 0.0], (n, 1))
    return Accepted(noise - moved, covariance, place - sites[0], place + moved - sites[1], np.full((n, 2), np.nan))


SITES = np.array([[0.0, 0.0], [30_000.0, 0.0]])


def test_targets_in_one_place_cannot_tell_a_turn_from_a_shift() -> None:
    rng = np.random.default_rng(2)
    turn = np.radians(1.0)
    for spread, told_apart in ((500.0, False), (60_000.0, True)):
        place = np.array([100_000.0, 80_000.0]) + spread * (rng.random((40, 2)) - 0.5)
        offset = place - SITES[1]
        moved = turn * np.stack([offset[:, 1], -offset[:, 0]], axis=1)
        notes = notes_of(hypotheses_of(accepted(place, moved, SITES), 0, 1), ("west", "east"))
        assert notes[0].code == "registration_alarm"
        rivals = [n.detail for n in notes[1:]]
        assert bool(rivals) != told_apart
        if told_apart:
            assert notes[0].detail.startswith("Radar east is turned by 0.9")
        else:
            both = [notes[0].detail, *rivals]
            assert any("is turned by" in text for text in both)
            assert any("places targets" in text for text in both)
            assert all("cannot tell the two apart" in text for text in rivals)


def test_accuracies_that_are_claimed_too_good_are_no_alarm() -> None:
    place = np.array([100_000.0, 80_000.0]) + 20_000 * np.random.default_rng(3).random((100, 2))
    pairs = accepted(place, np.zeros((100, 2)), SITES)
    claimed = replace(pairs, covariance=pairs.covariance / 400)
    hypotheses = hypotheses_of(claimed, 0, 1)
    assert max(h.statistic for h in hypotheses) > 100
    assert not notes_of(hypotheses, ("west", "east"))


@pytest.mark.parametrize("algorithm", ["assignment", "pairwise_test"])
def test_false_plots_as_dense_as_targets_are_no_alarm(algorithm: str) -> None:
    for seed in (31, 37, 40):
        plots = simulated("two_radars_cluster", seed, targets=6, looks=20, detection_probability=0.7, false_plots=4)
        told = {} if algorithm == "pairwise_test" else {"detection_probability": 0.7, "clutter_per_radar": 4}
        assert not of(ran(plots, algorithm, **told), "registration_alarm")


def test_wide_azimuths_are_no_alarm() -> None:
    """At 4 degrees axes at the measured azimuth would say that a radar measures too far."""
    for seed in range(4):
        plots = simulated("two_radars_cluster", seed, targets=6, looks=20, sigma_azimuth_deg=4)
        assert not of(ran(plots), "registration_alarm")


def test_velocities_of_straight_flights_of_turns_and_of_jumps() -> None:
    time = 10.0 * np.arange(40)
    rng = np.random.default_rng(1)
    covariance = np.tile([100.0**2, 100.0**2, 0.0], (40, 1))
    noise = 100 * rng.standard_normal((40, 2))
    straight = np.stack([200 * time, -50 * time], axis=1) + noise
    found = velocities([np.arange(40)], time, straight, covariance)
    assert found == pytest.approx(np.tile([200.0, -50.0], (40, 1)), abs=4 * 100 / (10 * np.sqrt(40**3 / 12)))
    angle = 0.002 * time
    turning = 100_000 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + noise
    found = velocities([np.arange(40)], time, turning, covariance)
    expected = 200 * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    assert np.abs(found - expected)[10:-10] == pytest.approx(0.0, abs=40)
    assert np.isnan(velocities([np.arange(40)], time, 1e5 * rng.random((40, 2)), covariance)).all()
    assert np.isnan(velocities([np.arange(3)], time, straight, covariance)).all()
    # Two flights, unnamed, are kept apart.
    place = np.concatenate([straight, straight + 30_000])
    looks = [np.array([k, 40 + k]) for k in range(40)]
    tracks = joined_tracks(looks, np.full(80, -1), np.tile(time, 2), place, np.tile(covariance, (2, 1)), 300.0)
    assert sorted(map(tuple, tracks)) == [tuple(range(40)), tuple(range(40, 80))]
