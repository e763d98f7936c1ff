"""Gates, costs and the exact polar likelihood against the specification's worked example and quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from algorithms.errors import ParameterError, SingularGeometryError
from algorithms.toolbox.association.assignment import most_likely_matching, pair_costs, pair_scores
from algorithms.toolbox.association.exact import exact_probabilities
from algorithms.toolbox.association.gate import gate_threshold, squared_distances
from algorithms.toolbox.association.polar_fusion import PolarFusion, fuse_polar
from algorithms.toolbox.frames.polar_conversion import ConversionName, cartesian_from_polar, polar_statistic

# Worked example 2.
SITES = np.array([[0.0, 0.0], [25_000.0, 5_000.0]])
RANGE = np.array([[100_000.0, 100_500.0], [84_950.0, 84_450.0]])
ANGLE = np.array([[1.000, 1.010], [1.219, 1.231]])
SIGMA = 100.0, np.radians(0.7)
AREA = 15_000.0**2


def compared(conversion: ConversionName) -> tuple[np.ndarray, np.ndarray]:
    z, p = cartesian_from_polar(RANGE, ANGLE, *SIGMA, conversion)
    z = z + SITES[:, None]
    return squared_distances(z[0][:, None] - z[1][None], p[0][:, None] + p[1][None])


def fused(sigma: tuple[float, float] = SIGMA) -> PolarFusion:
    first, second = np.repeat([0, 1], 2), np.tile([0, 1], 2)
    return fuse_polar(
        SITES,
        np.stack([RANGE[0, first], RANGE[1, second]]),
        np.stack([ANGLE[0, first], ANGLE[1, second]]),
        np.full(2, sigma[0]),
        np.full(2, sigma[1]),
    )


def test_thresholds() -> None:
    assert gate_threshold(0.01, 2) == pytest.approx(9.210340, abs=5e-7)
    assert gate_threshold(0.01, 4) == pytest.approx(13.276704, abs=5e-7)
    assert gate_threshold(1e-6, 2) == pytest.approx(chi2.isf(1e-6, 2), rel=1e-12)


def test_distances_and_costs_of_the_worked_example() -> None:
    lin, _ = compared("lin")
    assert lin == pytest.approx(np.array([[8.363748, 0.404031], [0.376376, 6.506857]]), abs=1e-6)
    mucm, log_determinant = compared("mucm")
    assert mucm == pytest.approx(np.array([[8.362704, 0.403643], [0.379935, 6.455537]]), abs=1e-6)
    costs = pair_costs(mucm, log_determinant)
    assert costs == pytest.approx(np.array([[18.801053, 14.848503], [14.787149, 17.852393]]), abs=1e-6)


def test_scores_probabilities_and_matching_of_the_worked_example() -> None:
    costs = pair_costs(*compared("mucm"))
    complete, _ = exact_probabilities(-costs, complete=True)
    assert complete[0, 1] == pytest.approx(0.999105, abs=1e-6)
    scores = pair_scores(
        costs, detection_probability=(0.9, 0.85), target_density=4 / AREA, clutter_density=(2 / AREA, 3 / AREA)
    )
    assert scores == pytest.approx(np.array([[-0.589162, 3.363388], [3.424742, 0.359498]]), abs=1e-6)
    pairs, _ = exact_probabilities(scores)
    assert pairs == pytest.approx(np.array([[0.00141967, 0.96371175], [0.96563452, 0.00234307]]), abs=1e-8)
    assert 1 - pairs.sum(axis=1) == pytest.approx([0.03486857, 0.03202241], abs=1e-8)
    assert most_likely_matching(scores).tolist() == [1, 0]
    assert most_likely_matching(-costs, complete=True).tolist() == [1, 0]


def test_the_exact_polar_likelihood_of_the_worked_example() -> None:
    found = fused()
    assert found.converged.all()
    assert found.statistic == pytest.approx([8.318987, 0.404651, 0.374479, 6.578564], abs=1e-6)
    assert found.point[1] == pytest.approx([53492.452958, 84493.896854], abs=1.1e-6)
    expected = np.array([[202532.106, -96470.923], [-96470.923, 52189.655]])
    assert found.covariance[1] == pytest.approx(expected, abs=6e-4)
    assert found.cost == pytest.approx([18.784749, 14.819027, 14.809124, 17.902534], abs=1e-6)
    complete, _ = exact_probabilities(-found.cost.reshape(2, 2), complete=True)
    assert complete[0, 1] == pytest.approx(0.999141, abs=1e-6)


def test_the_place_is_a_minimum_and_its_cost_the_integral_over_all_places() -> None:
    found = fused()
    axes = np.linalg.cholesky(found.covariance[1])
    grid = np.linspace(-9, 9, 241)
    u = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1)
    places = found.point[1] + u @ axes.T
    r, b = (RANGE[0, 0], RANGE[1, 1]), (ANGLE[0, 0], ANGLE[1, 1])
    total = sum(polar_statistic(places - SITES[k], r[k], b[k], *SIGMA) for k in (0, 1))
    assert total.min() == pytest.approx(found.statistic[1], abs=1e-6)
    cell = (grid[1] - grid[0]) ** 2 * np.linalg.det(axes)
    density = np.exp(-total / 2).sum() * cell / (2 * np.pi * SIGMA[0] * SIGMA[1]) ** 2
    assert -np.log(density) + np.log(r[0]) + np.log(r[1]) == pytest.approx(found.cost[1], abs=0.0024)


def test_steps_converge_from_anywhere_even_at_four_degrees() -> None:
    rng = np.random.default_rng(5)
    n, sigma = 4000, np.radians(4.0)
    truth = np.array([106_066.0, 106_066.0])
    offset = truth - np.array([[0.0, 0.0], [30_000.0, 0.0]])
    r = np.hypot(*offset.T)[:, None] + 100 * rng.standard_normal((2, n))
    b = np.arctan2(offset[:, 1], offset[:, 0])[:, None] + sigma * rng.standard_normal((2, n))
    found = fuse_polar(np.array([[0.0, 0.0], [30_000.0, 0.0]]), r, b, np.full(2, 100.0), np.full(2, sigma))
    assert found.converged.all()
    # Chi-square with two degrees of freedom whatever the nonlinearity, here 7.3.
    assert found.statistic.mean() == pytest.approx(2.0, abs=4 * 2 / np.sqrt(n))
    share = (found.statistic > gate_threshold(0.01, 2)).mean()
    assert share == pytest.approx(0.0106, abs=4 * np.sqrt(0.0106 / n))


def test_a_difference_known_along_one_line_only_is_refused() -> None:
    flat = np.array([[1e10, 0.0], [0.0, 1e-6]])
    with pytest.raises(SingularGeometryError):
        squared_distances(np.ones(2), flat)
    statistic, log_determinant = squared_distances(np.array([3.0, 4.0]), np.diag([9.0, 4.0]))
    assert statistic == pytest.approx(1 + 4)
    assert log_determinant == pytest.approx(np.log(36.0))


def test_a_sum_over_too_many_is_refused() -> None:
    with pytest.raises(ParameterError, match="19 measurements is too large; at most 18"):
        exact_probabilities(np.zeros((20, 19)))


def test_no_clutter_and_full_detection_keep_scores_finite() -> None:
    scores = pair_scores(
        np.array([[15.0]]), detection_probability=(1.0, 1.0), target_density=1e-8, clutter_density=(0.0, 0.0)
    )
    assert np.isfinite(scores).all()
    assert scores[0, 0] > 50
