"""The bank of filters against plain statements of the same equations."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from algorithms.plot_tracking.imm_filter import Bank, Motion, begun, predicted, updated, updated_by_many
from algorithms.plot_tracking.joint_association import joint_probabilities

MOTION = Motion(5.0, 0.8, 3.0, np.radians(0.4), np.radians(3.0), (0.95, 0.9))
SINGLE = Motion(5.0, 0.8, 3.0, np.radians(0.4), np.radians(3.0), (0.95, 0.9), turning=False)


def some_bank(tracks: int, motion: Motion, seed: int = 1) -> Bank:
    rng = np.random.default_rng(seed)
    models = motion.models
    x = rng.standard_normal((tracks, models, 5)) * np.array([1000, 100, 1000, 100, 0.02])
    a = rng.standard_normal((tracks, models, 5, 5)) * np.array([100, 10, 100, 10, 0.01])[:, None]
    mu = rng.dirichlet(np.ones(models), tracks)
    x[:, 0, 4] = 0.0
    a[:, 0, 4] = 0.0
    return Bank(x, a @ a.swapaxes(-1, -2), mu)


def turned(x: np.ndarray, dt: float) -> np.ndarray:
    """A turn by complex numbers: v e^(i w t), and its integral."""
    z, v, w = x[0] + 1j * x[2], x[1] + 1j * x[3], x[4]
    z = z + v * (np.exp(1j * w * dt) - 1) / (1j * w)
    v = v * np.exp(1j * w * dt)
    return np.array([z.real, v.real, z.imag, v.imag, w])


def plain_prediction(x: np.ndarray, p: np.ndarray, mu: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Mixing and both models for one track, term by term; row = from."""
    chain = np.array([[0.95, 0.05], [0.1, 0.9]])
    after = mu @ chain
    xs, ps = np.zeros((2, 5)), np.zeros((2, 5, 5))
    for j in range(2):
        weight = mu * chain[:, j] / after[j]
        mean = weight @ x
        cov = np.zeros((5, 5))
        for i in range(2):
            own = p[i].copy()
            if (i, j) == (0, 1):
                own[4, 4] += MOTION.sd_turn_rate**2
            cov += weight[i] * (own + np.outer(x[i] - mean, x[i] - mean))
        g = np.zeros((5, 2))
        g[0, 0] = g[2, 1] = dt**2 / 2
        g[1, 0] = g[3, 1] = dt
        if j == 0:
            f = np.eye(5)
            f[0, 1] = f[2, 3] = dt
            f[4, 4] = 0
            xs[j], q = f @ mean, MOTION.sd_straight**2 * g @ g.T
        else:
            f = np.empty((5, 5))
            for k in range(5):
                h = np.zeros(5)
                h[k] = 1e-6 if k == 4 else 1e-2
                f[:, k] = (turned(mean + h, dt) - turned(mean - h, dt)) / (2 * h[k])
            xs[j], q = turned(mean, dt), MOTION.sd_turn**2 * g @ g.T
            q[4, 4] = MOTION.sd_turn_rate_step**2
        ps[j] = f @ cov @ f.T + q
    return xs, ps


def test_a_prediction_is_that_of_the_plain_equations() -> None:
    bank = some_bank(4, MOTION)
    found = predicted(bank, np.full(4, 5.0), MOTION)
    for t in range(4):
        x, p = plain_prediction(bank.x[t], bank.p[t], bank.mu[t], 5.0)
        np.testing.assert_allclose(found.x[t], x, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(found.p[t], p, rtol=1e-5, atol=1e-4)
        np.testing.assert_allclose(found.mu[t], bank.mu[t] @ np.array([[0.95, 0.05], [0.1, 0.9]]))


def test_a_gap_of_four_periods_has_the_noise_of_four_steps() -> None:
    bank = some_bank(3, SINGLE)
    whole = predicted(bank, np.full(3, 20.0), SINGLE)
    steps = bank
    for _ in range(4):
        steps = predicted(steps, np.full(3, 5.0), SINGLE)
    np.testing.assert_allclose(whole.p, steps.p, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(whole.x, steps.x, rtol=1e-12, atol=1e-9)


def test_an_update_is_bayes_rule_for_each_model() -> None:
    bank = some_bank(5, MOTION)
    rng = np.random.default_rng(2)
    z = bank.x[:, 0, [0, 2]] + rng.standard_normal((5, 2)) * 200
    r = np.tile(np.array([[200.0**2, 5e3], [5e3, 150.0**2]]), (5, 1, 1))
    found = updated(bank, z, r)
    h = np.zeros((2, 5))
    h[0, 0] = h[1, 2] = 1
    for t in range(5):
        likelihood = np.empty(2)
        for m in range(2):
            s = h @ bank.p[t, m] @ h.T + r[t]
            k = bank.p[t, m] @ h.T @ np.linalg.inv(s)
            nu = z[t] - h @ bank.x[t, m]
            np.testing.assert_allclose(found.x[t, m], bank.x[t, m] + k @ nu, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(found.p[t, m], bank.p[t, m] - k @ s @ k.T, rtol=1e-6, atol=1e-5)
            likelihood[m] = np.exp(-0.5 * nu @ np.linalg.inv(s) @ nu) / np.sqrt(np.linalg.det(s))
        mu = bank.mu[t] * likelihood
        np.testing.assert_allclose(found.mu[t], mu / mu.sum(), rtol=1e-9)


def test_nothing_in_the_gate_changes_nothing_and_two_equal_plots_are_one() -> None:
    bank = some_bank(3, MOTION)
    z = bank.x[:, 0, [0, 2]] + 100.0
    r = np.tile(np.eye(2) * 1e4, (3, 1, 1))
    none = updated_by_many(bank, z[:, None], r[:, None], np.zeros((3, 1)), np.ones(3))
    np.testing.assert_allclose(none.x, bank.x)
    np.testing.assert_allclose(none.mu, bank.mu)
    both = updated_by_many(bank, np.stack([z, z], 1), np.stack([r, r], 1), np.full((3, 2), 0.5), np.zeros(3))
    one = updated(bank, z, r)
    np.testing.assert_allclose(both.x, one.x, rtol=1e-10)
    np.testing.assert_allclose(both.mu, one.mu, rtol=1e-10)


def test_two_plots_and_a_weak_prior_give_the_line_through_them() -> None:
    r = np.tile(np.diag([100.0, 400.0]), (1, 1, 1))
    motion = Motion(5.0, 0.8, 1e-9, 1e-3, 1e-2, (0.95, 0.9))
    bank = begun(np.array([[0.0, 0.0]]), np.array([[500.0, -250.0]]), r, r, np.array([5.0]), 1e6, motion)
    np.testing.assert_allclose(bank.x[0, 0, :4], [500, 100, -250, -50], rtol=1e-6)
    # Least squares through two points: variance of the rate 2 r / dt^2, covariance with the second point r / dt.
    np.testing.assert_allclose(bank.p[0, 0, :2, :2], [[100, 20], [20, 8]], rtol=1e-6)
    np.testing.assert_allclose(bank.p[0, 0, 2:4, 2:4], [[400, 80], [80, 32]], rtol=1e-6)


def test_joint_probabilities_are_the_sum_over_all_events() -> None:
    rng = np.random.default_rng(4)
    score = rng.normal(0, 2, (3, 3))
    track, plot = np.nonzero(np.ones((3, 3)))
    found = joint_probabilities(track, plot, score.ravel(), -score.ravel(), 10).beta.reshape(3, 3)
    total, expected = 0.0, np.zeros((3, 3))
    # Each track takes a plot or none (index 3 and beyond).
    seen = set()
    for event in permutations(range(6), 3):
        made = tuple(j if j < 3 else None for j in event)
        if made in seen:
            continue
        seen.add(made)
        weight = float(np.exp(sum(score[i, j] for i, j in enumerate(made) if j is not None)))
        total += weight
        for i, j in enumerate(made):
            if j is not None:
                expected[i, j] += weight
    np.testing.assert_allclose(found, expected / total, rtol=1e-10)


def test_a_cluster_past_the_bound_is_assigned_and_counted() -> None:
    track, plot = np.nonzero(np.ones((4, 4)))
    score = np.where(track == plot, 1.0, 0.0)
    found = joint_probabilities(track, plot, score, -score, 3)
    assert found.too_large == 1
    assert np.array_equal(found.beta, (track == plot).astype(float))
    assert joint_probabilities(track, plot, score, -score, 4).too_large == 0


@pytest.mark.parametrize("score", [-3.0, 0.0, 5.0])
def test_one_track_and_one_plot(score: float) -> None:
    one = np.zeros(1, np.int64)
    found = joint_probabilities(one, one, np.array([score]), np.array([0.0]), 5)
    assert found.beta[0] == pytest.approx(np.exp(score) / (1 + np.exp(score)))


def test_clusters_side_by_side_have_the_probabilities_they_have_alone() -> None:
    """Clusters of one shape are summed together, and a run is repeatable whatever else is in the air."""
    rng = np.random.default_rng(6)
    parts = []
    for k in range(40):
        rows, columns = rng.integers(1, 6, 2).tolist()
        track, plot = np.nonzero((rng.random((rows, columns)) < 0.7) | (np.arange(columns) == 0))
        score = rng.normal(0, 300 if k % 8 == 7 else 3, track.size)
        # Their tracks and plots lie scattered among those of the others.
        parts.append((k + 40 * track, 39 - k + 40 * plot, score))
    track, plot, score = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    order = rng.permutation(track.size)
    found = np.empty(track.size)
    found[order] = joint_probabilities(track[order], plot[order], score[order], -score[order], 4).beta
    alone = [joint_probabilities(*part, -part[2], 4) for part in parts]
    assert np.array_equal(found, np.concatenate([one.beta for one in alone]))
    # Both ways out of the sum have been taken: a pair alone, and nearest neighbours of a cluster that is too large.
    assert any(one.too_large for one in alone)
    assert any(one.beta.size == 1 for one in alone)
