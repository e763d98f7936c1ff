"""The map over two swept values: its rows lie where their values lie."""

from __future__ import annotations

import numpy as np

from algorithms.result import Table
from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions, Entry, RunView
from tests import chart_views


def drawn(ys: list[float]) -> dict:
    xs = [0.0, 1000.0, 3000.0]
    cells = [(x, y) for y in ys for x in xs]
    table = Table(
        {
            "metric": ["probability_correct"] * len(cells),
            "segment": [None] * len(cells),
            "target": [None] * len(cells),
            "scenario.offset_along_m": np.array([c[0] for c in cells]),
            "scenario.offset_across_m": np.array([c[1] for c in cells]),
            "value": np.linspace(0, 1, len(cells)),
        }
    )
    view = RunView(chart_views.marks(), (Entry("a", 0, "pairwise_test", lambda _: table, dict),))
    return charts("run")["trials_placement"].draw(view, ChartOptions())


def test_rows_are_as_high_as_their_values_lie_apart() -> None:
    figure = drawn([0.0, 100.0, 500.0, 4000.0])
    (cells,) = (t for t in figure["data"] if t["type"] == "heatmap")
    assert cells["y"].tolist() == [-50.0, 50.0, 300.0, 2250.0, 5750.0]
    assert cells["z"].shape == (4, 3)
    axis = figure["layout"]["yaxis"]
    assert axis["tickvals"] == [0.0, 500.0, 4000.0], "a tick where it has room"
    points = [t for t in figure["data"] if t.get("mode") == "markers"]
    assert all(set(np.asarray(t["y"]).tolist()) <= {0.0, 100.0, 500.0, 4000.0} for t in points)


def test_one_row_is_a_strip() -> None:
    figure = drawn([0.0])
    assert figure["layout"]["yaxis"]["type"] == "category" or "tickvals" not in figure["layout"]["yaxis"]
