"""Altitude above the Earth against height in the frame."""

from __future__ import annotations

import numpy as np
import pytest

from backend.charts.run_height import CHART
from backend.charts.view import ChartOptions
from tests import chart_views


def test_h_exceeds_z_by_the_square_of_the_distance() -> None:
    recording = chart_views.marks(3, truth_m=np.array([[0.0, 0, 3000], [100e3, 0, 3000], [200e3, 0, 3000]]))
    figure = CHART.draw(chart_views.complete_run(recording), ChartOptions(full=True))
    traces = {t["name"]: np.asarray(t["y"]) for t in figure["data"]}
    difference = traces["true h"] - traces["true z"]
    # 0.78 km at 100 km and 3.1 km at 200 km.
    assert difference == pytest.approx([0, 784, 3137], abs=2)
    np.testing.assert_allclose(traces["a, z"], 3005)
    (note,) = figure["layout"]["meta"]["notes"]
    assert note["code"] == "height_difference"


def test_where_both_are_the_same_the_chart_says_so() -> None:
    recording = chart_views.marks(3, truth_m=np.array([[0.0, 0, 3000], [1e3, 0, 3000], [2e3, 0, 3000]]))
    view = chart_views.run(recording, {"states": chart_views.states(recording)})
    assert CHART.draw(view, ChartOptions())["layout"]["meta"]["not_applicable"] == "no_curvature"


def test_without_heights_the_chart_says_so() -> None:
    view = chart_views.run(chart_views.marks(3, truth=False), {})
    assert CHART.draw(view, ChartOptions())["layout"]["meta"]["not_applicable"] == "no_height"
