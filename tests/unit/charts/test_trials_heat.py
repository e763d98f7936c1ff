"""Maps of trackers over two swept values, from a table of metrics written by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.result import Table
from backend.charts.plot_tracking.trials_heat import CHART
from backend.charts.view import ChartOptions
from tests import chart_views

DETECTION, FALSE = "scenario.detection_probability", "scenario.false_plots"


def metrics(metric: str, factor: float, one: bool = False) -> Table:
    """A value of 100 times the row plus the column, in turn, with rows of legs between them."""
    rows = [(p, f) for p in ((0.9,) if one else (0.7, 0.9)) for f in (0.0, 10.0, 50.0)]
    columns: dict[str, Any] = {
        "metric": [metric] * len(rows) + ["rms_horizontal_m"],
        "segment": [None] * (len(rows) + 1),
        "target": [None] * (len(rows) + 1),
        DETECTION: np.array([p for p, _ in rows] + [0.7]),
        FALSE: np.array([f for _, f in rows] + [0.0]),
        "value": np.array([factor * (1000 * p + f) for p, f in rows] + [7.0]),
    }
    order = np.random.default_rng(1).permutation(len(rows) + 1)
    return Table({n: c[order] if isinstance(c, np.ndarray) else [c[i] for i in order] for n, c in columns.items()})


def draw(*tables: Table) -> dict[str, Any]:
    view = chart_views.run(chart_views.two_radars(), *({"metrics": t} for t in tables))
    return CHART.draw(view, ChartOptions())


def test_every_cell_stands_where_its_values_are() -> None:
    drawn = draw(metrics("ospa_m", 1.0), metrics("ospa_m", 2.0))
    first, second = drawn["data"]
    assert first["z"].tolist() == [[700, 710, 750], [900, 910, 950]]
    assert second["z"].tolist() == [[1400, 1420, 1500], [1800, 1820, 1900]]
    assert (first["y"], first["yaxis"], second["yaxis"]) == (["0.7", "0.9"], "y", "y2")
    assert first["x"].tolist() == [-5, 5, 30, 70]
    # One scale of colours.
    assert {(t["zmin"], t["zmax"]) for t in drawn["data"]} == {(700, 1900)}


def test_without_targets_it_is_false_tracks_and_one_value_makes_a_strip() -> None:
    drawn = draw(metrics("false_tracks_per_scan", 0.001, one=True))
    (only,) = drawn["data"]
    assert only["z"].shape == (1, 3)
    assert drawn["layout"]["meta"]["notes"][0]["text"].startswith("Confirmed tracks of nothing")


def test_nothing_swept_is_said() -> None:
    assert draw(Table({"metric": ["ospa_m"], "segment": [None], "target": [None], "value": np.array([1.0])}))[
        "layout"]["meta"]["not_applicable"] == "no_sweep"  # fmt: skip
