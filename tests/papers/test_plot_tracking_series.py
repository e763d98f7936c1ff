"""Specification 3: how far the Taylor series of a curved trajectory is from its exact chord form, m."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.toolbox.motion.curvature import position, position_by_series

TIMES_S = (10.0, 20.0, 30.0, 60.0)
ORDERS = (2, 3, 4, 5, 8)
# Speed m/s, turn rate rad/s (a bank of 25 degrees, and 3 deg/s), acceleration m/s2; errors of each order at each time.
TABLE = {
    (200.0, 0.02286, 0.0): (
        (17, 139, 466, 3632), (1.0, 16, 80, 1258), (0.05, 1.5, 11, 347), (0.00, 0.11, 1.3, 80), (0, 0, 0, 0.4),
    ),
    (120.0, 0.0523599, 0.0): (
        (55, 430, 1414, 9853), (7, 113, 563, 8173), (0.8, 24, 178, 5310), (0.07, 4.2, 47, 2842), (0, 0.01, 0.4, 181),
    ),
    (200.0, 0.02286, 2.0): (
        (30, 249, 870, 7433), (2.8, 46, 241, 4174), (0.2, 7.5, 59, 2028), (0.02, 1.1, 13, 900), (0, 0, 0.1, 47),
    ),
}  # fmt: skip


def digit_of(value: float) -> float:
    """Half of the last digit that the table prints."""
    text = f"{value:g}"
    return 0.5 * 10.0 ** -len(text.partition(".")[2]) if "." in text else 0.5


@pytest.mark.parametrize("motion", TABLE, ids=str)
@pytest.mark.parametrize("order", ORDERS)
def test_the_truncation_of_the_series(motion: tuple[float, float, float], order: int) -> None:
    speed, rate, acceleration = motion
    p = np.array([0.0, 0.0, 0.3, speed, acceleration, rate / speed])
    for time, printed in zip(TIMES_S, TABLE[motion][ORDERS.index(order)], strict=True):
        exact, series = position(p, np.array(time)), position_by_series(p, np.array(time), order)
        error = float(np.hypot(exact[0] - series[0], exact[1] - series[1]))
        assert error == pytest.approx(printed, abs=1.05 * digit_of(printed))
