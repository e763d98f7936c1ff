import numpy as np
import pytest

from backend.charts.bins import time_bins


@pytest.mark.parametrize(
    ("span", "width"), [(1900.0, 50.0), (600.0, 50.0), (12000.0, 50.0), (480.0, 10.0), (13.0, 0.5), (86400.0, 500.0)]
)
def test_bins_are_fifty_seconds_wide_where_that_is_readable(span: float, width: float) -> None:
    bins = time_bins(np.array([0.0, span]))
    assert bins.width_s == pytest.approx(width)
    assert bins.edges[0] <= 0
    assert bins.edges[-1] > span


def test_sums_by_bin_with_the_edge_in_the_later_one() -> None:
    time = np.array([0.0, 49.9, 50.0, 1000.0])
    n, total = time_bins(time).sums(time, np.array([1.0, 2.0, 3.0, 4.0]))
    assert n[[0, 1]].tolist() == [2, 1]
    assert total[[0, 1, -1]].tolist() == [3, 3, 4]
    assert n.sum() == 4


@pytest.mark.parametrize("time", [[], [5.0], [np.nan], [7.0, 7.0]])
def test_one_instant_or_none_is_one_bin(time: list[float]) -> None:
    bins = time_bins(np.array(time))
    assert bins.centres.size == 1
