"""Marks fitted together: derivatives against differences, the minimum against scipy, both by independent formulas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from algorithms.multilateration.scenario import four_stations
from algorithms.multilateration.straight_flight import STARTS, Pile, inverse, normal_equations, search, valley_is_short

R = 6_371_000.0
STATIONS = four_stations().station_positions()
SIGMA = np.array([3.0, 2.0, 4.0, 2.5])
TRUTH = np.array([38_000.0, -140.0, 0.1, 21_000.0, 150.0, -0.2, 8_000.0, 3.0])
BELIEF = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 7_900.0, 1.0])
BELIEF_SD = np.array([np.inf, 300.0, 0.5, np.inf, 300.0, 0.5, 100.0, 7.0])


def places(theta: np.ndarray, tau: np.ndarray) -> np.ndarray:
    x = theta[0] + theta[1] * tau + theta[2] * tau**2 / 2
    y = theta[3] + theta[4] * tau + theta[5] * tau**2 / 2
    return np.stack([x, y, np.sqrt((R + theta[6] + theta[7] * tau) ** 2 - x**2 - y**2) - R], axis=1)


def pile_of(heard: list[list[int]], step: float = 1.5, seed: int = 3, truth: np.ndarray = TRUTH) -> Pile:
    """Return noisy marks heard by these stations."""
    rng = np.random.default_rng(seed)
    tau = step * np.arange(1 - len(heard), 1.0)
    arrival: list[float] = []
    for p, stations in zip(places(truth, tau), heard, strict=True):
        c_toa = np.linalg.norm(p - STATIONS[stations], axis=1) + SIGMA[stations] * rng.standard_normal(len(stations))
        arrival += list(c_toa - c_toa[0])
    return Pile(
        tau=tau,
        first=np.cumsum([0, *map(len, heard)]),
        station=np.concatenate(heard),
        arrival=np.array(arrival),
        stations=STATIONS,
        weight=SIGMA**-2,
        belief=BELIEF,
        belief_weight=BELIEF_SD**-2,
        earth_m=R,
        radius_m=R,
        pin=np.zeros(4),
        spread=np.zeros((3, 3)),
        pull=np.zeros(3),
    )


def residuals(theta: np.ndarray, pile: Pile) -> np.ndarray:
    """Range differences against the last reception, whitened by the Cholesky factor of their full covariance."""
    out = []
    for m, p in enumerate(places(theta, pile.tau)):
        j = slice(pile.first[m], pile.first[m + 1])
        stations = pile.station[j]
        left = pile.arrival[j] - np.linalg.norm(p - STATIONS[stations], axis=1)
        contrast = np.c_[-np.eye(len(stations) - 1), np.ones(len(stations) - 1)]
        covariance = contrast @ np.diag(SIGMA[stations] ** 2) @ contrast.T
        out.append(np.linalg.solve(np.linalg.cholesky(covariance), contrast @ left))
    return np.concatenate([*out, (BELIEF - theta) / BELIEF_SD])


MIXED = [[0, 2, 3], [0, 3], [1, 2], [0, 1, 2, 3], [2, 3], [1, 3], [0, 2, 3], [0, 1]]
PAIRS = [[i % 3, 3] for i in range(12)]


@pytest.mark.parametrize("heard", [MIXED, PAIRS])
def test_information_and_gradient_are_the_derivatives_of_the_cost(heard: list[list[int]]) -> None:
    pile = pile_of(heard)
    theta = TRUTH + np.array([700.0, 20.0, 0.1, -900.0, 15.0, 0.1, 300.0, 2.0])
    info, grad = np.empty(36), np.empty(8)
    cost = normal_equations(theta, pile, info, grad)
    r = residuals(theta, pile)
    assert cost == pytest.approx(r @ r, rel=1e-9)
    step = np.array([1.0, 0.1, 0.01, 1.0, 0.1, 0.01, 1.0, 0.1])
    jacobian = np.stack(
        [(residuals(theta + d, pile) - residuals(theta - d, pile)) / (2 * d.sum()) for d in np.diag(step)], axis=1
    )
    full = np.zeros((8, 8))
    full[np.tril_indices(8)] = info
    full += np.tril(full, -1).T
    expected = jacobian.T @ jacobian
    size = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(full / np.outer(size, size), expected / np.outer(size, size), atol=2e-6)
    np.testing.assert_allclose(grad / size, -jacobian.T @ r / size, rtol=1e-5, atol=1e-5 * np.sqrt(cost))


@pytest.mark.parametrize("heard", [MIXED, PAIRS])
def test_the_lowest_minimum_is_that_of_scipy(heard: list[list[int]]) -> None:
    pile = pile_of(heard)
    thetas, costs = np.empty((STARTS, 8)), np.empty(STARTS)
    lowest = search(pile, thetas, costs)
    best = thetas[costs.argmin()]
    assert lowest == costs.min()
    scale = np.array([1e4, 100, 0.5, 1e4, 100, 0.5, 1e3, 5])
    theirs = least_squares(residuals, TRUTH, args=(pile,), x_scale=scale, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    info, grad, covariance = np.empty(36), np.empty(8), np.empty(36)
    normal_equations(best, pile, info, grad)
    assert inverse(info, covariance)
    sd = np.sqrt(covariance[[i * (i + 3) // 2 for i in range(8)]])
    assert lowest == pytest.approx(2 * theirs.cost, abs=1e-4)
    np.testing.assert_allclose((best - theirs.x) / sd, 0.0, atol=0.01)
    np.testing.assert_allclose(sd, np.sqrt(np.diag(np.linalg.inv(theirs.jac.T @ theirs.jac))), rtol=1e-3)
    assert valley_is_short(best, lowest, covariance, pile)


def test_one_hyperbola_has_a_long_valley() -> None:
    """The same pair all the time: any place along the hyperbola will do, whatever the claim."""
    pile = pile_of([[0, 3]] * 20)
    thetas, costs = np.empty((STARTS, 8)), np.empty(STARTS)
    search(pile, thetas, costs)
    close = thetas[costs < costs.min() + 1.0]
    assert np.ptp(close[:, [0, 3]], axis=0).max() > 20_000.0


def test_the_valley_is_walked_without_a_trace() -> None:
    """A claim a hundred times too small is found out, and the pile is afterwards as before."""
    pile = pile_of(PAIRS)
    thetas, costs = np.empty((STARTS, 8)), np.empty(STARTS)
    lowest = search(pile, thetas, costs)
    best = thetas[costs.argmin()].copy()
    info, grad, covariance = np.empty(36), np.empty(8), np.empty(36)
    normal_equations(best, pile, info, grad)
    inverse(info, covariance)
    assert not valley_is_short(best, lowest, covariance * 1e-4, pile)
    assert pile.pin[3] == 0.0
    assert normal_equations(best, pile, info, grad) == pytest.approx(lowest, rel=1e-12)
