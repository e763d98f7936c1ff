import numpy as np

from backend.charts.decimate import GAP, curve, line_starts, thin


def test_a_curve_within_the_budget_keeps_every_point() -> None:
    time = np.arange(5.0)
    points = curve(time, (time**2,), np.array([True, False, False, False, False]), 5)
    assert points.positions.tolist() == [0, 1, 2, 3, 4]
    assert (points.shown, points.of) == (5, 5)


def test_a_new_line_and_a_missing_value_break_the_line() -> None:
    time = np.arange(6.0)
    value = np.array([1.0, 2.0, np.nan, 4.0, 5.0, 6.0])
    starts = np.array([True, False, False, False, True, False])
    points = curve(time, (value,), starts, None)
    assert points.positions.tolist() == [0, 1, GAP, 3, GAP, 4, 5]
    assert (points.shown, points.of) == (5, 5)


def test_gaps_are_nan_in_floats_minus_one_in_rows_and_empty_in_words() -> None:
    points = curve(np.arange(2.0), (np.ones(2),), np.array([True, True]), None)
    np.testing.assert_array_equal(points.take(np.array([7.0, 8.0])), [7.0, np.nan, 8.0])
    assert points.take(np.array([7, 8])).tolist() == [7, -1, 8]
    assert points.take(np.array(["a", "b"], object)).tolist() == ["a", "", "b"]


def test_a_spike_and_both_ends_survive_the_budget() -> None:
    time = np.arange(10000.0)
    value = np.zeros(10000)
    value[5678] = 1.0
    points = curve(time, (value,), np.append(True, np.zeros(9999, bool)), 50)
    assert points.shown == 50
    assert points.of == 10000
    assert {0, 5678, 9999} <= set(points.positions.tolist())


def test_every_piece_keeps_its_ends_however_small_the_budget() -> None:
    time = np.tile(np.arange(100.0), 30)
    starts = np.tile(np.append(True, np.zeros(99, bool)), 30)
    points = curve(time, (np.sin(time),), starts, 10)
    kept = set(points.positions.tolist())
    assert all({100 * k, 100 * k + 99} <= kept for k in range(30))
    assert (points.positions == GAP).sum() == 29


def test_a_path_keeps_the_extremes_of_both_coordinates() -> None:
    time = np.arange(1000.0)
    east, north = np.zeros(1000), np.zeros(1000)
    east[300], north[700] = 5.0, 5.0
    points = curve(time, (east, north), np.append(True, np.zeros(999, bool)), 40)
    assert {300, 700} <= set(points.positions.tolist())
    assert points.shown <= 40


def test_a_curve_without_points() -> None:
    points = curve(np.empty(0), (np.empty(0),), np.empty(0, bool), 10)
    assert points.positions.size == points.shown == points.of == 0
    assert points.take(np.empty(0)).size == 0


def test_marks_are_thinned_evenly_whatever_their_values() -> None:
    assert thin(np.arange(10), 5).positions.tolist() == [0, 2, 4, 6, 8]
    assert thin(np.arange(10), 9).positions.tolist() == [0, 2, 4, 6, 8]
    assert thin(np.arange(10), 10).shown == 10
    assert thin(np.arange(10), None).shown == 10
    assert (thin(np.arange(1000), 300).shown, thin(np.arange(1000), 300).of) == (250, 1000)


def test_a_line_ends_with_its_key_and_at_a_long_hole() -> None:
    key = np.array([0, 0, 0, 0, 1, 1])
    time = np.array([0.0, 1.0, 2.0, 100.0, 0.0, 1.0])
    assert line_starts(key, time).tolist() == [True, False, False, True, True, False]


def test_slow_measurements_are_not_holes() -> None:
    time = np.array([0.0, 70.0, 140.0, 400.0])
    assert line_starts(np.zeros(4, int), time).tolist() == [True, False, False, False]
    assert line_starts(np.empty(0, int), np.empty(0)).size == 0
