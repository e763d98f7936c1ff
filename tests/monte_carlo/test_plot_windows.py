"""One window of plots: convergence (specification 4.2), accuracy against the bound (4.3), containment of gates (5).

A tabulated share or error is reproduced within five of its own standard errors and ours.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from algorithms.plot_tracking import gates
from algorithms.plot_tracking.curve_fit import Limits, fit, fit_curve
from algorithms.plot_tracking.line_fit import fit_line
from algorithms.plot_tracking.window import Window, covariance_of, whitened
from algorithms.toolbox.motion import curvature

SIGMA_R, SIGMA_TH = 200.0, np.radians(8 / 60)
STEP_S = 5.0
RUNS = 1000
MOTIONS = {
    "straight": np.array([40e3, 42e3, np.pi / 2, 200.0, 0.0, 0.0]),
    "wide turn": np.array([40e3, 42e3, np.pi / 2, 200.0, 0.0, np.radians(1.31) / 200.0]),
    "tight turn": np.array([40e3, 42e3, np.pi / 2, 120.0, 0.0, np.radians(3.0) / 120.0]),
}


def drawn(motion: str, plots: int, runs: int = RUNS, seed: int = 11) -> Window:
    """Noisy plots of a motion at 58 km, as many windows side by side as there are runs."""
    rng = np.random.default_rng(seed)
    t = STEP_S * np.arange(1.0 - plots, 1.0)
    x, y = curvature.position(MOTIONS[motion][:, None], t)
    shape = (plots, runs)
    return Window(
        np.hypot(x, y)[:, None] + SIGMA_R * rng.standard_normal(shape),
        np.arctan2(y, x)[:, None] + SIGMA_TH * rng.standard_normal(shape),
        np.broadcast_to(t[:, None], shape),
        np.ones(shape, bool),
        np.full(shape, SIGMA_R),
        np.full(shape, SIGMA_TH),
    )


def errors(p: np.ndarray, motion: str) -> np.ndarray:
    """Root mean square errors: position m, speed m/s, course deg, position 5 s ahead m."""
    truth = MOTIONS[motion][:, None]
    ahead = [
        np.subtract(*pair) for pair in zip(*(curvature.position(q, np.array(STEP_S)) for q in (p, truth)), strict=True)
    ]
    rows = [
        np.hypot(p[0] - truth[0], p[1] - truth[1]),
        p[3] - truth[3],
        np.degrees(curvature.wrapped(p[2] - truth[2])),
        np.hypot(*ahead),
    ]
    return np.sqrt(np.mean(np.square(rows), axis=1))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "plots", "kind", "table"),
    [
        ("straight", 4, "free", (225, 53, 14.7, 649)),
        ("straight", 4, "line", (198, 15, 4.1, 289)),
        ("straight", 13, "free", (170, 9.8, 2.6, 233)),
        ("straight", 13, "held", (167, 9.4, 2.6, 228)),
        ("straight", 13, "line", (124, 2.5, 0.7, 139)),
        ("wide turn", 6, "free", (215, 31, 7.3, 422)),
        ("wide turn", 6, "held", (193, 12, 7.0, 323)),
        ("wide turn", 13, "free", (166, 10.2, 2.1, 221)),
        ("wide turn", 13, "line", (1342, 11, 40.6, 2061)),
        ("tight turn", 8, "free", (190, 20, 7.7, 304)),
        ("tight turn", 13, "free", (160, 10.7, 4.3, 210)),
        ("tight turn", 13, "line", (1417, 30, 90, 2162)),
    ],
)
def test_table_4_3(motion: str, plots: int, kind: str, table: tuple[float, ...]) -> None:
    window = drawn(motion, plots)
    found = fit_line(window) if kind == "line" else fit_curve(window, Limits(), penalised=kind == "held")
    ours = errors(found.p, motion)
    print(motion, plots, kind, np.round(ours, 1), table)
    # Both sides come from 1,000 runs: 2.5 % each; the table is rounded to its last digit. The place of the window
    # is not printed in the specification, and a line's bias in a turn depends on it.
    assert_allclose(ours, table, rtol=0.16, atol=0.06)


@pytest.mark.slow
@pytest.mark.parametrize(("motion", "plots"), [("straight", 13), ("wide turn", 8), ("tight turn", 13)])
def test_the_free_fit_attains_the_bound_and_claims_it(motion: str, plots: int) -> None:
    window = drawn(motion, plots)
    found = fit_curve(window, Limits())
    assert found.converged.mean() > 0.995
    exact = drawn(motion, plots, runs=1)
    truth = MOTIONS[motion][:, None]
    _, j = whitened(exact, truth)
    bound = np.sqrt(np.diagonal(np.linalg.inv(j[..., 0].T @ j[..., 0])))
    off = found.p - truth
    off[2] = curvature.wrapped(off[2])
    assert_allclose(np.sqrt(np.mean(off**2, axis=1)), bound, rtol=0.12)
    claimed = np.median(np.sqrt(np.einsum("iiw->iw", covariance_of(found.information))), axis=1)
    assert_allclose(claimed, bound, rtol=0.12)
    # Twice the specification's J is chi-square with 2 n - 6 degrees of freedom.
    dof = 2 * plots - 6
    assert abs(found.cost.mean() - dof) < 5 * np.sqrt(2 * dof / RUNS)


CONTAINED = {
    # (predictor, Q): shares inside the three ellipses with K_Q, and with its root
    ("line", 2): ((0.999, 1, 1), (0.654, 0.948, 0.999)),
    ("line", 5): ((0.892, 0.999, 1), (0.657, 0.947, 0.998)),
    ("line", 12): ((0.766, 0.986, 1), (0.645, 0.949, 0.998)),
    ("curve", 3): ((0.877, 0.998, 1), (0.493, 0.827, 0.969)),
    ("curve", 5): ((0.674, 0.957, 0.998), (0.410, 0.777, 0.953)),
    ("curve", 12): ((0.625, 0.947, 0.998), (0.526, 0.884, 0.988)),
}


@pytest.mark.slow
@pytest.mark.parametrize(("predictor", "q"), CONTAINED)
def test_containment_of_the_gates(predictor: str, q: int) -> None:
    """4,000 draws of straight flight, 0.65, 0.95 and 0.998 nominal: the root for lines, K_Q itself for curves."""
    runs = 4000
    plots = q if predictor == "line" else q + 1
    window = drawn("straight", plots, runs)
    found = fit_line(window) if predictor == "line" else fit(window, Limits())[0]
    x, y = curvature.position(found.p, np.array(STEP_S))
    true_x, true_y = curvature.position(MOTIONS["straight"], np.array(STEP_S))
    rng = np.random.default_rng(1)
    rho = np.hypot(true_x, true_y) + SIGMA_R * rng.standard_normal(runs)
    theta = np.arctan2(true_y, true_x) + SIGMA_TH * rng.standard_normal(runs)
    for m, shares in zip(
        (gates.variance_ratio(q), np.sqrt(gates.variance_ratio(q))), CONTAINED[predictor, q], strict=True
    ):
        d2 = gates.squared_distance(rho, theta, (np.hypot(x, y), np.arctan2(y, x)), SIGMA_R, SIGMA_TH, m)
        inside = [(gates.classes(d2) <= k).mean() for k in range(3)]
        print(predictor, q, np.round(inside, 3), shares)
        for share, tabled in zip(inside, shares, strict=True):
            p = np.clip(tabled, 1e-3, 1 - 1e-3)
            assert abs(share - tabled) < 5 * np.sqrt(2 * p * (1 - p) / runs) + 5e-4


def test_windows_do_not_depend_on_their_neighbours() -> None:
    window = drawn("tight turn", 6, runs=17)
    whole = fit_curve(window, Limits())
    for which in ([3], [0, 3, 16]):
        part = fit_curve(window.take(np.array(which)), Limits())
        assert part.p.tobytes() == np.ascontiguousarray(whole.p[:, which]).tobytes()
        assert part.cost.tobytes() == np.ascontiguousarray(whole.cost[which]).tobytes()
