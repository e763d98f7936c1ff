"""Charts of windows over swept values, from tables of metrics written by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.result import Table
from backend.charts.plot_tracking import trials_series, trials_windows
from backend.charts.view import ChartOptions
from tests import chart_views


def metrics(metric: str, label: str, **swept: list[float]) -> Table:
    """The metric of two targets is the product of the swept values, ten times as much for the second."""
    names = list(swept)
    rows = [
        (t, *values)
        for t in ("slow", "fast")
        for values in np.stack(np.meshgrid(*swept.values()), -1).reshape(-1, len(names))
    ]
    columns: dict[str, Any] = {
        "metric": [metric] * len(rows),
        "segment": [None] * len(rows),
        "target": [row[0] for row in rows],
        "value": np.array([float(np.prod(row[1:])) * (10 if row[0] == "fast" else 1) for row in rows]),
    }
    columns |= {f"{label}.{n}": np.array([row[1 + i] for row in rows], float) for i, n in enumerate(names)}
    return Table(columns)


def test_each_target_has_a_panel_and_each_order_a_line() -> None:
    table = metrics("rms_series_m", "a", series_order=[2, 3], series_ahead_s=[20, 10, 60])
    drawn = trials_series.CHART.draw(chart_views.run(chart_views.two_radars(), {"metrics": table}), ChartOptions())
    lines = {(t["name"], t["yaxis"]): (t["x"].tolist(), t["y"].tolist()) for t in drawn["data"]}
    assert lines["a, series_order = 3", "y"] == ([10, 20, 60], [30, 60, 180])
    assert lines["a, series_order = 2", "y2"] == ([10, 20, 60], [200, 400, 1200])
    assert len(lines) == 4
    assert [a["text"] for a in drawn["layout"]["annotations"]] == ["slow", "fast"]
    # One key for both panels.
    assert [t["showlegend"] for t in drawn["data"]] == [True, True, False, False]


def test_the_lowest_minimum_goes_before_the_error() -> None:
    error = metrics("rms_ahead_m", "a", window_plots=[4, 8])
    both = Table({n: np.concatenate([error.columns[n]] * 2) if isinstance(error.columns[n], np.ndarray)
                  else [*error.columns[n], *error.columns[n]] for n in error.names}
                 | {"metric": ["rms_ahead_m"] * len(error) + ["lowest_share"] * len(error)})  # fmt: skip
    for table, log in ((error, True), (both, False)):
        drawn = trials_windows.CHART.draw(chart_views.run(chart_views.two_radars(), {"metrics": table}), ChartOptions())
        assert (drawn["layout"]["yaxis"].get("type") == "log") == log
        assert drawn["layout"]["xaxis"]["tickvals"] == [4, 8]


def test_nothing_swept_is_said() -> None:
    drawn = trials_windows.CHART.draw(chart_views.run(chart_views.two_radars(), {}), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_sweep"
