"""Fixed-interval smoothing against one least-squares problem over the whole interval, and where a track is broken."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.toolbox.filters.smoothing import smooth

Floats = np.ndarray[Any, np.dtype[np.float64]]
R = 25.0


def model(t: Floats, *_: object) -> tuple[Floats, Floats]:
    """A constant velocity disturbed by white acceleration."""
    f, q = np.zeros((t.size, 2, 2)), np.zeros((t.size, 2, 2))
    f[:, 0, 0] = f[:, 1, 1] = 1.0
    f[:, 0, 1] = t
    q[:, 0, 0], q[:, 0, 1], q[:, 1, 0], q[:, 1, 1] = t**3 / 3, t**2 / 2, t**2 / 2, t
    return f, q


def filtered(times: Floats, measured: Floats, p0: Floats) -> tuple[Floats, Floats, Floats]:
    """A plain Kalman filter: the prior before the first mark, and the estimates after each."""
    x, p = np.zeros(2), p0.copy()
    states, covariances = [], []
    for k, z in enumerate(measured):
        if k:
            f, q = (a[0] for a in model(np.array([times[k] - times[k - 1]])))
            x, p = f @ x, f @ p @ f.T + q
        gain = p[:, 0] / (p[0, 0] + R)
        x, p = x + gain * (z - x[0]), p - np.outer(gain, p[0])
        states.append(x)
        covariances.append(p)
    return np.array(states), np.array(covariances), x


def least_squares(times: Floats, measured: Floats, p0: Floats) -> tuple[Floats, Floats]:
    """All states at once: prior, marks and process noise as rows of one linear problem."""
    n = len(times)
    information, right = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
    information[:2, :2] += np.linalg.inv(p0)
    for k in range(n):
        information[2 * k, 2 * k] += 1 / R
        right[2 * k] += measured[k] / R
        if k:
            f, q = (a[0] for a in model(np.array([times[k] - times[k - 1]])))
            rows = np.hstack([-f, np.eye(2)])
            at = slice(2 * k - 2, 2 * k + 2)
            information[at, at] += rows.T @ np.linalg.inv(q) @ rows
    covariance = np.linalg.inv(information)
    return (covariance @ right).reshape(n, 2), np.stack(
        [covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] for k in range(n)]
    )


def case(seed: int, n: int = 30) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.3, 3.0, n))
    return times, 10 * times + rng.normal(0, 5, n), np.diag([1e4, 400.0])


def test_it_is_least_squares_over_the_whole_interval() -> None:
    """Two trials side by side, each with its own instants."""
    cases = [case(1), case(2)]
    runs = [filtered(*one) for one in cases]
    time = np.stack([c[0] for c in cases], axis=1)
    state, covariance = (np.stack([r[i] for r in runs], axis=1) for i in (0, 1))
    linked = np.ones(time.shape, bool)
    linked[0] = False
    x, p = smooth(time, state, covariance, linked, model)
    for lane, one in enumerate(cases):
        expected, spread = least_squares(*one)
        np.testing.assert_allclose(x[:, lane], expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(p[:, lane], spread, rtol=1e-9, atol=1e-9)


def test_pieces_are_smoothed_apart_and_gaps_stay() -> None:
    """A new track from the twentieth mark on; a mark without an estimate in the first one."""
    times, measured, p0 = case(3)
    first, second = filtered(times[:20], measured[:20], p0), filtered(times[20:], measured[20:] + 500, p0)
    state, covariance = (np.concatenate([first[i], second[i]])[:, None] for i in (0, 1))
    linked = np.ones((30, 1), bool)
    linked[[0, 20]] = False
    x, p = smooth(times[:, None], state, covariance, linked, model)
    alone, alone_p = smooth(times[:20, None], state[:20], covariance[:20], linked[:20], model)
    np.testing.assert_array_equal(x[:20], alone)
    np.testing.assert_array_equal(p[:20], alone_p)
    np.testing.assert_array_equal(x[29], state[29])
    # The same break is found where nobody tells: no update moves an estimate by half a kilometre.
    linked[20] = True
    np.testing.assert_array_equal(smooth(times[:, None], state, covariance, linked, model)[0], x)
    missing = times.copy()
    missing[10] = np.nan
    state[10] = covariance[10] = np.nan
    x, _ = smooth(missing[:, None], state, covariance, linked, model)
    assert np.isnan(x[10]).all()
    assert np.isfinite(np.delete(x, 10, axis=0)).all()
