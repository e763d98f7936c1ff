"""Errors of the stages against the first algorithm: ratios the right way round, whoever the table names first."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.result import Table
from backend.charts.multiple_model import trials_stages
from backend.charts.view import ChartOptions
from tests import chart_views


def compared(against: str, *ratios: tuple[str, str, float]) -> dict[str, Table]:
    value = np.array([ratio for _, _, ratio in ratios])
    columns: dict[str, Any] = {
        "metric": [metric for metric, _, _ in ratios], "segment": [stage for _, stage, _ in ratios],
        "against": [against] * len(ratios), "target": [None] * len(ratios),
        "ratio": value, "ratio_low": 0.9 * value, "ratio_high": 1.1 * value,
    }  # fmt: skip
    return {"comparisons": Table(columns)}


def drawn(*tables: dict[str, Table]) -> dict[str, Any]:
    return trials_stages.draw(chart_views.run(chart_views.antenna(), *tables), ChartOptions())


def test_a_ratio_says_how_many_times_the_first_one_s_error_it_is() -> None:
    up = ("rms_up_m", "arc", 2.0), ("rms_up_m", "turn", 0.5), ("rms_velocity_up_mps", "arc", 3.0)
    first_named = drawn(compared("b", *up), {})["data"]
    other_named = drawn({}, compared("a", *up))["data"]
    assert [t["name"] for t in first_named] == ["b, position", "b, velocity", "as large"]
    np.testing.assert_allclose(first_named[0]["y"], [0.5, 2.0])
    np.testing.assert_allclose(other_named[0]["y"], [2.0, 0.5])
    np.testing.assert_allclose(other_named[1]["y"], [3.0])
    for found in (first_named[0], other_named[0]):
        assert (found["error_y"]["array"] > 0).all()
        assert (found["error_y"]["arrayminus"] > 0).all()
    np.testing.assert_allclose(np.round(other_named[0]["x"]), [0, 1])


def test_one_algorithm_or_swept_values_have_none() -> None:
    assert drawn({})["layout"]["meta"]["not_applicable"] == "nothing_to_compare"
    assert drawn({}, {})["layout"]["meta"]["not_applicable"] == "no_reference"
