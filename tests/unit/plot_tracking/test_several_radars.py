"""Two radars that see the same aircraft: each has its tracks, and those of one aircraft are joined."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.measures import measure
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.plot_tracking.scoring import score_result
from algorithms.plot_tracking.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

EAST, NORTH, LATE_S = 60e3, 20e3, 2.0


def two_radars(name: str = "ten_aircraft", shift_m: float = 0.0, **parameters: object) -> PolarPlots:
    """The scenario's radar A, and B 63 km away that turns two seconds later; B's zero lies off by a shift."""
    scenario = scenarios_by_name()[name]
    a = scenario.simulate(scenario.parameters(**parameters), (0,), 3)
    assert isinstance(a, PolarPlots)
    assert a.site is not None
    named = np.array([target != "clutter" for target in a.targets])[a.target]
    rng = np.random.default_rng(5)
    seen = a.take(np.flatnonzero(named & (rng.random(len(a)) < 0.9)))
    place = seen.truth_m + LATE_S * seen.truth_velocity_mps
    east, north = place[:, 0] - EAST + shift_m, place[:, 1] - NORTH
    b = replace(
        seen,
        time_s=seen.time_s + LATE_S,
        truth_m=place,
        range_m=(np.hypot(east, north) + rng.normal(0, 200, len(seen)))[:, None],
        azimuth_rad=np.mod(np.arctan2(east, north) + rng.normal(0, np.radians(8 / 60), len(seen)), 2 * np.pi)[:, None],
        radar=np.ones(len(seen), np.int64),
    )
    arrays = {f.name: np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(a)
              if isinstance(getattr(a, f.name), np.ndarray)}  # fmt: skip
    one = a.site.radars[0]
    radars = tuple(
        one.model_copy(update={"name": n, "east_m": e, "north_m": k})
        for n, e, k in (("A", 0.0, 0.0), ("B", EAST, NORTH))
    )
    whole = replace(a, **arrays, radars=("A", "B"), site=a.site.model_copy(update={"radars": radars}))
    whole = whole.take(np.argsort(whole.time_s, kind="stable"))
    return replace(whole, row=np.arange(1, len(whole) + 1))


def tracked(recording: PolarPlots, **parameters: object) -> Result:
    return imm_tracker.run(recording, ImmParameters(**parameters), LocalContext())


def metrics(recording: PolarPlots, result: Result) -> dict[str, float | None]:
    return {m.metric: m.value for m in measure(recording, result) if not m.target}


def test_twenty_tracks_of_ten_aircraft_are_ten() -> None:
    recording = two_radars(detection_probability=0.9, false_plots=10)
    result = tracked(recording)
    found = metrics(recording, result)
    assert (found["confirmed_tracks"], found["joined_tracks"]) == (20, 10)
    assert (found["join_recall"], found["join_precision"]) == (1, 1)
    assert found["rms_joined_m"] is not None
    assert found["rms_horizontal_m"] is not None
    assert found["rms_joined_m"] < 0.8 * found["rms_horizontal_m"]
    tables = tabulate(recording, result)
    pairs = list(tables["compared_tracks"].rows())
    assert {row[6] for row in pairs} == {"joined", "apart"}
    assert all((row[4] <= row[5]) == (row[6] == "joined") for row in pairs)
    joined = dict(zip(tables["tracks"].columns["track"], tables["tracks"].columns["joined"], strict=True))
    assert all(joined[row[1]] == joined[row[2]] for row in pairs if row[6] == "joined")
    # Claimed errors of joint tracks are honest within a factor: two tracks are better than each.
    assert np.median(tables["joined_states"].columns["sigma_east_m"]) < np.median(
        tables["states"].columns["sigma_east_m"]
    )


def test_what_is_counted_of_two_radars_is_counted_for_each() -> None:
    recording = two_radars()
    result = tracked(recording)
    found = metrics(recording, result)
    assert found["switches"] == 0
    assert found["tracked_share"] is not None
    assert found["tracked_share"] > 0.99
    # Six manoeuvres in the scenario, and no seventh where the scans of the other radar begin.
    assert found["true_manoeuvres"] == 12
    tallies = {t.metric: t for t in score_result(recording, result).tallies}
    assert tallies["switches_per_target"].numerator.sum() == 0


def test_the_papers_tracker_is_joined_too() -> None:
    recording = two_radars("ten_aircraft")
    result = curvature_tracker.run(recording, CurvatureParameters(), LocalContext())
    found = metrics(recording, result)
    assert found["join_precision"] == 1
    assert found["join_recall"] is not None
    assert found["join_recall"] >= 0.9


def test_radars_that_do_not_agree_are_joined_where_that_is_said() -> None:
    recording = two_radars("straight_aircraft", shift_m=1500.0)
    assert metrics(recording, tracked(recording))["joined_tracks"] == 2
    assert metrics(recording, tracked(recording, registration_m=1000.0))["joined_tracks"] == 1


@pytest.mark.parametrize(("use", "count"), [(True, 2), (False, 1)])
def test_other_addresses_forbid_a_join(use: bool, count: int) -> None:
    recording = two_radars("straight_aircraft")
    recording = replace(recording, address=recording.radar)
    assert metrics(recording, tracked(recording, use_identity=use))["joined_tracks"] == count


def test_a_track_that_broke_at_one_radar_is_one_target_with_the_whole_one_of_the_other() -> None:
    recording = two_radars("straight_aircraft")
    gap = (recording.radar == 0) & (recording.time_s >= 100) & (recording.time_s < 150)
    # Something else goes on being seen, so that the antenna does not stand still.
    result = tracked(recording.take(np.flatnonzero(~gap)))
    a = result.arrays
    assert set(a["estimate_track"].tolist()) == {1, 2, 3}
    assert set(a["estimate_joined"].tolist()) == {1}


def test_one_radar_has_no_joint_tracks() -> None:
    scenario = scenarios_by_name()["straight_aircraft"]
    recording = scenario.simulate(scenario.parameters(), (0,), 1)
    assert isinstance(recording, PolarPlots)
    tables = tabulate(recording, tracked(recording))
    assert "compared_tracks" not in tables
    assert np.isnan(tables["tracks"].columns["joined"]).all()
