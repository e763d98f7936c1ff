"""Undamped Gauss-Newton from the parametrisations of specification 4.2: how often it ends in the lowest minimum.

The table is of 100 runs: a share is reproduced within four standard errors of both sides, and 0.04 for what counts as
the lowest minimum. The circle's centre and radius depend on more that is not printed (what a step is that overshoots);
of them what is claimed in words is held: they fail where the others do not.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from algorithms.plot_tracking.base_points import fit_by_base_points
from algorithms.plot_tracking.curve_fit import Limits, fit_curve, quadratic_start, three_point_start
from algorithms.plot_tracking.window import Window, cost_of, whitened
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
Turned = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


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


def stepped(window: Window, start: np.ndarray, turned: Turned) -> np.ndarray:
    """Full steps of the normal equations in parameters q; `turned` gives the six parameters and dp/dq."""
    q = np.where(np.isfinite(start).all(axis=0), start, 1.0)
    for _ in range(STEPS):
        p, g = turned(q)
        r, j = whitened(window, p)
        j = np.einsum("kiw,iqw->kqw", j, g)
        normal, right = np.einsum("kiw,kjw->wij", j, j), np.einsum("kiw,kw->wi", j, r)
        d = np.sqrt(np.maximum(np.einsum("wii->wi", normal), 1e-300))
        normal = normal / d[:, :, None] / d[:, None]
        lost = ~np.isfinite(normal).all(axis=(1, 2)) | ~np.isfinite(right).all(axis=1)
        normal[lost], right[lost] = np.eye(6), 0.0
        normal[np.abs(np.linalg.det(normal)) < 1e-14] = np.eye(6)
        q = q + (np.linalg.solve(normal, (right / d)[..., None])[..., 0] / d).T
    return turned(q)[0]


def itself(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return q, np.broadcast_to(np.eye(6)[:, :, None], (6, 6, q.shape[1]))


def from_centre(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the circle's centre and radius, course, speed and acceleration."""
    x, y, radius, g, b, a = q
    s, c = np.sin(g), np.cos(g)
    d = np.zeros((6, 6, q.shape[1]))
    d[0, 0] = d[1, 1] = d[2, 3] = d[3, 4] = d[4, 5] = 1.0
    d[0, 2], d[0, 3], d[1, 2], d[1, 3], d[5, 2] = s, radius * c, -c, radius * s, -1 / radius**2
    return np.stack([x + radius * s, y - radius * c, g, b, a, 1 / radius]), d


def centre_of(p: np.ndarray) -> np.ndarray:
    radius = 1 / p[5]
    return np.stack([p[0] - radius * np.sin(p[2]), p[1] + radius * np.cos(p[2]), radius, *p[2:5]])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("motion", TABLE)
def test_table_4_2(motion: str) -> None:
    found = np.empty((len(PLOTS), 5))
    for i, plots in enumerate(PLOTS):
        window = drawn(motion, plots)
        quadratic, three = quadratic_start(window), three_point_start(window)
        costs = [
            np.nan_to_num(cost_of(window, p), nan=np.inf)
            for p in (
                stepped(window, quadratic, itself),
                stepped(window, three, itself),
                fit_by_base_points(window)[0].p,
                stepped(window, centre_of(quadratic), from_centre),
            )
        ] + [fit_curve(window, Limits()).cost]
        best = np.min(costs, axis=0)
        found[i] = np.mean(np.array(costs) < best + 1e-4 * (1 + best), axis=1)
    print(motion, found.T.round(2).tolist())
    printed = np.array(TABLE[motion], float).T
    likely = np.clip((found[:, :3] + printed) / 2, 0.01, 0.99)
    assert (np.abs(found[:, :3] - printed) < 4 * np.sqrt(2 * likely * (1 - likely) / RUNS) + 0.04).all()
    quadratic_share, centre, damped = found[:, 0], found[:, 3], found[:, 4]
    if motion in ("straight 200", "1.31 deg/s", "3 deg/s"):
        assert (centre < 0.97).all()
        assert (centre < quadratic_share - 0.03).all()
        # Damping and two starts: no window in a hundred is left in a higher minimum.
        assert (damped >= 0.98).all()
    else:
        assert (damped >= 0.7).all()
        assert damped[-1] == 1
        assert (damped >= found[:, 2]).all()
