"""Charts over trials: whose colour a line has, what a gain is, and where a sweep has its ticks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.result import Table
from backend.charts import theme, trials_error, trials_gain, trials_sweep, trials_times
from backend.charts.view import ChartOptions, Entry, RunView
from tests import chart_views

RECORDING = chart_views.marks()


def view(swept: str = "scenario.sigma_altitude_m") -> RunView:
    return chart_views.run(RECORDING, chart_views.trial_tables(2.0, swept), chart_views.trial_tables(1.0, swept))


def lines(drawn: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {t["name"]: t for t in drawn["data"] if t["meta"]["role"] == "series"}


def test_a_label_keeps_its_colour_and_its_variants_differ() -> None:
    found = lines(trials_error.draw(view(), ChartOptions()))
    first, second = (found[f"b, sigma_altitude_m = {v}, actual"] for v in (10, 100))
    assert {first["meta"]["index"], second["meta"]["index"]} == {1}, "the chip of the label hides both"
    assert first["legendgroup"] == second["legendgroup"] == "b"
    assert first["line"]["color"] == theme.series_color(1)
    assert second["line"]["color"] == theme.faint(theme.series_color(1), 0.4)
    assert first["line"]["dash"] != second["line"]["dash"]


def test_the_gain_is_the_error_of_the_first_label_over_that_of_another_under_the_same_conditions() -> None:
    drawn = trials_gain.draw(view(), ChartOptions())
    found = lines(drawn)
    assert set(found) == {"b, sigma_altitude_m = 10", "b, sigma_altitude_m = 100"}
    for line in found.values():
        np.testing.assert_allclose(np.asarray(line["y"], float)[1:], 2.0, rtol=1e-6)


def test_a_sweep_of_the_first_label_itself_has_no_single_reference() -> None:
    tables = chart_views.trial_tables(2.0, "a.sigma_altitude_m"), chart_views.trial_tables(1.0, "b.sigma_altitude_m")
    drawn = trials_gain.draw(chart_views.run(RECORDING, *tables), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_reference"


def test_one_label_alone_has_no_gain() -> None:
    drawn = trials_gain.draw(chart_views.run(RECORDING, chart_views.trial_tables()), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "nothing_to_compare"


def test_a_sweep_has_a_tick_at_every_value() -> None:
    drawn = trials_sweep.draw(view(), ChartOptions())
    axis = drawn["layout"]["xaxis"]
    assert axis["type"] == "log"
    assert axis["tickvals"] == [10.0, 100.0]
    assert axis["ticktext"] == ["10", "100"]
    assert axis["title"]["text"] == "sigma altitude m", "a preset that nobody knows has no words for it"
    assert lines(drawn)["b"]["line"]["color"] == theme.series_color(1)


def times_over(aircraft: list[float], seconds: list[float]) -> RunView:
    table = Table(
        {
            "scenario.aircraft": np.array(aircraft),
            "seconds_per_trial": np.array(seconds),
            "trials": np.full(len(aircraft), 4),
        }
    )
    entry = Entry("tracker", 0, "tracker", lambda name: table if name == "computing_times" else Table({}), dict)
    return RunView(view().recording, (entry,))


def test_time_of_a_trial_stands_over_what_is_swept() -> None:
    (line,) = lines(trials_times.draw(times_over([100.0, 10.0, 1.0], [2.0, 0.2, 0.02]), ChartOptions())).values()
    assert np.asarray(line["x"]).tolist() == [1.0, 10.0, 100.0]
    assert np.asarray(line["y"]).tolist() == [0.02, 0.2, 2.0]
    drawn = trials_times.draw(times_over([], []), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_times"


def test_many_targets_are_a_mean_and_few_are_themselves() -> None:
    def drawn(count: int) -> dict[str, Any]:
        names = [f"{i}" for i in range(count) for _ in range(2)]
        columns: dict[str, Any] = {
            "target": names,
            "time_s": np.tile([0.0, 5.0], count),
            "rms_horizontal_m": np.repeat(np.arange(1.0, count + 1), 2),
            "nees": np.repeat(np.arange(1.0, count + 1), 2),
            "trials": np.full(2 * count, 4.0),
        }
        columns |= {f"rms_horizontal_m_{e}": columns["rms_horizontal_m"] for e in ("low", "high")}
        columns["rms_horizontal_m"][-1] = np.nan
        table = Table(columns)
        entry = Entry("tracker", 0, "tracker", lambda name: table if name == "curves" else Table({}), dict)
        return trials_error.draw(RunView(view().recording, (entry,)), ChartOptions())

    few, many = drawn(12), drawn(13)
    assert len(lines(few)) == 12
    (line,) = lines(many).values()
    squares = np.arange(1.0, 14.0) ** 2
    assert np.asarray(line["y"], float) == pytest.approx([np.sqrt(squares.mean()), np.sqrt(squares[:-1].mean())])
    assert [t for t in few["data"] if t["meta"]["role"] == "interval"]
    assert not [t for t in many["data"] if t["meta"]["role"] == "interval"]
    assert [n["code"] for n in many["layout"]["meta"]["notes"]][-1] == "mean_over_targets"


def swept_over(values: list[float]) -> dict[str, Any]:
    count = len(values)
    table = Table(
        {
            "metric": ["rms_horizontal_m"] * count,
            "segment": [None] * count,
            "target": [None] * count,
            "scenario.sigma_toa_ns": np.array(values),
            "value": np.linspace(100.0, 200.0, count),
            "ci95_low": np.linspace(90.0, 190.0, count),
            "ci95_high": np.linspace(110.0, 210.0, count),
        }
    )
    entry = Entry("rdf", 0, "rdf", lambda name: table if name == "metrics" else Table({}), dict)
    seen = RunView(view().recording, (entry,), scenario="four_station_circuit")
    axis: dict[str, Any] = trials_sweep.draw(seen, ChartOptions())["layout"]["xaxis"]
    return axis


def test_who_is_not_swept_stands_as_a_level_beside_those_who_are() -> None:
    swept = chart_views.trial_tables(1.0, "b.sigma_altitude_m")
    alone = chart_views.trial_tables(2.0, "b.sigma_altitude_m")
    metrics = alone["metrics"]
    once = metrics.take(np.arange(len(metrics)) == 0)
    once = Table(once.columns | {"b.sigma_altitude_m": np.full(len(once), np.nan)})
    drawn = trials_sweep.draw(chart_views.run(RECORDING, alone | {"metrics": once}, swept), ChartOptions())
    level = lines(drawn)["a"]
    assert level["x"].tolist() == [10.0, 100.0]
    assert level["y"][0] == level["y"][1]
    assert level["mode"] == "lines"


@pytest.mark.parametrize(
    ("values", "kind", "ticks"),
    [
        ([5, 10, 15, 20], "linear", [5, 10, 15, 20]),
        # Zero has no place on a logarithmic axis, and 1 and 2 no room beside it on this one.
        ([0, 1, 2, 50, 100], "linear", [0, 50, 100]),
        ([1, 1.6, 10, 100, 1000], "log", [1, 1.6, 10, 100, 1000]),
        ([1, 1.2, 10, 100, 1000], "log", [1, 10, 100, 1000]),
        ([0.5, 20.5, 40.5, 60.5], "linear", [0.5, 20.5, 40.5, 60.5]),
        ([10, 3000], "log", [10, 3000]),
        (list(range(20, 121)), "linear", list(range(20, 121, 6))),
    ],
)
def test_ticks_have_room(values: list[float], kind: str, ticks: list[float]) -> None:
    axis = swept_over(values)
    assert axis["title"]["text"] == "Time-of-arrival error, ns"
    assert axis["type"] == kind
    assert axis["tickvals"] == ticks
    assert axis["ticktext"] == [f"{tick:g}" for tick in ticks]


@pytest.mark.parametrize("chart", [trials_error, trials_gain, trials_sweep], ids=lambda c: c.CHART.name)
def test_entries_keep_their_place_when_others_are_missing(chart: Any) -> None:
    entries = view().entries
    moved = tuple(Entry(e.label, e.index + 3, e.algorithm, e.table, e.arrays) for e in entries)
    drawn = chart.draw(RunView(RECORDING, moved), ChartOptions())
    assert {t["meta"]["index"] for t in drawn["data"] if t["meta"]["index"] is not None} <= {3, 4}


def curves(low: list[float]) -> RunView:
    """One label whose interval ends at these lower values."""
    count = len(low)
    table = Table(
        {
            "time_s": np.arange(float(count)),
            "target": [None] * count,
            "rms_horizontal_m": np.full(count, 100.0),
            "rms_horizontal_m_low": np.array(low),
            "rms_horizontal_m_high": np.full(count, 200.0),
            "trials": np.full(count, 2),
        }
    )
    entry = Entry("rdf", 0, "rdf", lambda name: table if name == "curves" else Table({}), dict)
    return RunView(view().recording, (entry,))


def test_an_interval_that_reaches_down_to_zero_has_no_band_on_a_logarithmic_axis_and_is_counted() -> None:
    drawn = trials_error.draw(curves([50, 60, 0, 0, 70, 80, np.nan, 90]), ChartOptions())
    (band,) = [t for t in drawn["data"] if t["meta"]["role"] == "interval"]
    held = np.isfinite(band["y"])
    assert (band["y"][held] > 0).all()
    assert sorted(set(band["x"][held])) == [0.0, 1.0, 4.0, 5.0, 7.0]
    # Three outlines: before the zeros, after them, after the gap.
    assert (~held).sum() == 3
    (note,) = [n for n in drawn["layout"]["meta"]["notes"] if n["code"] == "interval_to_zero"]
    assert note["text"].startswith("No band at 2 instants of 7:")
    assert note["label"] == "rdf"
    whole = trials_error.draw(curves([50, 60]), ChartOptions())
    assert "interval_to_zero" not in [n["code"] for n in whole["layout"]["meta"]["notes"]]
