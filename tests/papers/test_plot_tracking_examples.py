"""Worked examples and errata of the plot-tracking specification (sections 3-5, 11, 12)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from algorithms.plot_tracking import gates
from algorithms.plot_tracking.base_points import fit_by_base_points, printed_systems
from algorithms.plot_tracking.curve_fit import Limits, fit_curve
from algorithms.plot_tracking.line_fit import fit_line
from algorithms.plot_tracking.window import Window, covariance_of
from algorithms.toolbox.motion import curvature

W1 = np.array([50_000, 30_000, 1.2, 200, 1, 1e-4])
SIGMA_R, SIGMA_TH = 200.0, np.radians(8 / 60)


def window(rho: list[float], theta: list[float], step_s: float = 5.0) -> Window:
    n = len(rho)
    return Window(
        np.array(rho)[:, None],
        np.array(theta)[:, None],
        step_s * np.arange(1.0 - n, 1.0)[:, None],
        np.ones((n, 1), bool),
        np.full((n, 1), SIGMA_R),
        np.full((n, 1), SIGMA_TH),
    )


W3 = window([57_320, 57_535, 57_510, 57_430, 57_780, 57_650], [0.5290, 0.5350, 0.5467, 0.5600, 0.5655, 0.5860])


@pytest.mark.parametrize(
    ("t", "x", "y", "speed", "course"),
    [
        (-10.0, 49121.2288074833, 28262.695397667, 190, 1.005),
        (5.0, 50318.5272011894, 30960.6358225363, 205, 1.30125),
        (30.0, 50306.0204658574, 36331.3820044194, 230, 1.845),
    ],
)
def test_w1_the_chord_form(t: float, x: float, y: float, speed: float, course: float) -> None:
    later = curvature.shifted(W1, np.array(t))
    assert_allclose(later[:4], [x, y, course, speed], rtol=1e-13)
    assert_allclose(curvature.position(W1, np.array(t)), [x, y], rtol=1e-13)


def test_w1_the_series() -> None:
    assert_allclose(
        curvature.series_coefficients(W1, 5), [200, 1 + 4j, -0.08 + 0.06j, -0.0024 - 0.0013j, 2e-6 - 8e-5j], rtol=1e-12
    )
    assert_allclose(curvature.position_by_series(W1, np.array(30.0), 3), [50277.4378168, 36426.1985853], atol=5e-8)
    assert_allclose(curvature.position_by_series(W1, np.array(30.0), 5), [50304.2258417, 36329.3122531], atol=5e-8)


def test_w1_the_jacobian() -> None:
    x, y, dx, dy = curvature.position_jacobian(W1, np.array(5.0))
    rho = np.hypot(x, y)
    assert_allclose([rho, np.arctan2(y, x)], [59080.5818372886, 0.5515885042], rtol=1e-10)
    to_rho = [0.85169316, 0.52404081, -651.24570, 3.6595978, 9.1489946, -336312.505]
    to_theta = [-8.86993309e-6, 1.44157882e-5, 1.31125961e-2, 5.76662433e-5, 1.44165608e-4, 6.54406649]
    assert_allclose((x * dx + y * dy) / rho, to_rho, rtol=2e-8)
    assert_allclose((x * dy - y * dx) / rho**2, to_theta, rtol=2e-8)


def test_the_chord_form_solves_the_equations_of_motion() -> None:
    """Against numerical integration over 40 s, with a turn to either side, straight, and at rest."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        speed, a, bend = rng.uniform(0, 300), rng.choice([0.0, -2.0, 3.0]), rng.choice([0.0, 1e-15, 1e-4, -2e-4])
        p = np.array([1e4, -2e4, rng.uniform(-3, 3), speed, a, bend])
        truth = solve_ivp(
            lambda t, z, b=speed, a=a, k=bend: [
                (b + a * t) * np.cos(z[2]),
                (b + a * t) * np.sin(z[2]),
                k * (b + a * t),
            ],
            (0, 40),
            p[:3],
            rtol=1e-12,
            atol=1e-9,
        ).y[:, -1]
        assert_allclose(curvature.shifted(p, np.array(40.0))[:3], truth, rtol=0, atol=1e-6)


def test_the_jacobian_is_the_derivative_on_both_sides_of_its_series() -> None:
    for bend in (0.0, 1e-6, 0.0099 / 1050, 0.0101 / 1050, -3e-4):
        p = np.array([5e4, 3e4, 1.2, 200.0, 1.0, bend])
        step = np.array([1e-2, 1e-2, 1e-6, 1e-3, 1e-4, 1e-9])
        _, _, dx, dy = curvature.position_jacobian(p, np.array(5.0))
        for i in range(6):
            e = np.zeros(6)
            e[i] = step[i]
            up, down = curvature.position(p + e, np.array(5.0)), curvature.position(p - e, np.array(5.0))
            assert_allclose([dx[i], dy[i]], (np.array(up) - down) / (2 * step[i]), rtol=2e-6, atol=1e-6 / step[i])


def test_w2_three_positions_fix_the_curve() -> None:
    t = np.array([0.0, 5.0, 10.0])
    found = curvature.from_three_positions(*curvature.position(W1[:, None], t), t)
    assert_allclose(found, [50542.481580988, 31973.1996428106, 1.405, 210, 1, 1e-4], rtol=1e-10)


def test_three_positions_recover_random_motions() -> None:
    """2,000 motions at once; turns of less than 360 degrees, no reversal of speed."""
    rng = np.random.default_rng(5)
    n = 2000
    t = np.sort(rng.uniform(0, 40, (3, n)), axis=0) + np.array([[0.0], [2.0], [4.0]])
    speed = rng.uniform(60, 300, n)
    p = np.stack(
        [*rng.uniform(-1e5, 1e5, (2, n)), rng.uniform(-3, 3, n), speed, rng.uniform(-1, 3, n), rng.normal(0, 1e-4, n)]
    )
    found = curvature.from_three_positions(*curvature.position(p[:, None], t), t)
    truth = curvature.shifted(p, t[2])
    truth[2] = curvature.wrapped(truth[2])
    found[2] = truth[2] + curvature.wrapped(found[2] - truth[2])
    scale = np.array([1.0, 1.0, 1e-5, 1e-3, 1e-4, 1e-9])[:, None]
    assert (np.abs(found - truth) < 2 * scale).all()


def test_coincident_positions_give_no_curve() -> None:
    t = np.array([0.0, 5.0, 10.0])
    assert np.isnan(curvature.from_three_positions(np.zeros(3), np.array([0.0, 0.0, 9.0]), t)).all()
    assert np.isnan(curvature.from_three_positions(np.arange(3.0), np.arange(3.0), np.zeros(3))).all()


def test_the_same_motion_backwards() -> None:
    p = np.array([1.0, 2.0, 0.3, -50.0, 1.0, 1e-3])
    t = np.linspace(-20, 20, 9)
    forward = curvature.with_forward_speed(p)
    assert forward[3] == 50
    assert_allclose(curvature.position(forward[:, None], t), curvature.position(p[:, None], t), atol=1e-9)


def test_w3_the_three_fits_of_one_window() -> None:
    line = fit_line(W3)
    assert_allclose(line.p[:4, 0], [48221.058983, 31696.567079, 2.02662319, 128.753494], rtol=1e-8)
    free = fit_curve(W3, Limits())
    # An iteration stops at 1e-7 standard deviations.
    printed = np.array([48114.9044, 31825.5004, 2.11903689, 177.745270, 3.90323062, 5.6896319e-5])
    assert (np.abs(free.p[:, 0] - printed) < 2e-6 * np.sqrt(np.diagonal(covariance_of(free.information)[..., 0]))).all()
    assert free.cost[0] == pytest.approx(7.51875408, abs=1e-8)
    sd = np.sqrt(np.diagonal(covariance_of(free.information)[..., 0]))
    assert_allclose(sd, [171.30, 144.92, 0.26580, 22.957, 1.7644, 1.5746e-4], rtol=3e-5)
    held = fit_curve(W3, Limits(), penalised=True)
    printed = np.array([48168.7876, 31747.7603, 2.09322794, 149.493833, 1.64775677, 4.2915490e-5])
    assert (np.abs(held.p[:, 0] - printed) < 2e-6 * np.sqrt(np.diagonal(covariance_of(held.information)[..., 0]))).all()
    sd = np.sqrt(np.diagonal(covariance_of(held.information)[..., 0]))
    assert_allclose(sd, [155.08, 128.65, 0.20520, 15.667, 1.1422, 1.1853e-4], rtol=5e-5)


def test_w3_the_variance_rule_of_the_paper_is_the_inverse() -> None:
    information = fit_curve(W3, Limits()).information[..., 0]
    d = np.sqrt(np.diagonal(information))
    scaled = information / d[:, None] / d[None]
    cofactors = [np.linalg.det(np.delete(np.delete(scaled, i, 0), i, 1)) for i in range(6)]
    rule = np.sqrt(np.array(cofactors) / np.linalg.det(scaled)) / d
    assert_allclose(rule, np.sqrt(np.diagonal(covariance_of(information[..., None])[..., 0])), rtol=1e-9)


def test_w3_the_predicted_point_and_its_gate() -> None:
    x, y = curvature.position(fit_curve(W3, Limits()).p[:, 0], np.array(5.0))
    predicted = (np.hypot(x, y), np.arctan2(y, x))
    assert_allclose(predicted, [57704.50068, 0.60062579], rtol=1e-8)
    d2 = gates.squared_distance(57_900.0, 0.5935, predicted, SIGMA_R, SIGMA_TH, float(gates.variance_ratio(4)))
    assert d2 == pytest.approx(1.65309574, abs=1e-6)
    assert gates.classes(d2) == 0
    assert gates.log_likelihood_ratio(d2, 4) == pytest.approx(0.76638346, abs=1e-6)


def test_w3_base_points_have_the_same_minimum_and_a_better_condition() -> None:
    free, (base, condition) = fit_curve(W3, Limits()), fit_by_base_points(W3)
    assert base.converged.all()
    sd = np.sqrt(np.diagonal(covariance_of(free.information)[..., 0]))
    assert (np.abs(base.p[:, 0] - free.p[:, 0]) < 1e-4 * sd).all()
    assert condition[0] < 6.5
    information = free.information[..., 0]
    d = np.sqrt(np.diagonal(information))
    assert np.linalg.cond(information / d[:, None] / d[None]) > 50 * condition[0]


def test_w4_start_and_acquisition_gates() -> None:
    assert_allclose(gates.start_axes(60e3, 1000 * 5.0, SIGMA_R, SIGMA_TH), [5400, 5279.2527], rtol=1e-8)
    assert gates.start_radius(60e3, 5.0, 1000.0, SIGMA_R, SIGMA_TH) == 5400
    assert_allclose(gates.acquisition_axes(60e3, SIGMA_R, SIGMA_TH), [3000, 2094.3951], rtol=1e-8)


def test_w5_costs_of_pairs() -> None:
    d2 = np.array([[0.5, 0.9], [0.7, 20.0]])
    cost = -gates.log_likelihood_ratio(d2, np.array([[12], [3]]))
    assert_allclose(cost[[0, 0, 1], [0, 1, 0]], [-2.25574, -2.07241, -0.86528], atol=5e-6)
    assert gates.classes(d2)[1, 1] == gates.OUTSIDE


def test_w6_the_printed_systems_are_singular() -> None:
    systems = printed_systems(W1, np.arange(-60, 1, 5.0), np.array([-60.0, -40, -20, 0]), SIGMA_R, SIGMA_TH)
    for matrix, values in (
        (systems.ranges, [1.988, 1.497, 1.218, 0.168, 0.0023, 0, 0, 0]),
        (systems.azimuths, [2.022, 1.545, 1.252, 0.529, 0.0033, 0, 0, 0]),
        (systems.stacked, [2.040, 2.027, 1.570, 1.499, 1.251, 1.217, 0, 0]),
    ):
        found = np.linalg.svd(matrix, compute_uv=False)
        assert_allclose(found, values, atol=6e-4)
        assert (found[np.array(values) == 0] < 1e-9).all()
    # Turning everything about the radar changes no range; scaling every range changes no azimuth.
    rho = np.hypot(*curvature.position(W1[:, None], np.array([-60.0, -40, -20, 0])))
    assert np.abs(systems.ranges @ np.repeat([0.0, 1.0], 4)).max() < 1e-9
    assert np.abs(systems.azimuths @ np.concatenate([rho, np.zeros(4)])).max() < 1e-9


def test_the_factor_of_the_gates_is_a_ratio_of_variances() -> None:
    """K_Q against the covariance of a least-squares line, and the radii against the Gaussian they belong to."""
    assert_allclose(gates.variance_ratio(np.arange(2, 6)), [6, 10 / 3, 2.5, 2.1])
    for q in range(2, 13):
        design = np.stack([np.ones(q), np.arange(1.0 - q, 1.0)], axis=1)
        ahead = np.array([1.0, 1.0])
        ratio = 1 + ahead @ np.linalg.inv(design.T @ design) @ ahead
        assert gates.variance_ratio(q) == pytest.approx(ratio, rel=1e-12)
        assert gates.line_variance_ratio(q, 1) == pytest.approx(ratio, rel=1e-12)
    assert_allclose(gates.radius_of(np.array([0.65, 0.95, 0.998])), [1.4490, 2.4477, 3.5255], atol=5e-5)


def test_the_likelihood_ratio_must_not_be_a_gate_of_its_own() -> None:
    """L > 0 would keep three quarters of the true plots at Q = 2."""
    for q, kept in ((2, 0.75), (12, 0.93)):
        limit = 2 * q * np.log(q) / (q - 1)
        assert gates.log_likelihood_ratio(limit, q) == pytest.approx(0, abs=1e-12)
        assert 1 - np.exp(-limit / 2) == pytest.approx(kept, abs=0.005)
