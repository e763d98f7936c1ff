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


# Scans: NEES of four dimensions and radial bias (m), by conversion; None = not given. Three thousand runs.
TRACKS: dict[int, dict[str, tuple[float, float | None]]] = {
    5: {"lin": (4.79, 2), "paper": (3.86, -21), "dcm": (4.66, 25), "ucm": (4.66, 25), "mucm": (4.26, -21),
        "ducm": (4.35, -23), "ekf": (7.41, None)},
    10: {"lin": (5.23, 11), "paper": (3.93, -12), "dcm": (5.55, 34), "ucm": (5.55, 34), "mucm": (4.39, -12),
         "ducm": (4.37, -12), "ekf": (7.90, None)},
    20: {"lin": (5.82, 18), "paper": (3.90, -5), "dcm": (7.11, 40), "ucm": (7.11, 40), "mucm": (4.42, -5),
         "ducm": (4.23, -5), "ekf": (7.57, None)},
    30: {"lin": (6.35, 21), "paper": (3.83, -2), "dcm": (8.69, 44), "ucm": (8.69, 44), "mucm": (4.38, -2),
         "ducm": (4.22, -2), "ekf": (6.97, None)},
}  # fmt: skip
RADIAL_SD = {5: 80.0, 10: 69.0, 20: 58.0, 30: 50.0}
"""Cramer-Rao bound along the line of sight, m."""


@pytest.mark.slow
@pytest.mark.parametrize("scans", TRACKS)
def test_honesty_and_bias_of_tracks(scans: int) -> None:
    trials = 1000
    for conversion, (nees, bias) in TRACKS[scans].items():
        found = at_the_end({"scans": scans, "offset_along_m": 1060}, {"conversion": conversion}, trials)
        # The spread of chi-square with four degrees of freedom, more where it is inflated.
        spread = 4 * np.sqrt(8) * (nees / 4) ** 1.5 * np.sqrt(1 / trials + 1 / 3000)
        assert 4 * found["nees"] == pytest.approx(nees, abs=spread), conversion
        if bias is not None:
            error = 4 * 1.2 * RADIAL_SD[scans] * np.sqrt(1 / trials + 1 / 3000) + 0.5
            assert found["radial_bias_m"] == pytest.approx(bias, abs=error), conversion


@pytest.mark.slow
@pytest.mark.parametrize(("scans", "nees"), [(5, 4.12), (10, 4.03), (20, 4.01)])
def test_straight_flights_fitted_exactly_are_honest(scans: int, nees: float) -> None:
    found = at_the_end({"scans": scans, "offset_along_m": 1060}, {"conversion": "polar"}, 500)
    assert 4 * found["nees"] == pytest.approx(nees, abs=4 * np.sqrt(8) * np.sqrt(1 / 500 + 1 / 3000))
    assert abs(found["radial_bias_m"]) < 4 * RADIAL_SD[scans] / np.sqrt(500) + 2


# Conversion: false rejection after 5, 10 and 20 scans.
REJECTED = {
    "lin": (0.026, 0.030, 0.027),
    "paper": (0.016, 0.018, 0.016),
    "mucm": (0.022, 0.024, 0.025),
    "ducm": (0.024, 0.023, 0.020),
    "ekf": (0.070, 0.085, 0.070),
    "polar": (0.009, 0.011, 0.013),
}


@pytest.mark.slow
@pytest.mark.parametrize("conversion", REJECTED)
def test_false_rejection_of_tracks(conversion: str) -> None:
    trials = 600 if conversion == "polar" else 2000
    for scans, rejected in zip((5, 10, 20), REJECTED[conversion], strict=True):
        if conversion == "polar" and scans == 20:
            continue
        found = at_the_end({"scans": scans, "offset_along_m": 1060}, {"conversion": conversion}, trials)
        band = 4 * np.sqrt(rejected * (1 - rejected) * (1 / trials + 1 / 3000)) + 0.0005
        assert found["false_rejection"] == pytest.approx(rejected, abs=band), scans


# Separation in m: correct by the threshold after 3, 5, 10 and 20 scans (mucm).
SEPARATED = {
    300: (0.101, 0.206, 0.532, 0.915),
    600: (0.562, 0.855, 0.976, 0.975),
    1060: (0.977, 0.978, 0.976, 0.975),
}
PAIRED_AT_300 = (0.868, 0.928, 0.985, 1.000)


@pytest.mark.slow
@pytest.mark.parametrize("offset", SEPARATED)
def test_what_scans_bring(offset: float) -> None:
    trials = 2000
    for k, (scans, correct) in enumerate(zip((3, 5, 10, 20), SEPARATED[int(offset)], strict=True)):
        found = at_the_end({"scans": scans, "offset_along_m": offset}, {}, trials)
        band = 4 * np.sqrt(max(correct * (1 - correct), 0.005) * (1 / trials + 1 / 3000)) + 0.0005
        assert found["probability_correct"] == pytest.approx(correct, abs=band), scans
        if offset == 300:
            paired = PAIRED_AT_300[k]
            within = 4 * np.sqrt(max(paired * (1 - paired), 1e-3) * (1 / trials + 1 / 3000)) + 0.0005
            assert found["assignment_correct"] == pytest.approx(paired, abs=within), scans


@pytest.mark.slow
@pytest.mark.parametrize(("density", "ignored"), [(1, 2.89), (10, 2.65), (100, 2.52)])
def test_ignoring_the_common_manoeuvres_makes_the_gate_too_wide(density: float, ignored: float) -> None:
    scenario = {"scans": 20, "offset_along_m": 600, "acceleration_density_m2ps3": density}
    without = at_the_end(scenario, {"acceleration_density_m2ps3": density})
    with_it = at_the_end(scenario, {"acceleration_density_m2ps3": density, "cross_covariance": True})
    assert 4 * without["nis"] == pytest.approx(ignored, abs=0.35)
    assert 3.8 < 4 * with_it["nis"] < 5.0
    assert with_it["false_rejection"] > without["false_rejection"]
    if density == 1:
        assert without["false_rejection"] == pytest.approx(0.005, abs=4 * np.sqrt(0.005 / 1000) + 0.001)
        assert without["probability_correct"] == pytest.approx(0.865, abs=0.055)
        assert with_it["probability_correct"] == pytest.approx(0.920, abs=0.045)
        assert with_it["probability_correct"] > without["probability_correct"]
