"""Radial errors: lines of few tracks, medians of many, what notes say."""

from __future__ import annotations

import numpy as np

from algorithms.recording import ToaMarks
from algorithms.result import Table
from backend.charts.run_radial_error import CHART
from backend.charts.view import ChartOptions, RunView
from tests import chart_views


def view_of(recording: ToaMarks, error_m: np.ndarray) -> RunView:
    errors = chart_views.errors(recording)
    table = Table({**errors.columns, "error_horizontal_m": error_m})
    return chart_views.run(recording, {"states": chart_views.states(recording), "errors": table})


def test_few_tracks_have_a_line_each() -> None:
    recording = chart_views.marks(6, targets=2)
    error = np.array([10.0, 20, 30, 40, 50, 60])
    figure = CHART.draw(view_of(recording, error), ChartOptions())
    (line,) = figure["data"]
    # Track by track, with a gap between.
    np.testing.assert_allclose(line["y"], [10, 30, 50, np.nan, 20, 40, 60])
    assert figure["layout"]["yaxis"]["type"] == "log"
    (note,) = figure["layout"]["meta"]["notes"]
    assert note["text"] == "Median 35 m, 95 % below 57.5 m, of 6 marks."


def test_many_tracks_are_summed_up_in_bins() -> None:
    recording = chart_views.marks(900, targets=9)
    error = np.where(np.arange(900) < 450, 10.0, 1000.0)
    figure = CHART.draw(view_of(recording, error), ChartOptions())
    line = next(t for t in figure["data"] if t["meta"]["role"] == "series")
    assert set(np.unique(line["y"])) == {10.0, 1000.0}
    assert line["text"].sum() == 900
    band = next(t for t in figure["data"] if t["meta"]["role"] == "interval")
    assert np.nanmin(band["y"]) == 10
    assert any(n["code"] == "medians_in_bins" for n in figure["layout"]["meta"]["notes"])


def test_an_error_of_zero_is_counted_and_not_drawn() -> None:
    recording = chart_views.marks(3)
    figure = CHART.draw(view_of(recording, np.array([0.0, 5, 7])), ChartOptions())
    assert np.nanmin(figure["data"][0]["y"]) == 5
    assert figure["layout"]["meta"]["notes"][0]["text"] == "No place on a logarithmic axis: 1 error of exactly 0 m."


def test_without_truth_the_chart_says_so() -> None:
    recording = chart_views.marks(truth=False)
    view = chart_views.run(recording, {"states": chart_views.states(recording)})
    assert CHART.draw(view, ChartOptions())["layout"]["meta"]["not_applicable"] == "no_truth"
