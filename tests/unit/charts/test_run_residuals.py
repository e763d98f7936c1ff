"""Residuals by receiver: what is summed up, what is marked, what is left out."""

from __future__ import annotations

from typing import Any

import numpy as np

from backend.charts.run_residuals import CHART
from backend.charts.target import run_view_of
from backend.charts.view import ChartOptions, RunView
from tests import chart_views


def drawn(view: RunView) -> dict[str, Any]:
    return {trace["name"]: trace for trace in CHART.draw(view, ChartOptions())["data"]}


def test_medians_and_bars_stand_at_their_stations() -> None:
    traces = drawn(chart_views.complete_run(chart_views.marks()))
    assert list(traces["a"]["x"]) == ["west", "east", "north", "middle"]
    np.testing.assert_allclose(traces["a"]["y"], [1, 2, 3, 4])
    bars = traces["a, middle 90 %"]
    np.testing.assert_allclose(bars["y"][:3], [1, 1, np.nan])
    # Five of the six marks were heard in the north.
    assert str(traces["a"]["hovertext"][2]).startswith("5 residuals")


def test_percentiles_are_of_the_used_receptions() -> None:
    recording = chart_views.marks(101)
    arrays = chart_views.arrays(recording)
    arrays["residual_m"] = np.array(arrays["residual_m"])
    arrays["residual_m"][:, 0, 0] = np.arange(101)
    arrays["used"] = arrays["used"].copy()
    arrays["used"][:, 1] = False
    view = chart_views.complete_run(recording)
    (entry,) = view.entries
    object.__setattr__(entry, "arrays", lambda: arrays)
    traces = drawn(view)
    assert list(traces["a"]["x"]) == ["west", "north", "middle"]
    assert traces["a"]["y"][0] == 50
    np.testing.assert_allclose(traces["a, middle 90 %"]["y"][:2], [5, 95])


def test_the_receiver_that_disagrees_is_marked_and_explained() -> None:
    figure = CHART.draw(chart_views.complete_run(chart_views.marks()), ChartOptions())
    (ring,) = [t for t in figure["data"] if t["meta"]["role"] == "rejected"]
    assert ring["x"] == ["east"]
    assert ring["hovertext"] == ["late by 1000 ns (300 m)"]
    (label,) = figure["layout"]["annotations"]
    assert (label["x"], label["text"]) == (1, "disagrees")
    notes = {n["code"]: n["text"] for n in figure["layout"]["meta"]["notes"]}
    assert notes["suspect_receiver"] == "Station east disagrees with the others: late by 1000 ns (300 m)."
    assert notes["receivers_not_judged"] == "Cannot be judged: 1 station of 4; the table of receivers says why."


def test_one_target_has_its_own_residuals_and_the_same_verdict() -> None:
    recording = chart_views.marks(6, targets=2)
    view = run_view_of(chart_views.complete_run(recording), "t2")
    figure = CHART.draw(view, ChartOptions())
    points = next(t for t in figure["data"] if t["name"] == "a")
    # The second mark, which the north did not hear, is of t2.
    assert [text.split()[0] for text in points["hovertext"]] == ["3", "3", "2", "3"]
    assert any(t["meta"]["role"] == "rejected" for t in figure["data"])


def test_without_residuals_the_chart_says_so() -> None:
    recording = chart_views.marks()
    view = RunView(recording, (chart_views.entry("a", 0, {}),))
    assert CHART.draw(view, ChartOptions())["layout"]["meta"]["not_applicable"] == "no_residuals"
