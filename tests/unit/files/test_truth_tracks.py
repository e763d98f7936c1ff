from __future__ import annotations

import numpy as np
import pytest

from backend.files.truth_tracks import TruthTrack


def track(time, position, velocity=None):
    time = np.asarray(time, float)
    velocity = np.full((len(time), 3), np.nan) if velocity is None else velocity
    return TruthTrack.of(time, np.asarray(position, float), velocity, np.arange(len(time)))


def cubic(t):
    t = np.asarray(t, float)
    return np.stack([1 + 2 * t - 0.3 * t**2 + 0.01 * t**3, -5 * t + t**3 / 50, 100 + 0 * t], axis=1)


def cubic_slope(t):
    t = np.asarray(t, float)
    return np.stack([2 - 0.6 * t + 0.03 * t**2, -5 + 3 * t**2 / 50, 0 * t], axis=1)


@pytest.mark.parametrize("time", [np.arange(8.0), [0, 1, 1.7, 3, 4.4, 5, 6.1, 7]], ids=["even", "uneven"])
def test_a_cubic_path_is_followed_exactly_from_end_to_end(time):
    wanted = np.linspace(0, 7, 71)
    points = track(time, cubic(time)).at(wanted)
    np.testing.assert_allclose(points.position_m, cubic(wanted), atol=1e-9)
    np.testing.assert_allclose(points.velocity_mps, cubic_slope(wanted), atol=1e-9)


def test_given_positions_come_back_bit_for_bit():
    time = np.arange(6.0) + 1 / 3
    position = np.random.default_rng(1).normal(size=(6, 3)) * 1e5
    points = track(time, position).at(time + 4e-7)
    assert points.exact.all()
    np.testing.assert_array_equal(points.position_m, position)
    np.testing.assert_array_equal(points.between, np.stack([np.arange(6)] * 2, axis=1))


def test_the_error_falls_with_the_fourth_power_of_the_step():
    def worst(step):
        time = np.arange(0, 20 + step / 2, step)
        circle = np.stack([np.cos(time), np.sin(time), 0 * time], axis=1)
        wanted = np.linspace(3, 17, 500)
        at = track(time, circle).at(wanted).position_m
        return np.abs(at - np.stack([np.cos(wanted), np.sin(wanted), 0 * wanted], axis=1)).max()

    assert worst(0.4) / worst(0.2) == pytest.approx(16, rel=0.2)


def test_nothing_beyond_the_ends():
    points = track([0, 1, 2, 3], cubic([0, 1, 2, 3])).at(np.array([-1e-3, 3.001]))
    assert np.isnan(points.position_m).all()
    assert (points.between == -1).all()


@pytest.mark.parametrize(("gap", "known"), [(2.0, True), (2.01, False)])
def test_a_gap_of_two_periods_is_the_longest_that_is_bridged(gap, known):
    time = np.array([0, 1, 2, 3, 3 + gap, 4 + gap, 5 + gap, 6 + gap])
    points = track(time, cubic(time)).at(np.array([3.5, 2.5, 3.0, 3 + gap, 3.5 + gap]))
    assert np.isfinite(points.position_m).all(axis=1).tolist() == [known, True, True, True, True]
    # Neither does the path on one side of a gap lean on positions beyond it.
    np.testing.assert_allclose(points.position_m[1:], cubic([2.5, 3.0, 3 + gap, 3.5 + gap]), atol=1e-9)
    np.testing.assert_allclose(points.velocity_mps[1:], cubic_slope([2.5, 3.0, 3 + gap, 3.5 + gap]), atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_positions_give_a_path_of_lower_degree(n):
    time = np.arange(float(n))
    parabola = np.stack([time**2 if n == 3 else time, 0 * time, 0 * time], axis=1)
    points = track(time, parabola).at(np.array([0.0, 0.5]))
    assert points.position_m[0].tolist() == [0, 0, 0]
    expected = {1: [np.nan, np.nan], 2: [0.5, 1.0], 3: [0.25, 1.0]}[n]
    np.testing.assert_allclose([points.position_m[1, 0], points.velocity_mps[1, 0]], expected)


def test_no_position_at_all():
    assert np.isnan(track([], np.empty((0, 3))).at(np.array([1.0])).position_m).all()


def test_given_velocities_are_used_and_interpolated():
    time = np.arange(5.0)
    velocity = np.stack([time, np.full(5, np.nan), 0 * time], axis=1)
    points = track(time, cubic(time), velocity).at(np.array([1.0, 1.5]))
    np.testing.assert_allclose(points.velocity_mps[:, 0], [1.0, 1.5])
    np.testing.assert_allclose(points.velocity_mps[:, 1], cubic_slope([1.0, 1.5])[:, 1])


def test_positions_close_together_do_not_make_a_wild_slope():
    """Two receivers a millisecond apart, a metre of noise each."""
    rng = np.random.default_rng(3)
    time = np.sort(np.concatenate([np.arange(20.0), np.arange(20.0) + 0.001, np.arange(20.0) + 0.5]))
    straight = np.stack([100 * time, 0 * time, 0 * time], axis=1) + rng.normal(size=(60, 3))
    points = track(time, straight).at(np.linspace(1, 18, 400))
    assert np.abs(points.velocity_mps[:, 0] - 100).max() < 20
    assert np.abs(points.position_m[:, 0] - 100 * np.linspace(1, 18, 400)).max() < 5


def test_order_repeated_times_and_incomplete_positions():
    time = [3, 0, 1, 2, 1, 1.5]
    position = cubic(time)
    position[4] = 7e6
    position[5, 0] = np.nan
    points = track(time, position).at(np.array([1.0, 1.5]))
    np.testing.assert_allclose(points.position_m, cubic([1.0, 1.5]), atol=1e-9)
    assert points.between[0].tolist() == [2, 2]
