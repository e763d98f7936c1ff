"""The recommended tracker on small simulated recordings: lives of tracks, identities, what is told of plots."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from algorithms.plot_tracking.imm_tracker import run
from algorithms.plot_tracking.measures import measure
from algorithms.plot_tracking.parameters import ImmParameters
from algorithms.plot_tracking.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

both = pytest.mark.parametrize("association", ["nearest", "joint"])


def simulated(name: str, seed: int = 3, **parameters: object) -> PolarPlots:
    scenario = scenarios_by_name()[name]
    recording = scenario.simulate(scenario.parameters(**parameters), (0,), seed)
    assert isinstance(recording, PolarPlots)
    return recording


def tracked(recording: PolarPlots, **parameters: object) -> Result:
    return run(recording, ImmParameters(**parameters), LocalContext())


def metrics(recording: PolarPlots, result: Result) -> dict[str, float | None]:
    return {m.metric: m.value for m in measure(recording, result) if not m.target}


@both
def test_ten_aircraft_in_clutter_are_ten_tracks(association: str) -> None:
    recording = simulated("ten_aircraft", detection_probability=0.9, false_plots=20)
    found = metrics(recording, tracked(recording, association=association))
    assert found["confirmed_tracks"] == 10
    assert found["tracked_share"] is not None
    assert found["tracked_share"] > 0.98
    assert found["switches"] == 0
    assert found["ospa_m"] is not None
    assert found["ospa_m"] < 300


@both
def test_a_gap_of_seven_scans_keeps_the_number_and_nine_do_not(association: str) -> None:
    def numbers(missing: int) -> set[int]:
        recording = simulated("straight_aircraft")
        keep = (recording.scan < 20) | (recording.scan >= 20 + missing)
        found = tracked(recording.take(np.flatnonzero(keep)), association=association)
        return set(found.arrays["estimate_track"].tolist())

    assert numbers(7) == {1}
    assert numbers(9) == {1, 2}


def joined(first: PolarPlots, second: PolarPlots) -> PolarPlots:
    """Rows of both recordings in the order of time; nothing of the truth is needed."""
    arrays = {
        f.name: np.concatenate([getattr(first, f.name), getattr(second, f.name)])
        for f in fields(first)
        if isinstance(getattr(first, f.name), np.ndarray)
    }
    whole = replace(first, **arrays, targets=("1", "2"))
    return whole.take(np.argsort(whole.time_s, kind="stable"))


def test_a_life_is_told_with_its_reasons() -> None:
    recording = simulated("straight_aircraft")
    keep = (recording.scan < 20) | ((recording.scan >= 24) & (recording.scan < 40))
    # Plots of another aircraft go on, so that the radar is not silent.
    other = simulated("crossing_aircraft")
    late = replace(other, range_m=other.range_m + 60e3).take(np.flatnonzero(other.target == 1))
    whole = joined(recording.take(np.flatnonzero(keep)), late)
    tables = tabulate(whole, tracked(whole))
    steps = [row[3:] for row in tables["track_events"].rows() if row[1] == 1]
    assert steps == [
        ("tentative", "enough plots to follow it"),
        ("confirmed", "enough plots to confirm it"),
        ("coasting", "no plot in its gate"),
        ("confirmed", "a plot in its gate again"),
        ("coasting", "no plot in its gate"),
        ("dropped", "too many missed in a row"),
    ]


def test_addresses_keep_two_aircraft_apart_that_fly_as_one() -> None:
    """150 m apart with plot errors of 200 m: nothing but their addresses tells them apart."""
    recording = simulated("parallel_aircraft", distance_m=150.0, transponders="address")
    told = metrics(recording, tracked(recording, association="nearest"))
    hidden = metrics(recording, tracked(recording, association="nearest", use_identity=False))
    assert told["purity"] == 1.0
    assert told["confirmed_tracks"] == 2
    assert hidden["purity"] is not None
    assert hidden["purity"] < 0.95


def test_weights_follow_the_turn() -> None:
    recording = simulated("tight_turn")
    result = tracked(recording)
    time, weights = result.arrays["estimate_time_s"], result.arrays["estimate_weights"]
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert weights[(time > 60) & (time < 95), 1].mean() < 0.3
    assert weights[(time > 125) & (time < 158), 1].mean() > 0.6
    normal = result.arrays["estimate_motion"][:, 1]
    # 3 degrees a second at 120 m/s, to the right.
    assert 3.0 < normal[(time > 130) & (time < 158)].mean() < 9.0


def test_two_tracks_that_become_the_same_are_one() -> None:
    recording = simulated("parallel_aircraft", distance_m=0.0)
    result = tracked(recording)
    tables = tabulate(recording, result)
    assert "the same as an older track" in {row[4] for row in tables["track_events"].rows()}


def test_every_plot_of_a_gate_is_listed_with_its_probability() -> None:
    recording = simulated("crossing_aircraft", false_plots=20)
    result = tracked(recording)
    tables = tabulate(recording, result)
    decisions = tables["decisions"]
    assert len(decisions) == int(np.isfinite(recording.range_m).sum())
    assert set(tables["gates"].columns["gate"]) <= {"start", "acquisition", "tracking"}
    probability = result.arrays["probability"]
    known = probability[np.isfinite(probability)]
    assert known.size > 50
    assert ((known > 0) & (known <= 1)).all()
    assert any(row for row in decisions.columns["competing"])
