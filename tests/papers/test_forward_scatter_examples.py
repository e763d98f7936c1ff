"""Worked examples W1-W3 of the forward-scatter specification (section 9), to the digits given."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.closed_form import errors_of_answer
from algorithms.forward_scatter.conditions import conditions_of
from algorithms.forward_scatter.motion import crossing_bound, doppler_rows
from algorithms.forward_scatter.parameters import ScatterParameters
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

SITE = PassParameters(
    base_m=50_000, spacing_m=400, wavelength_m=0.5, crossing_distance_m=20_000, crossing_time_s=20, speed_mps=150
)
T = np.arange(41.0)
THETA = np.array([20.0, 20_000.0, 150.0, 0.0, 0.0])
WAVE = 0.2 * np.sin(1.7 * T[:, None] + 0.9 * np.array([1, 2]))


def recording(wave: np.ndarray | float = 0.0) -> DopplerPairs:
    """W1 without noise, or with what is added to the Dopplers (41, 2)."""
    made = simulate(SITE, (0,), 0)
    conditions = conditions_of(made, ScatterParameters())
    exact, _ = doppler_rows(T, THETA, conditions.feet, conditions.wavelength)
    return replace(made, doppler_hz=np.ascontiguousarray((exact.T + wave)[:, :, None]))


def run(name: str, of: DopplerPairs, **parameters: Any) -> Result:
    algorithm = algorithms_by_name()[name]
    return algorithm.run(of, algorithm.parameters(**parameters), LocalContext())


def lines(of: DopplerPairs, **parameters: Any) -> Result:
    return run("forward_scatter_lines", of, window=8, **parameters)


def rows_of(of: DopplerPairs) -> tuple[np.ndarray, np.ndarray]:
    conditions = conditions_of(of, ScatterParameters())
    return doppler_rows(T, THETA, conditions.feet, conditions.wavelength)


def test_w1_dopplers_and_derivatives() -> None:
    value, rows = rows_of(recording())
    found = [value[0, 0], value[1, 0], value[0, 10], value[1, 20]]
    assert found == pytest.approx([71.445469066622, 77.248266038302, 34.440221407972, 2.999850011249], rel=1e-12)
    printed = [3.730208089877, -4.707225682474e-4, 0.4782820153783, 6.423562432621e-3]
    assert rows[0, 10, :4] == pytest.approx(printed, rel=1e-8)


@pytest.mark.parametrize(
    ("k", "tau_1", "tau_2", "omega", "s", "across", "y"),
    [
        (7, 19.36312776, 21.02754889, 0.0073276681, 19805.5828, 145.1287373, -1915.02279),
        (15, 19.21805136, 20.83501615, 0.007450927376, 19952.22711, 148.6625952, -747.2575528),
        (20, 19.20044629, 20.80306164, 0.007488579502, 19998.68761, 149.7617621, -0.2626773729),
        (21, 19.20044629, 20.80118613, 0.00749236213, 20006.6797, 149.8972893, 149.7749415),
        (40, 19.20044629, 20.80118613, 0.0073276681, 20274.01318, 148.5612397, 2971.103536),
    ],
)
def test_w1_lines(k: int, tau_1: float, tau_2: float, omega: float, s: float, across: float, y: float) -> None:
    a = lines(recording()).arrays
    assert a["crossing_s"][k, :, 0] == pytest.approx([tau_1, tau_2], rel=1e-8)
    assert a["omega_rad_s"][k, 0] == pytest.approx(omega, rel=1e-8)
    assert a["theta"][k, 1:3, 0] == pytest.approx([s, across], rel=1e-8)
    # The base line runs east, so y is north.
    assert a["state"][k, [0, 3], 0] == pytest.approx([s, y], rel=1e-8, abs=1e-6)


def test_w1_bounds() -> None:
    _, rows = rows_of(recording())
    measured = np.ones(rows.shape[:2], np.bool_)
    assert crossing_bound(rows, measured, 0.2, 3)[20] == pytest.approx([0.015882, 254.275, 0.331571], rel=2e-5)
    four = crossing_bound(rows, measured, 0.2, 4)[20]
    assert four == pytest.approx([0.020906, 293.415, 0.362451, 8.83951], rel=3e-5)


def test_w1_predicted_error() -> None:
    """At the true values, as the Monte Carlo number beside it."""
    gamma, omega = -(150.0**2) * 50_000 / (0.5 * 20_000 * 30_000), 150 / 20_000
    tau, centre, n, squares = np.array([19.2, 20.8]), 3.5, 8, 42.0
    variance = (0.2 / gamma) ** 2 * (1 / n + (tau - centre) ** 2 / squares)
    both = (0.5 / 400) * (0.04 / n) / gamma
    covariance = np.diag([*variance, 2 * (0.5 * 0.2 / 400) ** 2 / n, 0.04 / squares, 0.04 / squares])
    covariance[0, 2] = covariance[2, 0] = both
    covariance[1, 2] = covariance[2, 1] = -both
    answer = np.empty((3, 3))
    errors_of_answer(14, np.array([*tau, omega, gamma, gamma]), covariance, centre, 5e4, 400.0, 0.5, answer)
    assert np.sqrt(answer[1, 1]) == pytest.approx(1496.38, rel=2e-4)


W2 = {
    7: (19.29093291, 21.02177159, 0.00733707419, 19324.33261, 141.784062, 19548.52557, 18324.22783, 20343.96447),
    15: (19.2237178, 20.87933603, 0.007442676506, 19682.87842, 146.4932968, 20263.23521, 19272.42075, 20096.36061),
    20: (19.2093606, 20.79855465, 0.007480880958, 20112.05278, 150.4558727, 19699.91194, 20201.80526, 20022.43112),
    21: (19.2093606, 20.78381913, 0.007509356912, 20178.40629, 151.5268547, 20215.24053, 20339.05711, 20018.16799),
    40: (19.2093606, 20.78381913, 0.007342738861, 20449.0218, 150.151827, 20291.57851, 20553.61953, 20344.5886),
}


def test_w2_lines() -> None:
    """(17) as printed there: times from the start of the observation."""
    noisy = recording(WAVE)
    by_formula = {f: lines(noisy, formula=f, formula_17_origin="start").arrays for f in (14, 17, 18, 19)}
    for k, (tau_1, tau_2, omega, s14, across, s17, s18, s19) in W2.items():
        a = by_formula[14]
        assert a["crossing_s"][k, :, 0] == pytest.approx([tau_1, tau_2], rel=1e-8)
        assert a["omega_rad_s"][k, 0] == pytest.approx(omega, rel=1e-8)
        assert a["theta"][k, 2, 0] == pytest.approx(across, rel=1e-8)
        found = [by_formula[f]["theta"][k, 1, 0] for f in (14, 17, 18, 19)]
        assert found == pytest.approx([s14, s17, s18, s19], rel=1e-8)
    first = by_formula[14]
    assert first["theta"][1, 1, 0] == pytest.approx(33569.49, abs=0.005)
    assert first["state"][1, 3, 0] == pytest.approx(-4463, abs=0.5)


@pytest.mark.parametrize(
    ("parameters", "epochs", "printed"),
    [
        ({"freeze_rule": "b"}, [21, 40], [20116.44523, 20386.79785]),
        ({"freeze_rule": "c"}, [21, 40], [20033.38971, 20303.38449]),
        ({"freeze_delay": 3, "curvature_correction": True}, [24, 40], [20045.5078, 20021.40621]),
    ],
)
def test_w2_rules(parameters: dict[str, Any], epochs: list[int], printed: list[float]) -> None:
    a = lines(recording(WAVE), **parameters).arrays
    assert a["theta"][epochs, 1, 0] == pytest.approx(printed, rel=1e-8)


def test_w2_likelihood() -> None:
    a = run("forward_scatter_ml", recording(WAVE), acceleration_switch=False, sigma_velocity_along_mps=None).arrays
    assert a["theta"][40, :4, 0] == pytest.approx([19.9996975, 20001.599, 150.013467, 0.18015], rel=1e-5, abs=1e-5)
    assert a["chi2"][40, 0] == pytest.approx(40.89964, rel=1e-6)
    assert a["dof"][40, 0] == 78
    sd = np.sqrt(np.diagonal(a["theta_covariance"][40, :4, :4, 0]))
    assert sd == pytest.approx([0.0087201, 182.0695, 0.227374, 1.854756], rel=1e-5)
    assert a["theta"][20, :4, 0] == pytest.approx([20.0009082, 20086.6125, 150.041826, 2.63631], rel=1e-5)


def test_w3_one_receiver() -> None:
    one = simulate(SITE.model_copy(update={"one_receiver": True}), (0,), 0)
    conditions = conditions_of(one, ScatterParameters())
    exact, _ = doppler_rows(T, THETA, conditions.feet, conditions.wavelength)
    phi = np.arctan2(150 * (T - 20), 20_000) + 0.005 * np.sin(2.3 * T + 0.4)
    one = replace(
        one,
        doppler_hz=(exact[0] + 0.2 * np.sin(1.7 * T + 0.9))[:, None, None],
        azimuth_rad=(np.pi / 2 - phi)[:, None],
    )
    found = [run("forward_scatter_angle", one, window=8, omega=w).arrays for w in ("slope", "ends", "regression")]
    assert [a["theta"][15, 1, 0] for a in found] == pytest.approx([20283.73783, 20124.07667, 20040.37019], rel=1e-8)
    assert [a["theta"][40, 1, 0] for a in found] == pytest.approx([21974.83388, 20173.8863, 20088.07176], rel=1e-8)
    tau, gamma = found[2]["theta"][:, 0, 0], found[2]["gamma_hz_s"][:, 0]
    assert (tau[15], gamma[15]) == pytest.approx((20.03142961, -3.730947065), rel=1e-8)
    assert tau[20] == pytest.approx(20.01375715, rel=1e-8)
    assert tau[21:] == pytest.approx(19.98740029, rel=1e-8)
    assert gamma[21:] == pytest.approx(-3.762601057, rel=1e-8)
