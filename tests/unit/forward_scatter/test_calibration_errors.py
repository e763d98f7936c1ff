"""Clocks, carriers, places and wavelength that are known only so well: table 8.7 in the predicted errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.parameters import CALIBRATION
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

LINES, ML, ANGLE, KALMAN = (f"forward_scatter_{n}" for n in ("lines", "ml", "angle", "kalman"))
EPOCH = 16


def made(trials: int = 1, **scenario: Any) -> DopplerPairs:
    # Hardly any noise: what is added to the errors is then that of the true pass.
    return simulate(PassParameters(sigma_doppler_hz=0.002, **scenario), tuple(range(trials)), 5)


def run(name: str, recording: DopplerPairs, **parameters: Any) -> Result:
    algorithm = algorithms_by_name()[name]
    return algorithm.run(recording, algorithm.parameters(**parameters), LocalContext())


def added(name: str, recording: DopplerPairs, **parameters: Any) -> float:
    """By how much the predicted variance of s grows, as a standard deviation, m."""
    with_, without = (run(name, recording, **p).arrays["theta_covariance"][EPOCH, 1, 1, 0] for p in (parameters, {}))
    return float(np.sqrt(with_ - without))


@pytest.mark.parametrize(
    ("parameter", "sd", "near", "far"),
    [
        ("sigma_clock_ms", 10.0, 203, 400),
        ("sigma_frequency_offset_hz", 0.1, 463, 753),
        ("sigma_spacing_percent", 1.0, 187, 147),
        ("sigma_base_percent", 1.0, 56, 227),
        ("sigma_wavelength_percent", 1.0, 93, 74),
    ],
)
@pytest.mark.parametrize("name", [LINES, ML, KALMAN])
def test_each_error_adds_what_table_8_7_says(name: str, parameter: str, sd: float, near: float, far: float) -> None:
    """The table is of the paper's method at the true place; the fit differs at 30 km, as its course moves too."""
    allowed = 0.15 if name == LINES else 0.25
    for distance, expected in ((15_000.0, near), (30_000.0, far)):
        recording = made(crossing_distance_m=distance)
        assert added(name, recording, **{parameter: sd}) == pytest.approx(expected, rel=allowed), distance
        # Twice the error costs twice as much.
        assert added(name, recording, **{parameter: 2 * sd}) == pytest.approx(2 * expected, rel=allowed), distance


def test_estimates_stay_and_errors_add_up() -> None:
    recording = made()
    together = {"sigma_clock_ms": 10.0, "sigma_spacing_percent": 1.0}
    for name in (LINES, ML):
        plain, told = run(name, recording), run(name, recording, **together)
        assert told.arrays["theta"].tobytes() == plain.arrays["theta"].tobytes()
        assert told.arrays["status"].tobytes() == plain.arrays["status"].tobytes()
        parts = [added(name, recording, **{key: value}) for key, value in together.items()]
        assert added(name, recording, **together) == pytest.approx(np.hypot(*parts), rel=1e-6)
        k = 20
        assert (told.arrays["covariance"][k, 0, 0] > plain.arrays["covariance"][k, 0, 0]).all(), "the ellipse grows too"
        assert {n.code: n.count for n in told.notes} == {n.code: n.count for n in plain.notes}


def test_one_receiver_knows_no_other_clock() -> None:
    recording = made()
    assert added(ANGLE, recording, sigma_clock_ms=10.0, sigma_frequency_offset_hz=0.1) == 0
    assert added(ANGLE, recording, sigma_base_percent=1.0) == pytest.approx(56, rel=0.1)


def test_trials_and_passes_have_each_their_own() -> None:
    recording = made(trials=3, targets=2, target_interval_s=60.0, distance_step_m=15_000.0, missing_share=0.1)
    told, plain = (run(LINES, recording, **p).arrays["theta_covariance"] for p in ({"sigma_clock_ms": 10.0}, {}))
    more = np.sqrt((told - plain)[:, 1, 1])
    assert more[EPOCH] == pytest.approx(np.full(3, 203), rel=0.15)
    assert more[31 + EPOCH] == pytest.approx(np.full(3, 400), rel=0.15)


def test_nobody_changes_an_estimate_by_them() -> None:
    """Their names are what the sensitivity panel leaves out."""
    fields = algorithms_by_name()[ML].parameters.model_fields
    assert set(CALIBRATION) <= set(fields)
    assert all(fields[name].default == 0 for name in CALIBRATION)
