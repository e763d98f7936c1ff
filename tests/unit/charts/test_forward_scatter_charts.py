"""What the charts of forward scatter show of real results."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.result import Table
from algorithms.spec import LocalContext
from algorithms.toolbox.monte_carlo.running import DRAWN_TRIALS, Running
from algorithms.toolbox.monte_carlo.sums import sums_of
from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions, Entry, RunView
from backend.files.store import json_array

LINES, ML, ANGLE = (f"forward_scatter_{n}" for n in ("lines", "ml", "angle"))


@cache
def recording() -> DopplerPairs:
    return simulate(PassParameters(targets=2, target_interval_s=60.0, distance_step_m=10_000.0), (0,), 4)


@cache
def entry(name: str, index: int, **parameters: Any) -> Entry:
    algorithm = algorithms_by_name()[name]
    result = algorithm.run(recording(), algorithm.parameters(**parameters), LocalContext())
    tables = algorithm.tabulate(recording(), result)
    return Entry(name, index, name, lambda table: tables.get(table, Table({})), lambda: result.arrays)


def drawn(chart: str, *entries: Entry) -> list[dict[str, Any]]:
    found = charts("run")[chart].draw(RunView(recording(), entries), ChartOptions(full=True))
    return list(found["data"])


def test_the_difference_and_the_angular_velocity_have_their_exact_ones() -> None:
    traces = drawn("angular_velocity", entry(LINES, 0))
    exact = {t.get("yaxis", "y"): np.asarray(t["y"]) for t in traces if t["meta"]["role"] == "truth"}
    assert set(exact) == {"y", "y2"}
    assert np.degrees(200 / 15_000) == pytest.approx(np.nanmax(exact["y"]), rel=1e-6)
    at_crossings = exact["y2"][np.isfinite(exact["y2"])][[15, 46]]
    assert at_crossings == pytest.approx([-300 * 200 / 15_000, -300 * 200 / 25_000], rel=1e-3)
    own = next(t for t in traces if t["meta"]["role"] == "series" and t.get("yaxis") == "y2")
    assert np.nanmean(own["y"]) == pytest.approx(np.nanmean(exact["y2"]), rel=0.15)


def test_a_fit_without_lines_draws_what_it_gives_for_each_channel() -> None:
    """Two channels of two passes: four pieces of 31 rows, within the noise of what was measured."""
    own = [t for t in drawn("doppler_lines", entry(ML, 0), entry(LINES, 1)) if t["meta"]["role"] == "series"]
    (curve,) = (t for t in own if t["meta"].get("label") == ML)
    value = np.asarray(curve["y"], float)
    pieces = np.split(value, np.flatnonzero(np.isnan(value)))
    assert [int(np.isfinite(p).sum()) for p in pieces] == [31] * 4
    measured = recording().doppler_hz[:, :, 0].T.ravel()
    assert np.std(value[np.isfinite(value)] - measured) == pytest.approx(0.2, rel=0.3)


def test_the_line_that_gave_a_kept_crossing_is_solid() -> None:
    """It crosses zero where the cross stands, within its own window; nothing is kept of a pass that ends before."""
    own = {t["name"]: t for t in drawn("doppler_lines", entry(LINES, 0)) if t["meta"]["role"] == "series"}
    for j in (1, 2):
        kept, cross, last = (own[f"{LINES}, {w} {j}"] for w in ("kept line", "crossing of receiver", "line"))
        assert (kept["line"]["dash"], last["line"]["dash"]) == ("solid", "dash")
        x, y = (np.asarray(kept[c]).reshape(2, 4)[:, :3] for c in "xy")
        assert x[np.abs(y) < 1e-9] == pytest.approx(np.asarray(cross["x"]))
        # Ten seconds long, and the crossing is seen before the window's end.
        assert x[:, -1] - x[:, 0] == pytest.approx(9.0)
    early = recording().take(np.arange(12))
    algorithm = algorithms_by_name()[LINES]
    found = algorithm.tabulate(early, algorithm.run(early, algorithm.parameters(), LocalContext()))
    one = Entry("a", 0, LINES, lambda name: found.get(name, Table({})), dict)
    names = {t["name"] for t in charts("run")["doppler_lines"].draw(RunView(early, (one,)), ChartOptions())["data"]}
    assert {"a, line 1", "a, line 2"} <= names
    assert not any("kept" in name or "crossing" in name for name in names)


def test_true_azimuths_are_those_of_the_receiver_that_measures() -> None:
    """What was measured scatters about them by half a degree, in two flights."""
    traces = {t["meta"]["role"]: t for t in drawn("azimuth", entry(ANGLE, 0))}
    true, measured = np.asarray(traces["truth"]["y"]), np.asarray(traces["measurement"]["y"])
    assert np.flatnonzero(np.isnan(true)).tolist() == [31]
    off = measured - true[np.isfinite(true)]
    assert off.std() == pytest.approx(0.5, rel=0.3)
    assert off.mean() == pytest.approx(0, abs=0.25)


def test_what_still_lies_ahead_is_hollow() -> None:
    (curve,) = (
        t for t in drawn("crossing", entry(LINES, 0)) if t["meta"]["role"] == "series" and t.get("yaxis", "y") == "y"
    )
    symbols = curve["marker"]["symbol"]
    words = curve["hovertext"]
    assert {w for w, s in zip(words, symbols, strict=True) if s.endswith("-open")} == {"extrapolated"}
    assert {w for w, s in zip(words, symbols, strict=True) if not s.endswith("-open")} >= {"crossed"}


def test_sensitivities_are_those_of_the_table() -> None:
    """Of the last pass, at 25 km; one receiver has no second clock."""
    by_entry = {t["name"]: dict(zip(t["y"], np.asarray(t["x"]).tolist(), strict=True)) for t in drawn(
        "sensitivity", entry(LINES, 0), entry(ANGLE, 1)
    )}  # fmt: skip
    assert len(by_entry[LINES]) == 6
    assert by_entry[LINES]["clock of the second receiver, 1 ms"] == pytest.approx(33, abs=8)
    assert by_entry[LINES]["frequency of both, 0.1 Hz"] == pytest.approx(0, abs=3)
    assert by_entry[LINES]["frequency of the second receiver, 0.1 Hz"] == pytest.approx(-750, abs=150)
    assert len(by_entry[ANGLE]) == 3


def test_the_map_of_the_bound() -> None:
    curves = drawn("base_bound", entry(ML, 0))
    assert len(curves) == 4
    unknown = next(t for t in curves if t["name"] == "at the end, course unknown")
    x, y = np.asarray(unknown["x"]), np.asarray(unknown["y"])
    assert y[np.argmin(np.abs(x - 15))] == pytest.approx(249, abs=8)
    assert y[np.argmin(np.abs(x - 30))] == pytest.approx(281, abs=8)
    assert max(y[0], y[-1]) < 60, "it vanishes near both ends"


@cache
def trials(**scenario: Any) -> RunView:
    """Statistics of 64 trials of two windows, as a run composes them."""
    preset = scenarios_by_name()["forward_scatter_pass"]
    conditions = preset.parameters(crossing_distance_m=30_000.0, **scenario)
    recorded = preset.simulate(conditions, tuple(range(64)), 7)
    entries = []
    for i, window in enumerate((10, 31)):
        algorithm = algorithms_by_name()[LINES]
        assert algorithm.score is not None
        running = Running(1)
        for first in range(0, 64, 16):
            part = preset.simulate(conditions, tuple(range(first, first + 16)), 7)
            scores = algorithm.score(part, algorithm.parameters(window=window), LocalContext(7, first))
            running.add([sums_of(scores, preset.legs(conditions))])
        time = running.axes(0).time_s
        columns: dict[str, Any] = {"time_s": time, "target": [None] * time.size, "trials": np.full(time.size, 64.0)}
        tables = {"curves": Table(columns | running.curves(0))}
        values = {f"trials/{n}": array[None] for n, array in running.sample_arrays(0).items()}
        values |= {"trials/cells": json_array([{}]), "trials/kept_time_s": time}
        name = f"N = {window}"
        entries.append(
            Entry(name, i, LINES, lambda t, own=tables: own.get(t, Table({})), lambda held=values: held)  # type: ignore[misc]
        )
    return RunView(recorded.take(np.arange(len(recorded))), tuple(entries))


def test_the_middle_of_the_errors_is_shown_where_moments_do_not_exist() -> None:
    traces = charts("run")["trials_range"].draw(trials(), ChartOptions(full=True))["data"]
    median, lost = (
        next(t for t in traces if t["meta"]["role"] == "series" and t["meta"]["index"] == 0 and t["yaxis"] == y)
        for y in ("y", "y2")
    )
    assert np.isfinite(np.asarray(median["y"])[1:]).all(), "from the second pair on"
    share = np.asarray(lost["y"])
    assert share[0] == 100
    assert 3 < share[3] < 30, "13 % fall outside the base line at 3 s"
    assert (share[8:] == 0).all()
    band = next(t for t in traces if t["meta"]["role"] == "interval")
    low, high = np.split(np.asarray(band["y"]), 2)[::-1]
    at_end = (high[-1] - low[::-1][-1]) / 2
    assert at_end == pytest.approx(677, rel=0.35), "one standard deviation to either side"


def test_paths_of_single_trials_and_the_true_one() -> None:
    traces = charts("run")["trials_paths"].draw(trials(), ChartOptions(full=True))["data"]
    series = [t for t in traces if t["meta"]["role"] == "series"]
    assert [t["name"] for t in series] == ["N = 10", "N = 31"]
    (true,) = (t for t in traces if t["meta"]["role"] == "truth")
    assert np.asarray(true["x"]) == pytest.approx(30.0)
    assert np.asarray(true["y"])[[0, -1]] == pytest.approx([-3.0, 3.0])
    # Five trials of 31 instants, with a gap behind each.
    x, y = (np.asarray(series[0][c]).reshape(5, 32) for c in "xy")
    assert np.isnan(x[:, -1]).all()
    assert np.abs(x[:, 30] - 30).max() < 3
    assert np.isnan(x[:, :6]).all(), "before, they jump by kilometres"
    assert len({round(v, 6) for v in x[:, 30].tolist()}) == 5
    assert np.abs(y[:, 30] - 3).max() < 0.5
    assert len(trials().entries[0].arrays()["trials/place_along_m"][0, 0]) == DRAWN_TRIALS == 20


@pytest.mark.parametrize("interval", [31.0, 60.0])
def test_targets_one_after_another_are_lines_of_their_own(interval: float) -> None:
    """Also without a silence between them; what settles, settles anew in each."""
    two = trials(targets=2, target_interval_s=interval, distance_step_m=-10_000.0)
    drawn_paths = charts("run")["trials_paths"].draw(two, ChartOptions(full=True))["data"]
    (true,) = (t for t in drawn_paths if t["meta"]["role"] == "truth")
    assert np.flatnonzero(np.isnan(np.asarray(true["x"]))).tolist() == [31]
    first = np.asarray(next(t for t in drawn_paths if t["meta"]["role"] == "series")["x"])[: 2 * 31 + 2]
    assert np.isnan(first[[*range(6), 31, *range(32, 38), 63]]).all()
    assert np.abs(first[[30, 62]] - [30, 20]).max() < 3
    if interval > 31:
        spread = charts("run")["trials_range"].draw(two, ChartOptions(full=True))["data"]
        assert len([t for t in spread if t["meta"]["role"] == "interval"]) == 2 * 2
        lost = next(np.asarray(t["y"]) for t in spread if t.get("yaxis") == "y2")
        assert np.flatnonzero(np.isnan(lost)).tolist() == [31]
        crossing = charts("run")["trials_crossing"].draw(two, ChartOptions(full=True))["data"]
        bound = next(t for t in crossing if t["meta"]["role"] == "bound")
        known = np.isfinite(np.asarray(bound["y"]))
        assert known.tolist() == (2 * ([False] * 6 + [True] * 25))


def test_one_wild_chi2_does_not_hide_the_others() -> None:
    one = recording().doppler_hz.copy()
    one[1, 0, 0] += 60.0
    wild = replace(recording(), doppler_hz=one)
    algorithm = algorithms_by_name()[ML]
    for known, view in ((recording(), False), (wild, True)):
        found = algorithm.run(known, algorithm.parameters(robust="consensus"), LocalContext())
        tables = algorithm.tabulate(known, found)
        made = Entry(ML, 0, ML, lambda name, own=tables: own.get(name, Table({})), dict)  # type: ignore[misc]
        layout = charts("run")["doppler_residuals"].draw(RunView(known, (made,)), ChartOptions(full=True))["layout"]
        assert ("range" in layout["yaxis2"]) is view
        if view:
            assert 2 < layout["yaxis2"]["range"][1] < 20


def test_a_second_swept_value_has_lines_of_its_own() -> None:
    rows = [(sigma, s, segment) for sigma in (0.1, 0.5, 1.0) for s in (15e3, 30e3) for segment in ("crossing", "end")]
    sigma, distance, segment = (list(column) for column in zip(*rows, strict=True))
    value = np.array([100 * a * (b / 15e3) * (2 if c == "end" else 1) for a, b, c in rows])
    table = Table(
        {
            "metric": ["crossing_distance_rms_m"] * len(rows),
            "segment": segment,
            "target": [None] * len(rows),
            "scenario.sigma_azimuth_deg": np.array(sigma),
            "scenario.crossing_distance_m": np.array(distance),
            "value": value,
            "ci95_low": 0.9 * value,
            "ci95_high": 1.1 * value,
        }
    )
    one = Entry("a", 0, ANGLE, lambda name: table if name == "metrics" else Table({}), dict)
    found = {t["name"]: (list(t["x"]), list(t["y"])) for t in drawn("trials_crossing_sweep", one)}
    assert set(found) == {f"a, crossing_distance_m = {s}, {e}" for s in ("15000", "30000") for e in ("crossing", "end")}
    assert found["a, crossing_distance_m = 30000, end"] == ([0.1, 0.5, 1.0], pytest.approx([40.0, 200.0, 400.0]))
