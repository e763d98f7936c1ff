"""Tracks of converted plots: the specification's worked example EX3, and its table of tracks (12.7, slow)."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.identification.pairs import Side
from algorithms.identification.parameters import TrackConversion
from algorithms.identification.tracks import filtered
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import LocalContext

EX3: dict[TrackConversion, tuple[list[float], list[float]]] = {
    "mucm": (
        [102041.821905, -105.477896, 58362.340743, 23.414451],
        [459261.556904, 1310.508369, 1415770.800387, 4117.066446],
    ),
    "ducm": (
        [102165.072067, -101.713404, 58196.011778, 18.353423],
        [461019.346679, 1311.316954, 1428089.201197, 4172.646634],
    ),
}


@pytest.mark.parametrize("conversion", EX3)
def test_worked_example_3(conversion: TrackConversion) -> None:
    side = Side(
        np.zeros(2),
        np.array([[120_000.0], [119_200.0], [118_300.0], [117_600.0]]),
        np.array([[0.5], [0.512], [0.508], [0.52]]),
        80.0,
        np.radians(0.8),
    )
    last = filtered(np.arange(4), 10.0 * np.arange(4), side, conversion, 1.0).steps[-1]
    state, variances = EX3[conversion]
    assert last.state[:, 0] == pytest.approx(state, rel=1e-9, abs=1e-6)
    assert np.diagonal(last.covariance[:, :, 0]) == pytest.approx(variances, rel=1e-9)


def at_the_end(scenario: dict[str, float], parameters: dict[str, object], trials: int = 1000) -> dict[str, float]:
    """Metrics of target 1 at the last scan."""
    algorithm, preset = algorithms_by_name()["track_association"], scenarios_by_name()["two_radars_tracks"]
    recording = preset.simulate(preset.parameters(**scenario), tuple(range(trials)), 7)
    assert algorithm.score is not None
    scores = algorithm.score(recording, algorithm.parameters(**parameters), LocalContext(7))
    row = int(np.flatnonzero((scores.time_s == scores.time_s.max()) & (scores.target == 0))[0])
    return {t.metric: float(t.numerator[row].sum() / t.denominator[row].sum()) for t in scores.tallies}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("conversion", "rejected"), [("lin", 0.030), ("paper", 0.018), ("mucm", 0.024), ("ducm", 0.023), ("polar", 0.011)]
)
def test_false_rejection_after_ten_scans(conversion: str, rejected: float) -> None:
    found = at_the_end({"scans": 10, "offset_along_m": 1060}, {"conversion": conversion}, 2000)
    band = 4 * np.sqrt(rejected * (1 - rejected) * (1 / 2000 + 1 / 3000)) + 0.0005
    assert found["false_rejection"] == pytest.approx(rejected, abs=band)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("offset", "scans", "correct", "paired"),
    [(300, 3, 0.101, 0.868), (300, 10, 0.532, 0.985), (300, 20, 0.915, 1.0), (600, 5, 0.855, 1.0), (1060, 3, 0.977, 1)],
)
def test_what_scans_bring(offset: float, scans: int, correct: float, paired: float) -> None:
    found = at_the_end({"scans": scans, "offset_along_m": offset}, {}, 2000)
    band = 4 * np.sqrt(max(correct * (1 - correct), 0.005) * (1 / 2000 + 1 / 3000)) + 0.0005
    assert found["probability_correct"] == pytest.approx(correct, abs=band)
    assert found["assignment_correct"] == pytest.approx(paired, abs=0.035)


@pytest.mark.slow
@pytest.mark.parametrize(("density", "ignored"), [(1, 2.89), (10, 2.65), (100, 2.52)])
def test_ignoring_the_common_manoeuvres_makes_the_gate_too_wide(density: float, ignored: float) -> None:
    scenario = {"scans": 20, "offset_along_m": 600, "acceleration_density_m2ps3": density}
    without = at_the_end(scenario, {"acceleration_density_m2ps3": density})
    with_it = at_the_end(scenario, {"acceleration_density_m2ps3": density, "cross_covariance": True})
    assert 4 * without["nis"] == pytest.approx(ignored, abs=0.35)
    assert 3.8 < 4 * with_it["nis"] < 5.0
    assert with_it["false_rejection"] > without["false_rejection"]
