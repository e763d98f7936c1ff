"""One target of a run or a recording: what a chart is given when only that target is asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from algorithms.recording import Recording, TruthTracks
from algorithms.result import Table
from algorithms.texts import Texts
from backend.charts.view import Entry, RecordingView, RunView

AnyRecording = TypeVar("AnyRecording", bound=Recording)


def recording_of(recording: AnyRecording, target: str) -> AnyRecording:
    """Return the recording with the rows of this target alone; with none where it has no such target."""
    known = target in recording.targets
    rows = recording.rows_of(recording.targets.index(target)) if known else np.empty(0, np.int64)
    return replace(recording.take(rows), truth_tracks=_track_of(recording.truth_tracks, target))


def _track_of(tracks: TruthTracks | None, target: str) -> TruthTracks | None:
    if tracks is None or target not in tracks.targets:
        return None
    points = tracks.points_of(tracks.targets.index(target))
    return TruthTracks.of(
        tracks.time_s[points],
        tracks.target[points],
        tracks.position_m[points],
        tracks.velocity_mps[points],
        tracks.targets,
    )


def table_of(table: Table, target: str) -> Table:
    """Return the rows of this target; a table that does not name targets (of stations, say) stays whole."""
    names = table.columns.get("target")
    if names is None:
        return table
    return table.take(Texts.of(names).are(target))


def recording_view_of(view: RecordingView, target: str) -> RecordingView:
    """Return what the charts of a recording see of this target."""
    return RecordingView(recording_of(view.recording, target))


def run_view_of(view: RunView, target: str) -> RunView:
    """Return what the charts of a run see of this target.

    Tables of the entries hold its rows alone. Arrays stay whole: a chart finds its marks in them by the row numbers of
    the recording, which holds nothing else.
    """
    return replace(
        view,
        recording=recording_of(view.recording, target),
        entries=tuple(_entry_of(entry, target) for entry in view.entries),
        others=tuple(recording_of(other, target) for other in view.others),
    )


def _entry_of(entry: Entry, target: str) -> Entry:
    return replace(entry, table=lambda name: table_of(entry.table(name), target), key="")
