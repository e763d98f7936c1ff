"""Lines of equal value: circles come out as circles, saddles are told, blanks cut lines."""

from __future__ import annotations

import numpy as np
import pytest

from backend.charts.contours import contour_lines, contour_traces, levels_between


def grid(count: int = 81) -> tuple[np.ndarray, np.ndarray]:
    axis = np.linspace(-10.0, 10.0, count)
    return axis, axis


def test_circles() -> None:
    x, y = grid()
    squares = x[None, :] ** 2 + y[:, None] ** 2 + 1e-12
    lines = contour_lines(x, y, squares, [4.0, 25.0])
    assert [line.level for line in lines] == [4.0, 25.0]
    for line, radius in zip(lines, (2.0, 5.0), strict=True):
        assert np.hypot(line.x, line.y) == pytest.approx(radius, abs=0.02)
        assert (line.x[0], line.y[0]) == (line.x[-1], line.y[-1]), "closed"
        step = np.hypot(np.diff(line.x), np.diff(line.y))
        assert step.sum() == pytest.approx(2 * np.pi * radius, rel=5e-3), "once around"


def test_a_saddle_has_four_lines_that_do_not_cross() -> None:
    x, y = grid(80)
    saddle = np.exp(x[None, :] * y[:, None])
    lines = contour_lines(x, y, saddle, [np.exp(1.0), np.exp(-1.0)])
    assert len(lines) == 4
    for line in lines:
        assert line.x * line.y == pytest.approx(np.log(line.level), abs=0.05)


def test_blanks_cut_lines_and_nothing_gives_none() -> None:
    x, y = grid()
    values = np.broadcast_to(np.exp(x), (81, 81)).copy()
    values[40] = np.nan
    lines = contour_lines(x, y, values, [np.exp(2.0)])
    assert len(lines) == 2
    for line in lines:
        assert line.x == pytest.approx(2.0)
        assert np.abs(line.y).min() >= x[41] - 1e-9
    assert contour_traces(contour_lines(x, y, values, [1e9]), "", "m", "#000") == []


def test_levels_are_round_and_few() -> None:
    assert levels_between(3.0, 60.0) == [5.0, 10.0, 20.0, 50.0]
    assert levels_between(0.5, 2e4) == [1.0, 10.0, 100.0, 1000.0, 10000.0]
    line, words = contour_traces(contour_lines(*grid(), grid()[0][None, :] ** 2 + grid()[1][:, None] ** 2, [4.0]),
                                 "drms", "m", "#000")  # fmt: skip
    assert words["text"] == ["4 m"]
    assert line["meta"]["role"] == "bound"
