"""Numbers and identities of the forward-scatter specification that need no trials (3 to 8.1, 10, 11)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.bound import bounds_along_base
from algorithms.forward_scatter.closed_form import distance
from algorithms.forward_scatter.conditions import conditions_of
from algorithms.forward_scatter.motion import crossing_bound, doppler_rows
from algorithms.forward_scatter.parameters import ScatterParameters
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.registry import algorithms_by_name
from algorithms.spec import LocalContext
from algorithms.toolbox.sensors.doppler import doppler_gradient, doppler_hz

A, B = 40_000.0, 300.0
TX, RX1, RX2 = np.array([[A, 0, 0], [0, -B / 2, 0], [0, B / 2, 0]])
T = np.arange(31.0)
FEET = np.array([[TX, RX1], [TX, RX2]])


def theta(distance_m: float) -> np.ndarray:
    return np.array([15.0, distance_m, 200.0, 0.0, 0.0])


def sd(rows: np.ndarray) -> np.ndarray:
    """Bound after all rows (C, K, P) at 0.2 Hz."""
    info = np.einsum("cki,ckj->ij", rows, rows) / 0.04
    scale = np.sqrt(np.diag(info))
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(info / np.outer(scale, scale)))) / scale)


def test_derivatives_are_those_of_complex_steps() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        p, v = rng.uniform([1e3, -3e3, 0], [39e3, 3e3, 5e3]), rng.uniform(-300, 300, 3)
        found = np.empty(6)
        value = doppler_gradient(*p, *v, np.array([TX, RX1]), 0.7, found)
        assert value == pytest.approx(doppler_hz(p, v, TX, RX1, 0.7), rel=1e-13)
        for i in range(6):
            x = np.concatenate([p, v]).astype(complex)
            x[i] += 1e-30j
            exact = doppler_hz(x[:3], x[3:], TX.astype(complex), RX1.astype(complex), 0.7).imag / 1e-30
            assert found[i] == pytest.approx(exact, rel=1e-10, abs=1e-14)


def test_derivatives_by_the_crossing() -> None:
    at = np.array([14.0, 17_000.0, 210.0, -60.0, 0.8])
    _, rows = doppler_rows(T, at, FEET, 1.0, 500.0)
    for i, step in enumerate((1e-4, 1.0, 1e-2, 1e-2, 1e-4)):
        high, low = at.copy(), at.copy()
        high[i] += step
        low[i] -= step
        numeric = (doppler_rows(T, high, FEET, 1.0, 500.0)[0] - doppler_rows(T, low, FEET, 1.0, 500.0)[0]) / (2 * step)
        assert rows[:, :, i] == pytest.approx(numeric, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("course", [30.0, 90.0, 120.0, -75.0])
def test_a_doppler_is_zero_on_its_line_of_sight_and_falls_there(course: float) -> None:
    v = 200 * np.array([np.cos(np.radians(course)), np.sin(np.radians(course)), 0.0])
    for s in (15_000.0, 30_000.0):
        place = RX1 + (TX - RX1) * s / A
        assert doppler_hz(place, v, TX, RX1, 1.0) == pytest.approx(0, abs=1e-12)
        before, after = (doppler_hz(place + side * v, v, TX, RX1, 1.0) for side in (-1e-3, 1e-3))
        slope = -(v[1] ** 2) * A / (s * (A - s))
        assert (after - before) / 2e-3 == pytest.approx(slope, rel=2e-2)


def test_section_8_1_exact_numbers() -> None:
    for s, first, last, slope, zeros in (
        (15_000.0, (61.1612, 64.9325), (-64.9325, -61.1612), -4.2667, (14.53125, 15.46875)),
        (30_000.0, (76.3844, 78.3548), (-78.3548, -76.3844), -5.3333, (14.8125, 15.1875)),
    ):
        f, _ = doppler_rows(T, theta(s), FEET, 1.0)
        assert f[:, 0] == pytest.approx(first, abs=5e-5)
        assert f[:, 30] == pytest.approx(last, abs=5e-5)
        assert -(200**2) * A / (s * (A - s)) == pytest.approx(slope, abs=5e-5)
        for j, zero in enumerate(zeros):
            assert doppler_rows(np.array([zero]), theta(s), FEET, 1.0)[0][j, 0] == pytest.approx(0, abs=1e-3)
        # b (a - s) / a is what the target flies between the two lines of sight: h = 187.5, 75 m.
        assert 200 * (zeros[1] - zeros[0]) == pytest.approx(B * (A - s) / A, abs=1e-9)
        at_crossing, _ = doppler_rows(np.array([15.0]), theta(s), FEET, 1.0)
        assert at_crossing[0, 0] - at_crossing[1, 0] == pytest.approx(-B * 200 / s, rel=1e-3)


@pytest.mark.parametrize(
    ("s", "printed"),
    [
        (15_000.0, (-163.4, -71.4, -6.2, 50.5, 20.7, 95.0, 291.8)),
        (30_000.0, (-387.4, -202.6, -78.6, 199.4, 193.5, 208.3, 247.4)),
    ],
)
def test_section_8_1_systematic_error(s: float, printed: tuple[float, ...]) -> None:
    quiet = simulate(PassParameters(crossing_distance_m=s, sigma_doppler_hz=1e-9), (0,), 0)
    algorithm = algorithms_by_name()["forward_scatter_lines"]
    found = algorithm.run(quiet, algorithm.parameters(), LocalContext()).arrays["theta"][:, 1, 0]
    assert found[[9, 12, 15, 16, 20, 25, 30]] - s == pytest.approx(printed, abs=0.06)


def test_section_11_exact_numbers_give_the_distance_back() -> None:
    """(14) and (18) 15000.000 and 30000.000 m; (19) has a term in b^2 and gives 14999.1 and 29999.93."""
    out = np.empty(2)
    for s, tau, nineteen in (
        (15_000.0, (14.53125, 15.46875), 14_999.1),
        (30_000.0, (14.8125, 15.1875), 29_999.93),
    ):
        omega = 200 / s
        gamma = -(200**2) * A / (s * (A - s))
        distance(14, *tau, omega, gamma, gamma, 15.0, A, B, 1.0, out)
        assert out == pytest.approx([s, omega], rel=1e-9)
        distance(18, *tau, np.nan, gamma, gamma, 15.0, A, B, 1.0, out)
        assert out == pytest.approx([s, omega], rel=1e-9)
        distance(17, *tau, np.nan, gamma, gamma, 15.0, A, B, 1.0, out)
        assert out == pytest.approx([s, omega], rel=1e-9)
        # The mean slope of both receivers at 15 s lacks b^2 / 8 (1/s^3 + ...) of that in the middle.
        f, _ = doppler_rows(np.array([14.999, 15.001]), theta(s), FEET, 1.0)
        mean = float((f[:, 1] - f[:, 0]).mean()) / 2e-3
        distance(19, *tau, omega, mean, mean, 15.0, A, B, 1.0, out)
        assert out[0] == pytest.approx(nineteen, abs=0.03)


def test_section_4_parallel_lines_make_three_formulas_one() -> None:
    rng = np.random.default_rng(4)
    out = np.empty(2)
    for _ in range(20):
        omega, gamma = rng.uniform(0.004, 0.02), rng.uniform(-8, -2)
        d = -B * omega / gamma
        found = []
        for formula in (14, 18, 19):
            distance(formula, 15 - d / 2, 15 + d / 2, omega, gamma, gamma, 15.0, A, B, 1.0, out)
            found.append(out[0])
        assert found == pytest.approx([found[0]] * 3, rel=1e-12)


def test_section_10_a_denominator_of_zero_is_no_distance() -> None:
    out = np.empty(2)
    distance(14, 15.0, 16.0, -B / A, -4.0, -4.0, 15.0, A, B, 1.0, out)
    assert np.isnan(out[0])
    distance(14, 15.0, 15.0, 0.01, -4.0, -4.0, 15.0, A, B, 1.0, out)
    assert out[0] == pytest.approx(A), "D -> 0: near the transmitter"
    distance(19, 15.0, 16.0, 0.01, 0.0, 0.0, 15.0, A, B, 1.0, out)
    assert np.isnan(out[0]), "no slope"


def test_section_7_one_doppler_does_not_tell_the_ends_apart() -> None:
    """Nor the sign of v_y; two transmitters are two receivers seen from the other end."""
    middle = np.array([[TX, [0.0, 0.0, 0.0]]])
    one, _ = doppler_rows(T, theta(12_000.0), middle, 1.0)
    other, _ = doppler_rows(T, theta(28_000.0), middle, 1.0)
    back, _ = doppler_rows(T, theta(12_000.0) * [1, 1, -1, 1, 1], middle, 1.0)
    assert other == pytest.approx(one, abs=1e-13)
    assert back == pytest.approx(one, abs=1e-13)
    origin = np.zeros(3)
    transmitters = np.array([[[A, -B / 2, 0], origin], [[A, B / 2, 0], origin]])
    there, _ = doppler_rows(T, theta(28_000.0), transmitters, 1.0)
    here, _ = doppler_rows(T, theta(12_000.0), FEET, 1.0)
    assert there == pytest.approx(here, abs=1e-13)


@pytest.mark.parametrize(("s", "plain", "offset", "height"), [(15e3, 249, 1714, 186e3), (30e3, 281, 398, 6.11e3)])
def test_sections_6_3_and_8_7_what_one_pass_cannot_tell(s: float, plain: float, offset: float, height: float) -> None:
    """With the offset between the receivers unknown the bound of s rises; the bound of H is kilometres."""
    _, rows = doppler_rows(T, theta(s), FEET, 1.0)
    of_second = np.zeros((2, T.size, 1))
    of_second[1] = 1.0
    assert sd(rows[:, :, :4])[1] == pytest.approx(plain, abs=0.5)
    assert sd(np.concatenate([rows[:, :, :4], of_second], axis=2))[1] == pytest.approx(offset, abs=0.5)
    high, low = (doppler_rows(T, theta(s), FEET, 1.0, 2000.0 + h)[0] for h in (1.0, -1.0))
    _, rows = doppler_rows(T, theta(s), FEET, 1.0, 2000.0)
    with_height = np.concatenate([rows[:, :, :4], ((high - low) / 2)[:, :, None]], axis=2)
    assert sd(with_height)[4] == pytest.approx(height, rel=0.01)


def test_section_5_a_bound_that_cannot_be_computed_is_not_available() -> None:
    """One pair cannot tell four unknowns; one channel alone is symmetrical at the crossing."""
    _, rows = doppler_rows(T, theta(15_000.0), FEET, 1.0)
    there = np.ones(rows.shape[:2], np.bool_)
    found = crossing_bound(rows, there, 0.2, 4)
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[2:]).all()
    assert np.isnan(crossing_bound(rows, np.zeros_like(there), 0.2, 3)).all()


def test_the_map_of_the_bound_is_the_bound_at_each_place() -> None:
    conditions = conditions_of(simulate(PassParameters(), (), 0), ScatterParameters())
    places, bounds = bounds_along_base(conditions, T, theta(20_000.0))
    expected: dict[float, Any] = {15_000.0: (346, 249, 360, 249), 30_000.0: (441, 281, 506, 281)}
    for s, row in expected.items():
        at = np.flatnonzero(np.isclose(places, s))
        assert at.size == 1
        # At the crossing: from the first measurement that is not before it.
        assert bounds[at[0]] == pytest.approx(row, abs=0.6)
    assert bounds[0, 1] < 30, "it vanishes near the ends"
    assert bounds[-1, 1] < 10
