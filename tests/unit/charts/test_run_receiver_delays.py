"""Delay of each receiver over time: who is drawn how, and what is said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.result import Table
from backend.charts import run_receiver_delays
from backend.charts.run_receiver_delays import CHART
from backend.charts.view import ChartOptions, Figure, RunView
from tests import chart_views


def view(names: list[str] | None = None) -> RunView:
    recording = chart_views.marks()
    names = list(recording.stations) if names is None else names
    k = np.arange(3.0)
    delays = Table(
        {
            "station": [name for name in names for _ in k],
            "time_s": np.tile(k, len(names)),
            "receptions": np.full(3 * len(names), 20.0),
            "late_m": np.repeat(np.arange(len(names), dtype=float), 3),
            "late_sd_m": np.full(3 * len(names), 2.0),
        }
    )
    tables = {"receiver_delays": delays, "receivers": chart_views.receivers()}
    return RunView(recording, (chart_views.entry("a", 0, tables, recording),))


def drawn(shown: RunView) -> Figure:
    return CHART.draw(shown, ChartOptions())


def test_each_station_has_its_line_with_two_standard_deviations() -> None:
    traces: dict[str, Any] = {t["name"]: t for t in drawn(view())["data"]}
    assert set(traces) == {"station west", "station east", "station north", "station middle"}
    np.testing.assert_allclose(traces["station north"]["y"], 2.0)
    np.testing.assert_allclose(traces["station north"]["error_y"]["array"], 4.0)


def test_of_many_stations_only_those_in_colours_have_names_beside_the_chart(monkeypatch: pytest.MonkeyPatch) -> None:
    assert all(t.get("showlegend", True) for t in drawn(view())["data"])
    monkeypatch.setattr(run_receiver_delays, "MOST_COLOURED", 3)
    shown = {t["name"] for t in drawn(view())["data"] if t.get("showlegend", True)}
    assert shown == {"station east"}


def test_the_suspect_is_strong_on_top_and_explained(note_of) -> None:
    figure = drawn(view())
    last = figure["data"][-1]
    assert last["name"] == "station east"
    assert last["line"]["width"] > figure["data"][0]["line"]["width"]
    assert note_of(figure, "suspect_receiver") == "Station east disagrees with the others: late by 1000 ns (300 m)."


def test_without_any_delay_it_says_so() -> None:
    assert drawn(view([]))["layout"]["meta"]["not_applicable"] == "no_delays"
