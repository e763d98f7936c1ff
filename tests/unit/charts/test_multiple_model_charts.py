"""Charts of multiple models: powers of the matrix, operations, the field of view, panels, plots of an antenna."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.multiple_model.scenario import AeroballisticParameters, simulate
from algorithms.recording import AntennaPlots
from algorithms.result import Table
from backend.charts import recording_plan
from backend.charts.multiple_model import (
    conversion_bias,
    conversion_condition,
    trajectory,
    transition_powers,
    trials_cost,
    trials_modes,
    trials_position,
)
from backend.charts.table import chart_table
from backend.charts.view import ChartOptions, RecordingView, RunView
from tests import chart_views

SIX = ("mma2_122", "mma2_11", "kalman_1_20", "kalman_1_5", "kalman_2_20", "kalman_2_1")


@pytest.fixture(scope="module")
def arc() -> AntennaPlots:
    return simulate(AeroballisticParameters(rate_hz=1.0), (0,), 1)


def run_of(*algorithms: str, tables: dict[str, Table] | None = None, **parameters: Any) -> RunView:
    entries = [
        replace(chart_views.entry(name, i, tables or {}), algorithm=name, parameters=parameters if i == 0 else {})
        for i, name in enumerate(algorithms)
    ]
    return RunView(chart_views.antenna(), tuple(entries))


def kept(drawn: dict[str, Any], name: str, interval_s: float) -> float:
    (line,) = (t for t in drawn["data"] if t["name"] == name)
    return float(np.interp(np.log(interval_s), np.log(line["x"]), line["y"]))


def test_powers_of_the_matrix_are_those_of_the_specification() -> None:
    """Section 5: after 1, 10 and 60 s, and after endless time."""
    drawn = transition_powers.draw(run_of("mma2_122", "mma2_11"), ChartOptions())
    for name, values in (
        ("mma2_122, cv_0.05", (0.9244, 0.5245, 0.2541)), ("mma2_122, ca_30", (0.9258, 0.6003, 0.5)),
        ("mma2_11, cv_5", (0.9130, 0.6829, 0.6667)), ("mma2_11, cv_30", (0.8261, 0.3658, 0.3333)),
    ):  # fmt: skip
        for interval, value in zip((1.0, 10.0, 60.0), values, strict=True):
            assert kept(drawn, name, interval) == pytest.approx(value, abs=6e-4), (name, interval)
    assert kept(drawn, "mma2_122, ca_30, in the end", 1.0) == pytest.approx(0.5)
    assert kept(drawn, "mma2_11, cv_5, in the end", 1.0) == pytest.approx(2 / 3)


def test_powers_that_do_not_exist_are_left_out_and_one_chain_is_drawn_once() -> None:
    models = [{"kind": "cv", "sigma_mps2": 1.0}, {"kind": "ca", "sigma_mps2": 1.0}]
    flip = {"models": models, "transition": [[0.1, 0.9], [0.9, 0.1]], "transition_step_s": 1.0}
    drawn = transition_powers.draw(run_of("multiple_model", **flip), ChartOptions())
    (line,) = (t for t in drawn["data"] if t["name"] == "multiple_model, cv_1")
    assert np.isnan(line["y"]).sum() > 100
    assert [note["code"] for note in drawn["layout"]["meta"]["notes"]] == ["no_power"]
    same = transition_powers.draw(run_of("mma2_122", "mma2_122", structure="gpb2"), ChartOptions())
    assert len([t for t in same["data"] if t["meta"]["role"] == "series"]) == 3
    assert [note["code"] for note in same["layout"]["meta"]["notes"]] == ["same_chain"]


def test_operations_are_those_of_the_specification() -> None:
    """Section 6.5; a set that nobody has counted is said so."""
    metrics = Table(
        {"metric": ["rms_up_m"] * 2, "segment": ["arc", "turn"], "target": [None] * 2, "value": np.array([50.0, 70.0]),
         "ci95_low": np.array([49.0, 69.0]), "ci95_high": np.array([51.0, 71.0])}
    )  # fmt: skip
    tables = {"metrics": metrics}
    for structure, count in (("gpb1", 3407), ("imm", 4444), ("gpb2", 8344)):
        drawn = trials_cost.draw(run_of(*SIX, tables=tables, structure=structure, merging="moment"), ChartOptions())
        found = {t["name"]: t["x"].tolist() for t in drawn["data"] if t["meta"]["role"] == "series"}
        assert found["mma2_122"] == [count] * 2
        assert (found["mma2_11"][0], found["kalman_1_5"][0], found["kalman_2_1"][0]) == (1964, 568, 937)
    assert [t["name"] for t in drawn["data"] if t["meta"]["role"] == "bound"] == ["arc", "turn"]
    other = trials_cost.draw(run_of("mma2_122", "multiple_model", tables=tables), ChartOptions())
    assert "not_counted" in [note["code"] for note in other["layout"]["meta"]["notes"]]


def test_the_field_of_view_has_the_specification_s_condition_and_bias(arc: AntennaPlots) -> None:
    """Section 3.2: 2 and 3.9 at 60 and 75 degrees off the boresight; 3.3: r s^2 / sigma at the boresight."""
    drawn = conversion_condition.draw(RecordingView(arc), ChartOptions(full=True))
    map_ = drawn["data"][0]
    degrees, values = np.radians(map_["y"]), map_["customdata"]
    diagonal = np.sin(degrees) ** 2 * 2
    condition = values[range(len(degrees)), range(len(degrees))]
    for off, value in ((30, 1.15), (60, 2.0), (75, 3.9)):
        k = np.nanargmin(np.abs(diagonal - np.sin(np.radians(off)) ** 2))
        assert condition[k] == pytest.approx(1 / np.sqrt(1 - diagonal[k]), rel=1e-4)
        assert condition[k] == pytest.approx(value, rel=0.15)
    assert np.nanmax(values) < 30
    bias = conversion_bias.draw(RecordingView(arc), ChartOptions())["data"][0]
    middle = bias["customdata"][len(degrees) // 2, len(degrees) // 2]
    assert middle == pytest.approx(np.nanmax(arc.range_m) * np.radians(0.1) ** 2 / 2.5, rel=1e-3)
    table = chart_table(drawn)
    assert np.nanmax(table.columns["z"]) == pytest.approx(np.nanmax(values))
    assert (table.columns["row"] >= 1).sum() == len(arc)


def test_plots_of_an_antenna_stand_in_the_plan(arc: AntennaPlots) -> None:
    drawn = recording_plan.draw(RecordingView(arc), ChartOptions())
    (plots,) = (t for t in drawn["data"] if t["meta"]["role"] == "measurement")
    off = np.hypot(1000 * plots["x"] - arc.truth_m[:, 0], 1000 * plots["y"] - arc.truth_m[:, 1])
    # 0.1 degrees at up to 333 km; where there is no antenna there are no places.
    assert np.median(off) < 500
    assert off.max() < 4000
    nowhere = recording_plan.draw(RecordingView(replace(arc, site=None)), ChartOptions())
    assert not [t for t in nowhere["data"] if t["meta"]["role"] == "measurement" and np.isfinite(t["x"]).any()]


def test_a_trajectory_in_space_follows_the_truth_and_says_what_lies_outside(arc: AntennaPlots) -> None:
    n = len(arc)
    up = np.where(np.arange(n) < 2, 9e5, arc.truth_m[:, 2])
    states = Table(
        {"time_s": arc.time_s, "row": arc.row, "track": np.ones(n), "trial": np.full(n, np.nan),
         "east_m": arc.truth_m[:, 0], "north_m": arc.truth_m[:, 1], "up_m": up}
    )  # fmt: skip
    drawn = trajectory.draw(chart_views.run(arc, {"states": states}), ChartOptions(full=True))
    assert [(t["meta"]["role"], t["type"]) for t in drawn["data"]] == [
        ("series", "scatter3d"), ("truth", "scatter3d"), ("bound", "scatter3d")
    ]  # fmt: skip
    series, truth, shadow = drawn["data"]
    np.testing.assert_allclose(np.stack([truth[k] for k in "xyz"], axis=1), arc.truth_m / 1000)
    low, high = drawn["layout"]["scene"]["zaxis"]["range"]
    assert low < truth["z"].min() < truth["z"].max() < high < 100
    assert (shadow["z"] == low).all()
    assert [note["code"] for note in drawn["layout"]["meta"]["notes"]] == ["own_scales", "outside_view"]
    table = chart_table(drawn)
    np.testing.assert_allclose(np.asarray(table.columns["z"])[:n], series["z"])


def test_probabilities_over_trials_stack_to_one_and_the_bound_in_space_has_three_axes() -> None:
    tables = chart_views.trial_tables(swept="seed")
    view = run_of("mma2_122", tables=tables)
    drawn = trials_modes.draw(view, ChartOptions())
    first = [t for t in drawn["data"] if t["stackgroup"] == "models0"]
    assert [t["name"].rpartition(", ")[2] for t in first] == ["cv_0.05", "ca_30"]
    total = np.sum([t["y"] for t in first], axis=0)
    np.testing.assert_allclose(total[np.isfinite(total)], 1)
    space = trials_position.draw(view, ChartOptions())
    (bound,) = (t for t in space["data"] if t["meta"]["role"] == "bound")
    curve = tables["curves"].columns["rms_position_m"]
    np.testing.assert_allclose(bound["y"][1:5], 0.5 * np.sqrt(3) * np.asarray(curve)[1:5])
