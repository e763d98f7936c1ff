"""What every recording does, whatever its kind."""

import numpy as np

from algorithms.recording import TruthTracks, recording_from_arrays
from tests.chart_views import plots


def tracks() -> TruthTracks:
    found = TruthTracks.of(
        np.array([3.0, 1.0, 2.0, 0.5]),
        np.array([0, 1, 0, 0]),
        np.array([[3, 3, 3], [1, 1, 1], [2, 2, 2], [0, np.nan, 0]], float),
        np.full((4, 3), np.nan),
        ("a", "b"),
    )
    assert found is not None
    return found


def test_true_paths_are_ordered_by_target_and_time_and_complete():
    found = tracks()
    assert found.time_s.tolist() == [2, 3, 1]
    assert found.target.tolist() == [0, 0, 1]
    assert found.points_of(0).tolist() == [0, 1]
    assert found.points_of(1).tolist() == [2]
    assert found.points_of(2).tolist() == []
    assert TruthTracks.of(np.ones(1), np.zeros(1, int), np.full((1, 3), np.nan), np.ones((1, 3)), ("",)) is None


def test_true_paths_go_through_arrays_and_stay_whole_when_rows_are_taken():
    recording = plots(truth_tracks=tracks())
    back = recording_from_arrays(recording.take(np.array([1])).to_arrays())
    assert len(back) == 1
    assert back.truth_tracks is not None
    assert back.truth_tracks.targets == ("a", "b")
    np.testing.assert_array_equal(back.truth_tracks.position_m[:, 0], [2, 3, 1])
    assert recording_from_arrays(plots().to_arrays()).truth_tracks is None
