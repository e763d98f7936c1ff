"""Recordings of many marks: what is left out of a result is said."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multilateration import tracker
from algorithms.multilateration.outputs import position_covariance
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import LocalContext


def test_a_long_recording_keeps_the_covariance_of_the_position(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = scenarios_by_name()["four_station_circuit"]
    recording = scenario.simulate(scenario.parameters(), (0,), 1).take(np.arange(150))
    algorithm = algorithms_by_name()["rdfv"]
    whole = algorithm.run(recording, algorithm.parameters(), LocalContext())
    assert whole.arrays["covariance"].shape == (150, 45, 1)
    assert "position_covariance" not in [note.code for note in whole.notes]
    monkeypatch.setattr(tracker, "FULL_COVARIANCE_MARKS", 149)
    short = algorithm.run(recording, algorithm.parameters(), LocalContext())
    assert short.arrays["covariance"].shape == (150, 6, 1)
    assert [note.code for note in short.notes] == [*(note.code for note in whole.notes), "position_covariance"]
    np.testing.assert_array_equal(position_covariance(short), position_covariance(whole))
    for name in set(whole.arrays) - {"covariance"}:
        np.testing.assert_array_equal(short.arrays[name], whole.arrays[name], err_msg=name)
    one, other = (algorithm.tabulate(recording, result) for result in (short, whole))
    for name, table in one.items():
        assert list(table.rows()) == list(other[name].rows()), name
    assert algorithm.measure(recording, short) == algorithm.measure(recording, whole)


def test_what_says_nothing_of_marks_with_addresses_takes_no_memory() -> None:
    scenario = scenarios_by_name()["four_station_circuit"]
    recording = scenario.simulate(scenario.parameters(), (0,), 1).take(np.arange(50))
    algorithm = algorithms_by_name()["rdfv"]
    result = algorithm.run(recording, algorithm.parameters(), LocalContext())
    told_apart = ("emitter", "emitter_distance", "emitter_threshold", "emitter_rival")
    assert {result.arrays[name].strides for name in told_apart} == {(0,)}
    tables = algorithm.tabulate(recording, result)
    assert list(tables) == ["states", "tracks", "decisions", "receivers", "receiver_delays", "errors"]
    assert tables["states"].columns["trial"].strides == (0,)  # type: ignore[union-attr]
