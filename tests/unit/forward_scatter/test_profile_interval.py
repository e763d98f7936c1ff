"""The 95 % interval of the crossing's distance by its likelihood, against an independent minimiser."""

from __future__ import annotations

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


def dopplers(sigma: float, trials: int) -> NDArray[np.float64]:
    clean, _ = doppler_rows(TIME, TRUE, FEET, 1.0, 0.0)
    return clean[:, :, None] + np.random.default_rng(4).normal(0, sigma, (2, TIME.size, trials))


def fitted(sigma: float, trials: int) -> tuple[NDArray[np.float64], fit.Fits]:
    f = dopplers(sigma, trials)
    out = fit.fits(TIME.size, 2, trials)
    fit.fit_pass(f, problem(sigma), 30, 31, 4, 0, np.zeros((trials, 6)), out)
    return f, out


def deviance(f: NDArray[np.float64], sigma: float, best: NDArray[np.float64], s: float) -> float:
    """Rise of chi2 from the best fit to the best one with this s, by SciPy."""

    def residuals(x: NDArray[np.float64], s: float) -> NDArray[np.float64]:
        theta = np.array([x[0], s, 10 * x[1], 10 * x[2], 0.0])
        value, _ = doppler_rows(TIME, theta, FEET, 1.0, 0.0)
        return np.append(((f - value) / sigma).ravel(), theta[3] / PRIOR_SD)

    start = np.array([best[0], best[2] / 10, best[3] / 10])
    held = least_squares(residuals, start, args=(s,), xtol=1e-12, ftol=1e-12)
    return 2 * float(held.cost) - float((residuals(start, float(best[1])) ** 2).sum())


def test_chi2_rises_by_the_quantile_at_both_ends() -> None:
    f, out = fitted(2.0, 5)
    for lane in range(5):
        best, ends = out.theta[30, :, lane], out.ends[30, :, lane]
        assert ends[0] < best[1] < ends[1]
        for end in ends:
            assert deviance(f[:, :, lane], 2.0, best, end) == pytest.approx(NORMAL_95**2, rel=0.02)


def test_a_certain_distance_needs_none_and_would_have_the_same() -> None:
    f, out = fitted(0.2, 1)
    assert np.isnan(out.ends[30]).all()
    ends = np.empty(2)
    best, covariance = out.theta[30, :, 0].copy(), np.ascontiguousarray(out.covariance[30, :, :, 0])
    own = np.ascontiguousarray(f[:, :, 0])
    interval(own, np.ones(own.shape), TIME.size, problem(0.2), best, covariance, 4, False, ends)
    sd = np.sqrt(covariance[1, 1])
    np.testing.assert_allclose(ends, best[1] + np.array([-1, 1]) * NORMAL_95 * sd, atol=0.06 * sd)


def test_an_interval_ends_at_the_ends_of_the_base_line() -> None:
    """Of Dopplers that tell next to nothing."""
    f, out = fitted(0.2, 1)
    best, covariance = out.theta[30, :, 0].copy(), np.ascontiguousarray(out.covariance[30, :, :, 0])
    ends = np.empty(2)
    own = np.ascontiguousarray(f[:, :, 0])
    interval(own, np.ones(own.shape), TIME.size, problem(500.0), best, 2500.0**2 * covariance, 4, False, ends)
    assert ends.tolist() == [50.0, BASE_M - 50.0]
