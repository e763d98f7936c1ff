"""The 95 % interval of the crossing's distance by its likelihood, against an independent minimiser."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares

from algorithms.forward_scatter import fit
from algorithms.forward_scatter.likelihood import Problem
from algorithms.forward_scatter.motion import doppler_rows
from algorithms.forward_scatter.profile import NORMAL_95, interval

BASE_M = 40_000.0
FEET = np.array([[(BASE_M, 0.0, 0.0), (0.0, y, 0.0)] for y in (-150.0, 150.0)])
TRUE = np.array([15.0, 15_000.0, 200.0, 0.0, 0.0])
TIME = np.arange(31.0)
PRIOR_SD = 150.0


def problem(sigma: float) -> Problem:
    return Problem(TIME, FEET, 1.0, sigma, 0.0, BASE_M, 1 / PRIOR_SD**2, 1 / 1.5**2)


def dopplers(sigma: float, trials: int, true: NDArray[np.float64]) -> NDArray[np.float64]:
    clean, _ = doppler_rows(TIME, true, FEET, 1.0, 0.0)
    return clean[:, :, None] + np.random.default_rng(4).normal(0, sigma, (2, TIME.size, trials))


def fitted(sigma: float, trials: int, at: int = 30, true: NDArray[np.float64] = TRUE) -> tuple[Any, fit.Fits]:
    f = dopplers(sigma, trials, true)
    out = fit.fits(TIME.size, 2, trials)
    fit.fit_pass(f, problem(sigma), at, at + 1, 4, 0, np.zeros((trials, 6)), out)
    return f, out


def deviance(f: NDArray[np.float64], sigma: float, best: NDArray[np.float64], s: float) -> float:
    """Rise of chi2 from the best fit to the best one with this s, by SciPy; f (2, K)."""
    time = TIME[: f.shape[1]]

    def residuals(x: NDArray[np.float64], s: float) -> NDArray[np.float64]:
        theta = np.array([x[0], s, 10 * x[1], 10 * x[2], 0.0])
        value, _ = doppler_rows(time, theta, FEET, 1.0, 0.0)
        return np.append(((f - value) / sigma).ravel(), theta[3] / PRIOR_SD)

    level = float((residuals(np.array([best[0], best[2] / 10, best[3] / 10]), float(best[1])) ** 2).sum())
    # The same slope at the crossing; and also from no velocity along, because one start may end beside the valley.
    speed = best[2] / 10 * np.sqrt(s * (BASE_M - s) / (best[1] * (BASE_M - best[1])))
    starts = (np.array([best[0], speed, along]) for along in (best[3] / 10, 0.0))
    found = [least_squares(residuals, start, args=(s,), xtol=1e-12, ftol=1e-12).cost for start in starts]
    return 2 * float(min(found)) - level


def test_chi2_rises_by_the_quantile_at_both_ends() -> None:
    f, out = fitted(2.0, 5)
    for lane in range(5):
        best, ends = out.theta[30, :, lane], out.ends[30, :, lane]
        assert ends[0] < best[1] < ends[1]
        for end in ends:
            assert deviance(f[:, :, lane], 2.0, best, end) == pytest.approx(NORMAL_95**2, rel=0.02)


def test_the_far_end_is_found_near_the_transmitter_too() -> None:
    """Before the crossing, where 1.96 standard deviations reach beyond the base line: along the tangent the other
    unknowns would be lost, and the search used to stop at the estimate."""
    f, out = fitted(2.0, 40, at=9, true=np.array([15.0, 30_000.0, 200.0, 0.0, 0.0]))
    best, ends = out.theta[9], out.ends[9]
    beyond = best[1] + NORMAL_95 * np.sqrt(out.covariance[9, 1, 1]) > BASE_M
    assert beyond.sum() >= 5
    for lane in np.flatnonzero(beyond):
        rise = deviance(f[:, :10, lane], 2.0, best[:, lane], ends[1, lane])
        assert rise == pytest.approx(NORMAL_95**2, rel=0.03) or ends[1, lane] == BASE_M - 50.0


def test_of_a_certain_distance_interval_and_covariance_are_those_of_the_tangent_plane() -> None:
    _, out = fitted(0.02, 3)
    tangent, spread = out.covariance[30, :4, :4], out.spread[30, :4, :4]
    sd = np.sqrt(np.diagonal(tangent)).T
    np.testing.assert_allclose((out.ends[30] - out.theta[30, 1]) / sd[1], np.outer([-1, 1], [NORMAL_95] * 3), atol=0.03)
    np.testing.assert_allclose((spread - tangent) / (sd[:, None] * sd), 0, atol=0.03)


def test_the_covariance_is_the_mean_over_the_ridge() -> None:
    """Against the likelihood itself: weighted draws about the estimate, along and across its ridge."""
    sigma = 1.0
    f, out = fitted(sigma, 1)
    best, tangent, spread = out.theta[30, :4, 0], out.covariance[30, :4, :4, 0], out.spread[30, :4, :4, 0]
    scale = np.sqrt(np.diagonal(spread))
    draws = best + np.random.default_rng(8).multivariate_normal(np.zeros(4), 1.5 * spread, 6_000)
    chi2 = np.empty(len(draws))
    for i, theta in enumerate(draws):
        value, _ = doppler_rows(TIME, np.append(theta, 0.0), FEET, 1.0, 0.0)
        chi2[i] = (((f[:, :, 0] - value) / sigma) ** 2).sum() + (theta[3] / PRIOR_SD) ** 2
    apart = draws - best
    proposal = np.einsum("ni,ij,nj->n", apart, np.linalg.inv(1.5 * spread), apart)
    weight = np.exp(-0.5 * (chi2 - chi2.min() - proposal))
    found = (weight[:, None] * apart).T @ apart / weight.sum()
    assert np.abs((spread - found) / np.outer(scale, scale)).max() < 0.2
    # Of the direction that the tangent plane takes for certain.
    thin = np.linalg.eigh(tangent / np.outer(scale, scale))[1][:, 0] / scale
    assert thin @ found @ thin > 2 * thin @ tangent @ thin
    assert thin @ spread @ thin == pytest.approx(thin @ found @ thin, rel=0.5)


def test_an_interval_ends_at_the_ends_of_the_base_line() -> None:
    """Of Dopplers that tell next to nothing."""
    f, out = fitted(0.2, 1)
    best, covariance = out.theta[30, :, 0].copy(), np.ascontiguousarray(out.covariance[30, :, :, 0])
    ends, spread = np.empty(2), np.empty((5, 5))
    own = np.ascontiguousarray(f[:, :, 0])
    told = np.ones(own.shape)
    interval(own, told, TIME.size, problem(500.0), best, best, 2500.0**2 * covariance, 4, False, ends, spread)
    assert ends.tolist() == [50.0, BASE_M - 50.0]
