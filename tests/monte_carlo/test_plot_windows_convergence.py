"""Undamped Gauss-Newton from the parametrisations of specification 4.2: how often it ends in the lowest minimum.

The table is of 100 runs: a share is reproduced within four standard errors of both sides, and 0.04 for what counts as
the lowest minimum. The circle's centre and radius depend on more that is not printed (what a step is that overshoots);
of them what is claimed in words is held: they fail where the others do not.
"""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.plot_tracking import descents
from algorithms.plot_tracking.base_points import fit_by_base_points
from algorithms.plot_tracking.curve_fit import Limits, fit_curve, quadratic_start, three_point_start
from algorithms.plot_tracking.window import Window
from algorithms.toolbox.motion import curvature

SIGMA_R, SIGMA_TH, STEP_S, RUNS, STEPS = 200.0, np.radians(8 / 60), 5.0, 100, 40
COURSE = np.pi / 2
MOTIONS = {
    "straight 200": (200.0, 0.0),
    "1.31 deg/s": (200.0, np.radians(1.31) / 200.0),
    "3 deg/s": (120.0, np.radians(3.0) / 120.0),
    "straight 50": (50.0, 0.0),
    "straight 20": (20.0, 0.0),
}
PLOTS = (4, 6, 8, 13)
# Shares of quadratic start, three-point start and base points for 4, 6, 8 and 13 plots.
TABLE = {
    "straight 200": ((1, 1, 1, 1), (1, 1, 1, 1), (1, 1, 1, 1)),
    "1.31 deg/s": ((0.97, 1, 1, 1), (1, 1, 1, 1), (1, 1, 1, 1)),
    "3 deg/s": ((0.79, 0.93, 0.85, 1), (0.96, 1, 1, 1), (0.98, 1, 1, 1)),
    "straight 50": ((0.49, 0.73, 0.92, 1), (0.65, 0.86, 0.96, 1), (0.70, 0.88, 0.96, 1)),
    "straight 20": ((0.26, 0.35, 0.42, 0.89), (0.42, 0.42, 0.52, 0.94), (0.50, 0.54, 0.63, 0.96)),
}


def drawn(motion: str, plots: int) -> Window:
    speed, bend = MOTIONS[motion]
    p = np.array([40e3, 42e3, COURSE, speed, 0.0, bend])
    rng = np.random.default_rng(11)
    t, shape = STEP_S * np.arange(1.0 - plots, 1.0), (plots, RUNS)
    x, y = curvature.position(p[:, None], t)
    return Window(
        np.hypot(x, y)[:, None] + SIGMA_R * rng.standard_normal(shape),
        np.arctan2(y, x)[:, None] + SIGMA_TH * rng.standard_normal(shape),
        np.broadcast_to(t[:, None], shape), np.ones(shape, bool), np.full(shape, SIGMA_R), np.full(shape, SIGMA_TH),
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("motion", TABLE)
def test_table_4_2(motion: str) -> None:
    found = np.empty((len(PLOTS), 5))
    for i, plots in enumerate(PLOTS):
        window = drawn(motion, plots)
        quadratic, three = quadratic_start(window), three_point_start(window)
        fits = (
            descents.by_course_and_speed(window, quadratic),
            descents.by_course_and_speed(window, three),
            descents.by_base_points(window),
            descents.by_centre_and_radius(window, quadratic),
            fit_curve(window, Limits()),
        )
        costs = [fit.cost for fit in fits]
        # One window after another, in other code: the same minimum, but for a few that wander first.
        alone, _ = fit_by_base_points(window)
        both = alone.converged & fits[2].converged
        assert np.isclose(alone.cost[both], fits[2].cost[both], rtol=1e-6, atol=1e-6).mean() > 0.95
        best = np.min(costs, axis=0)
        found[i] = np.mean(np.array(costs) < best + 1e-4 * (1 + best), axis=1)
    print(motion, found.T.round(2).tolist())
    printed = np.array(TABLE[motion], float).T
    likely = np.clip((found[:, :3] + printed) / 2, 0.01, 0.99)
    assert (np.abs(found[:, :3] - printed) < 4 * np.sqrt(2 * likely * (1 - likely) / RUNS) + 0.04).all()
    quadratic_share, centre, damped = found[:, 0], found[:, 3], found[:, 4]
    if motion in ("straight 200", "1.31 deg/s", "3 deg/s"):
        # In straight flight the radius is so large that it hangs on the last digits whether a step can be solved.
        assert centre[0] < 0.8
        if motion != "straight 200":
            assert (centre < 0.97).all()
            assert (centre < quadratic_share - 0.03).all()
        # Damping and two starts: no window in a hundred is left in a higher minimum.
        assert (damped >= 0.98).all()
    else:
        assert (damped >= 0.7).all()
        assert damped[-1] == 1
        assert (damped >= found[:, 2]).all()
