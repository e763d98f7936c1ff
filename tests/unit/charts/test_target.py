"""One target of a run or a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from algorithms.recording import TruthTracks
from algorithms.result import Table
from backend.charts.target import recording_of, run_view_of, table_of
from tests import chart_views


def test_a_recording_keeps_the_rows_of_the_target() -> None:
    recording = chart_views.marks(6, targets=3)
    one = recording_of(recording, "t2")
    assert one.row.tolist() == [2, 5]
    assert one.toa_s.shape[0] == one.truth_m.shape[0] == 2
    assert len(recording_of(recording, "nobody")) == 0


def test_the_whole_true_path_of_the_target_stays() -> None:
    tracks = TruthTracks.of(
        np.arange(4.0), np.array([0, 0, 1, 1]), np.ones((4, 3)), np.full((4, 3), np.nan), ("t2", "t1")
    )
    recording = replace(chart_views.marks(6, targets=2), truth_tracks=tracks)
    one = recording_of(recording, "t1").truth_tracks
    assert one is not None
    assert one.time_s.tolist() == [2, 3]
    assert recording_of(replace(recording, truth_tracks=None), "t1").truth_tracks is None
    nameless = replace(tracks, targets=("a", "b")) if tracks else None
    assert recording_of(replace(recording, truth_tracks=nameless), "t1").truth_tracks is None


def test_a_table_keeps_its_rows_or_stays_whole() -> None:
    table = Table({"target": ["a", "b", None, "a"], "value": np.arange(4.0), "word": ["p", "q", "r", "s"]})
    one = table_of(table, "a")
    assert one.columns["target"] == ["a", "a"]
    assert np.asarray(one.columns["value"]).tolist() == [0, 3]
    assert one.columns["word"] == ["p", "s"]
    assert len(table_of(chart_views.receivers(), "a")) == 4


def test_a_run_view_filters_when_a_table_is_read() -> None:
    view = run_view_of(chart_views.complete_run(chart_views.marks(6, targets=2)), "t1")
    (entry,) = view.entries
    assert len(view.recording) == len(entry.table("states")) == 3
    assert len(entry.table("unknown")) == 0
