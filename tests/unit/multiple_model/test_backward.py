"""The backward pass against the whole joint Gaussian, built from a block-tridiagonal precision matrix."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multiple_model.backward import noise_matrices, smooth_backward, transition_matrices
from algorithms.toolbox.kernels.symmetric import pack, unpack

H = np.zeros((3, 9))
H[[0, 1, 2], [0, 3, 6]] = 1.0
R = np.diag([25.0, 400.0, 100.0]) + 5.0


def forward(time: np.ndarray, z: np.ndarray, density: np.ndarray, used: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Plain Kalman filter of one lane; rows that are not used are predictions and change nothing."""
    x, p, last = np.zeros(9), np.diag([1e6, 1e4, 100.0] * 3), None
    states, covariances = [], []
    for k in range(time.size):
        here_x, here_p = x, p
        if last is not None:
            tau = time[k : k + 1] - time[last]
            f = transition_matrices(tau)[0]
            here_x, here_p = f @ x, f @ p @ f.T + noise_matrices(tau, density[k : k + 1])[0]
        if used[k]:
            s = H @ here_p @ H.T + R
            w = here_p @ H.T @ np.linalg.inv(s)
            here_x, here_p = here_x + w @ (z[k] - H @ here_x), here_p - w @ s @ w.T
            x, p, last = here_x, here_p, k
        states.append(here_x)
        covariances.append(here_p)
    return np.array(states), np.array(covariances)


def joint(time: np.ndarray, z: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of all states given all measurements at once."""
    m = time.size
    a, b = np.zeros((9 * m, 9 * m)), np.zeros(9 * m)
    a[:9, :9] += np.linalg.inv(np.diag([1e6, 1e4, 100.0] * 3))
    for k in range(m):
        i = slice(9 * k, 9 * k + 9)
        a[i, i] += H.T @ np.linalg.inv(R) @ H
        b[i] += H.T @ np.linalg.inv(R) @ z[k]
        if k:
            j = slice(9 * k - 9, 9 * k)
            tau = time[k : k + 1] - time[k - 1]
            f, q = transition_matrices(tau)[0], np.linalg.inv(noise_matrices(tau, density[k : k + 1])[0])
            a[i, i] += q
            a[j, j] += f.T @ q @ f
            a[i, j] -= q @ f
            a[j, i] -= f.T @ q
    c = np.linalg.inv(a)
    return (c @ b).reshape(m, 9), np.array([c[9 * k : 9 * k + 9, 9 * k : 9 * k + 9] for k in range(m)])


@pytest.fixture
def case() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.5, 2.0, 25))
    density = np.where((time > 12) & (time < 20), 40.0, 0.5)
    return time, rng.normal(0, 300, (25, 3)), density


def smoothed(time: np.ndarray, z: np.ndarray, density: np.ndarray, used: np.ndarray, track: np.ndarray):
    """Two lanes: the second has the opposite measurements."""
    x, p = forward(time, z, density, used)
    y, _ = forward(time, -z, density, used)
    state = np.stack([x, y], axis=-1)
    covariance = np.repeat(pack(p.transpose(1, 2, 0)).T[:, :, None], 2, axis=2)
    lanes = [np.repeat(a[:, None], 2, axis=1) for a in (track, used, density)]
    xs, ps = smooth_backward(time, state, covariance, *lanes)
    return xs, unpack(ps, axis=1)


def test_every_row_is_that_of_the_joint_gaussian(case: tuple) -> None:
    time, z, density = case
    xs, ps = smoothed(time, z, density, np.ones(25, bool), np.ones(25, int))
    mean, covariance = joint(time, z, density)
    scale = np.sqrt(covariance[:, range(9), range(9)])
    np.testing.assert_allclose(xs[:, :, 0] / scale, mean / scale, atol=1e-6)
    np.testing.assert_allclose(xs[:, :, 1], -xs[:, :, 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        ps[..., 0] / scale[:, :, None] / scale[:, None, :],
        covariance / scale[:, :, None] / scale[:, None, :],
        atol=1e-6,
    )


def test_a_predicted_row_between_is_smoothed_and_disturbs_nothing(case: tuple) -> None:
    time, z, density = case
    used = np.ones(25, bool)
    used[[7, 8]] = False
    density[:] = 2.0
    xs, _ = smoothed(time, z, density, used, np.ones(25, int))
    keep = np.flatnonzero(used)
    fewer, _ = smoothed(time[keep], z[keep], density[keep], np.ones(keep.size, bool), np.ones(keep.size, int))
    np.testing.assert_allclose(xs[keep], fewer, rtol=0, atol=1e-8)
    # Between two smoothed neighbours, not on the straight prediction from the one before.
    x, _ = forward(time, z, density, used)
    assert np.abs(xs[7, :, 0] - x[7]).max() > 1


def test_nothing_goes_from_one_track_into_another(case: tuple) -> None:
    time, z, density = case
    track = np.where(np.arange(25) < 12, 1, 2)
    x, _ = forward(time, z, density, np.ones(25, bool))
    xs, _ = smoothed(time, z, density, np.ones(25, bool), track)
    np.testing.assert_array_equal(xs[11, :, 0], x[11])
    np.testing.assert_array_equal(xs[24, :, 0], x[24])
    assert np.abs(xs[5, :, 0] - x[5]).max() > 1
