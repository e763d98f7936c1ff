"""Plots, tracks and gates in range and azimuth: a gate across north, few tracks and many, nothing at all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.registry import scenarios_by_name
from algorithms.spec import LocalContext
from backend.charts.plot_tracking.track_scope import CHART
from backend.charts.view import ChartOptions
from tests import chart_views


def drawn(name: str, tracker: Any, parameters: Any, **scenario: Any) -> dict[str, Any]:
    declared = scenarios_by_name()[name]
    recording = declared.simulate(declared.parameters(**scenario), (0,), 3)
    tables = tracker.ALGORITHM.tabulate(recording, tracker.run(recording, parameters, LocalContext()))
    return CHART.draw(chart_views.run(recording, tables), ChartOptions())


def outlines(figure: dict[str, Any]) -> list[np.ndarray]:
    """Azimuth and range of each gate, (2, 33); NaN where it is cut."""
    (gates,) = (t for t in figure["data"] if t["name"].endswith(", gates"))
    both = np.stack([gates["x"], gates["y"]])
    return list(both.reshape(2, -1, 34)[:, :, :-1].swapaxes(0, 1))


def test_a_passage_across_north_is_one_line_and_of_one_track_every_gate_is_drawn() -> None:
    figure = drawn("straight_aircraft", curvature_tracker, CurvatureParameters(), sigma_azimuth_deg=0.5)
    (line,) = (t for t in figure["data"] if t["meta"]["role"] == "series")
    x = np.asarray(line["x"], float)
    # From 323 to 37 degrees, all else is empty: north is in the middle, and nothing is cut.
    assert not np.isnan(x).any()
    assert (x[0], x[-1]) == (pytest.approx(-37, abs=3), pytest.approx(37, abs=3))
    assert -50 < figure["layout"]["xaxis"]["range"][0] < -37
    gates = outlines(figure)
    assert len(gates) > 50
    for gate in gates:
        assert np.nanmax(np.abs(np.diff(gate[0]))) < 180
        # Half a degree of error, 3.5 of them, times K_Q of at least 1.38.
        assert np.ptp(gate[1]) > 0.2 * 3.5 * 1.3


def test_where_plots_lie_all_around_a_line_across_north_is_cut() -> None:
    figure = drawn("straight_aircraft", curvature_tracker, CurvatureParameters(), false_plots=20.0)
    assert figure["layout"]["xaxis"]["range"] == [0, 360]
    (line,) = (t for t in figure["data"] if t["meta"]["role"] == "series")
    x = np.asarray(line["x"], float)
    assert np.isnan(x).any()
    assert np.nanmax(np.abs(np.diff(x))) < 180


def test_of_many_tracks_the_last_gates_and_vectors_are_drawn() -> None:
    figure = drawn("ten_aircraft", imm_tracker, ImmParameters())
    # Two models each.
    assert 10 <= len(outlines(figure)) <= 24
    (vectors,) = (t for t in figure["data"] if t["name"].endswith(", vectors"))
    ends = np.asarray(vectors["y"]).reshape(-1, 3)
    # In 30 s nobody flies farther than 8 km.
    assert 0.5 < np.abs(ends[:, 1] - ends[:, 0]).max() < 8


def test_an_empty_recording_says_so() -> None:
    recording = chart_views.two_radars().take(np.empty(0, np.int64))
    empty = CHART.draw(chart_views.run(recording, {}), ChartOptions())
    assert empty["layout"]["meta"]["not_applicable"] == "no_marks"
