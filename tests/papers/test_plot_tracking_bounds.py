"""The bounds B1 and B2 of table 9.1, m before, in and after the manoeuvre and at the end."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.bound import bound, segments_of
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.spec import LocalContext

TABLE = {
    ("straight_aircraft", "B1"): (150, None, None, 88),
    ("straight_aircraft", "B2"): (109, None, None, 59),
    ("wide_turn", "B1"): (150, 155, 146, 102),
    ("wide_turn", "B2"): (109, 80, 58, 32),
    ("tight_turn", "B1"): (151, 152, 163, 113),
    ("speed_change", "B1"): (152, 169, 171, 115),
}


def simulated(name: str, **parameters: object) -> PolarPlots:
    scenario = scenarios_by_name()[name]
    recording = scenario.simulate(scenario.parameters(**parameters), (0, 1), 1)
    assert isinstance(recording, PolarPlots)
    return recording


@pytest.mark.parametrize(("name", "kind"), TABLE, ids=str)
def test_the_bounds_of_table_9_1(name: str, kind: str) -> None:
    # The table was made without a floor for the error across the ray.
    given = {"least_across_m": 0.0}
    found = bound(simulated(name), CurvatureParameters(**given) if kind == "B1" else ImmParameters(**given))
    assert found is not None
    time = np.arange(0.0, 301.0, 5.0)
    off = 168.7 if name == "wide_turn" else 160.0
    spans = ((49, 100), (100, off), (off, off + 40), (200 if name.startswith("straight") else 250, 300))
    for (low, high), printed in zip(spans, TABLE[name, kind], strict=True):
        if printed is not None:
            inside = (time > low) & (time <= high)
            assert np.sqrt(np.mean(found[inside] ** 2)) == pytest.approx(printed, abs=0.75)


def test_the_path_falls_into_its_segments() -> None:
    recording = simulated("wide_turn")
    speed = np.hypot(*recording.truth_velocity_mps[:, :2].T)
    course = np.arctan2(recording.truth_velocity_mps[:, 0], recording.truth_velocity_mps[:, 1])
    segments = segments_of(recording.time_s, speed, course)
    assert [s.begin_s for s in segments] == pytest.approx([0, 100, 168.70], abs=0.02)
    assert [s.curvature for s in segments] == pytest.approx([0, 0.0228642 / 200, 0], abs=1e-8)


def test_fewer_plots_and_more_targets_have_a_bound_each() -> None:
    full, half = (simulated("ten_aircraft", detection_probability=p, false_plots=f) for p, f in ((1.0, 0), (0.5, 9)))
    a, b = bound(full, ImmParameters()), bound(half, ImmParameters())
    assert a is not None
    assert b is not None
    assert a.shape == b.shape == (610,)
    known = np.isfinite(a) & np.isfinite(b)
    assert known.mean() > 0.9
    assert (b[known] > a[known] - 1e-9).all()
    # Half of the plots hold half of the information.
    late = known & (np.arange(610) > 300)
    assert np.median(b[late] / a[late]) == pytest.approx(np.sqrt(2), abs=0.25)


def test_the_bound_has_the_instants_of_the_score() -> None:
    recording = simulated("tight_turn", detection_probability=0.6, false_plots=3)
    for tracker, parameters in ((curvature_tracker, CurvatureParameters()), (imm_tracker, ImmParameters())):
        found, scores = bound(recording, parameters), tracker.score(recording, parameters, LocalContext())
        assert found is not None
        assert found.shape == scores.time_s.shape
