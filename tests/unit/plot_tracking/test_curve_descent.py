"""The compiled descent against the plain statement of the same cost (`window.whitened`)."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.plot_tracking.curve_fit import FREE, HELD, LINE, Limits, fit, fit_curve
from algorithms.plot_tracking.line_fit import fit_line
from algorithms.plot_tracking.window import Window, cost_of, whitened
from algorithms.toolbox.motion.curvature import position


def windows(count: int = 40) -> Window:
    """Windows of 7 to 13 noisy plots, straight, turning to either side and accelerating, beside the radar's south."""
    rng = np.random.default_rng(7)
    longest = 13
    t = np.arange(1.0 - longest, 1.0)[:, None] * np.full((1, count), 5.0)
    p = np.stack([
        rng.uniform(-80e3, 80e3, count), rng.uniform(-3e3, 3e3, count), rng.uniform(-3, 3, count),
        rng.uniform(120, 250, count), rng.choice([0.0, 1.5], count), rng.choice([0.0, 2e-4, -2e-4], count),
    ])  # fmt: skip
    x, y = position(p[:, None], t)
    known = np.arange(longest)[:, None] >= longest - rng.integers(7, longest + 1, count)
    theta = np.arctan2(y, x) + 2e-3 * rng.standard_normal(t.shape)
    return Window(np.hypot(x, y) + 200 * rng.standard_normal(t.shape), theta, t, known, np.full(t.shape, 200.0),
                  np.full(t.shape, 2e-3))  # fmt: skip


@pytest.mark.parametrize("penalised", [False, True])
def test_at_the_minimum_the_slope_is_nothing_and_the_information_that_of_the_plain_equations(penalised: bool) -> None:
    window, limits = windows(), Limits()
    found = fit_curve(window, limits, penalised=penalised)
    assert found.converged.mean() > 0.9
    r, j = whitened(window, found.p)
    information = np.einsum("kiw,kjw->ijw", j, j)
    slope = np.einsum("kiw,kw->iw", j, r)
    if penalised:
        weight = np.stack([np.full(r.shape[1], 1 / limits.sd_acceleration_mps2),
                           np.maximum(fit_line(window).p[3], 30.0) ** 2 / limits.sd_normal_mps2])  # fmt: skip
        information[[4, 5], [4, 5]] += weight**2
        slope[4:] -= weight**2 * found.p[4:]
    scale = np.sqrt(np.einsum("iiw->iw", information))
    unit = scale[:, None] * scale[None]
    np.testing.assert_allclose(found.information / unit, information / unit, atol=1e-9)
    np.testing.assert_allclose(found.cost, cost_of(window, found.p), rtol=1e-9)
    # In standard deviations, where one iteration would move by the slope.
    assert np.abs(slope / scale)[:, found.converged].max() < 2e-2
    assert np.median(np.abs(slope / scale)) < 1e-5
    assert (found.p[3] >= 0).all()


def test_a_start_that_is_no_number_is_no_minimum() -> None:
    window = windows(2)
    window.rho[:, 0] = np.nan
    found = fit_curve(window, Limits())
    assert found.converged.tolist() == [False, True]
    assert np.isinf(found.cost[0])


def test_windows_of_few_and_of_many_plots_are_fitted_side_by_side_as_they_are_alone() -> None:
    window = windows(30)
    few = np.arange(13)[:, None] >= 13 - np.array([2, 3, 4] * 10)
    window = window._replace(known=window.known & (few | (np.arange(30) % 2 == 0)))
    together, how = fit(window, Limits())
    assert {LINE, FREE, HELD} <= set(how.tolist())
    for i in range(30):
        alone, kind = fit(window.take(np.array([i])), Limits())
        assert (kind[0], alone.converged[0]) == (how[i], together.converged[i])
        assert np.array_equal(alone.p[:, 0], together.p[:, i])
        assert np.array_equal(alone.information[..., 0], together.information[..., i])
