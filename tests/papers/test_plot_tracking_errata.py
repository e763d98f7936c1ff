"""Errata of the paper (specification 11) that stand in no other test: each shows what the printed form would do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import erf

from algorithms.plot_tracking import gates
from algorithms.plot_tracking.base_points import printed_systems
from algorithms.plot_tracking.curve_fit import Limits, fit_curve
from algorithms.plot_tracking.window import Window, whitened
from algorithms.toolbox.motion import curvature

SIGMA_R, SIGMA_TH = 200.0, np.radians(8 / 60)


def on_circle(p: np.ndarray, t: np.ndarray, sign: float) -> np.ndarray:
    """Y by eq. (3): the centre's y with R cos(gamma) taken away (sign -1), or added as it is printed (+1)."""
    _, y0, g0, b, a, bend = p
    gamma = g0 + bend * (b + 0.5 * a * t) * t
    return y0 - sign * np.cos(g0) / bend + sign * np.cos(gamma) / bend


def test_the_second_line_of_eq_3_has_the_wrong_sign() -> None:
    p = np.array([0.0, 0.0, 0.7, 200.0, 0.0, np.radians(1.31) / 200])
    step = np.array([-1e-3, 1e-3])
    slopes = [np.diff(on_circle(p, step, sign))[0] / 2e-3 for sign in (1.0, -1.0)]
    assert slopes == pytest.approx([-128.84, 128.84], abs=0.01)
    t = np.linspace(0, 40, 81)
    right = curvature.position(p[:, None], t)[1]
    assert np.allclose(on_circle(p, t, -1.0), right, atol=1e-6)
    assert np.abs(on_circle(p, t, 1.0) - right).max() > 5e3


def test_the_centre_form_has_no_straight_flight() -> None:
    nearly = np.array([0.0, 0.0, 0.7, 200.0, 0.0, 1e-15])
    t = np.array(10.0)
    exact = 2000 * np.sin(0.7)
    assert curvature.position(nearly, t)[1] == pytest.approx(exact, abs=1e-8)
    assert abs(float(on_circle(nearly, t, -1.0)) - exact) > 1e-3
    straight = nearly * [1, 1, 1, 1, 1, 0]
    assert curvature.position(straight, t)[1] == pytest.approx(exact, abs=1e-9)


def test_weights_cannot_be_left_out() -> None:
    """Metres and radians in one sum: without weights azimuths count for next to nothing, and hardly a fit converges."""
    rng = np.random.default_rng(2)
    p = np.array([40e3, 42e3, np.pi / 2, 200.0, 0.0, 0.0])
    shape = (8, 200)
    t = np.broadcast_to(np.arange(-35.0, 1, 5)[:, None], shape)
    x, y = curvature.position(p[:, None, None], t)
    rho, theta = (
        np.hypot(x, y) + SIGMA_R * rng.standard_normal(shape),
        np.arctan2(y, x) + SIGMA_TH * rng.standard_normal(shape),
    )

    def fitted(sigma_r: float, sigma_th: float) -> tuple[float, float]:
        """Rms error of the place in m, and the share of windows that end in a minimum."""
        window = Window(rho, theta, t, np.ones(shape, bool), np.full(shape, sigma_r), np.full(shape, sigma_th))
        found = fit_curve(window, Limits())
        off = (found.p[0] - p[0]) ** 2 + (found.p[1] - p[1]) ** 2
        return float(np.sqrt(np.mean(off))), float(found.converged.mean())

    weighted, bare = fitted(SIGMA_R, SIGMA_TH), fitted(1.0, 1.0)
    assert weighted[0] < 225
    assert weighted[1] == 1
    assert bare[0] > 1.1 * weighted[0]
    assert bare[1] < 0.1


def test_the_determinants_of_the_variance_formula_are_nothing() -> None:
    t = np.arange(-60, 1, 5.0)
    p = np.array([50_000, 30_000, 1.2, 200, 1, 1e-4])
    system = printed_systems(p, t, np.array([-60.0, -40, -20, 0]), SIGMA_R, SIGMA_TH)
    for matrix in (system.ranges, system.azimuths):
        normal = matrix.T @ matrix
        assert abs(np.linalg.det(normal)) / np.prod(np.diagonal(normal)) < 1e-40
    window = Window(*(np.ones((13, 1)) for _ in range(2)), t[:, None], np.ones((13, 1), bool),
                    np.full((13, 1), SIGMA_R), np.full((13, 1), SIGMA_TH))  # fmt: skip
    _, j = whitened(window, p[:, None])
    joint = j[..., 0].T @ j[..., 0]
    d = np.sqrt(np.diagonal(joint))
    assert np.linalg.det(joint / d[:, None] / d[None]) > 1e-9


def test_one_dimensional_quantiles_hold_too_little() -> None:
    """0.93, 1.96 and 3.09 are radii that hold .354, .853 and .992 of a Gaussian in the plane."""
    for confidence, held in ((0.65, 0.354), (0.95, 0.853), (0.998, 0.992)):
        quantile = {0.65: 0.9346, 0.95: 1.95996, 0.998: 3.0902}[confidence]
        assert erf(quantile / np.sqrt(2)) == pytest.approx(confidence, abs=1e-4)
        assert 1 - np.exp(-(quantile**2) / 2) == pytest.approx(held, abs=1e-3)
        assert 1 - np.exp(-(float(gates.radius_of(np.array(confidence))) ** 2) / 2) == pytest.approx(confidence)


def test_the_speed_along_the_chord_is_harmless() -> None:
    """0.05 to 0.3 % in a scan of 5 s for turns of 1.31 and 3 degrees a second; two plots err by 57 m/s."""
    for rate, share in ((1.31, 0.0005), (3.0, 0.003)):
        assert 1 - curvature.sinc(np.array(np.radians(rate) * 5 / 2)) == pytest.approx(share, rel=0.15)
    assert np.sqrt(2) * SIGMA_R / 5 == pytest.approx(57, abs=0.5)


def test_a_thousand_metres_a_second_search_six_times_the_area() -> None:
    wide, narrow = (float(gates.start_radius(60e3, 5.0, v, SIGMA_R, SIGMA_TH)) for v in (1000.0, 350.0))
    assert (wide / narrow) ** 2 == pytest.approx(6.3, abs=0.05)


def test_an_arctangent_of_a_quotient_loses_the_quadrant() -> None:
    p = np.array([-3e4, -4e4, 0.3, 200.0, 0.0, 0.0])
    t = np.arange(-25.0, 1, 5)
    x, y = curvature.position(p[:, None], t)
    window = Window(
        np.hypot(x, y)[:, None], np.arctan2(y, x)[:, None], t[:, None], np.ones((6, 1), bool),
        np.full((6, 1), SIGMA_R), np.full((6, 1), SIGMA_TH),
    )  # fmt: skip
    assert fit_curve(window, Limits()).p[:4, 0] == pytest.approx(p[:4], rel=1e-6)
    # The quotient alone would put the target on the other side of the radar.
    assert np.abs(curvature.wrapped(np.arctan(y / x) - np.arctan2(y, x))).min() > 3
