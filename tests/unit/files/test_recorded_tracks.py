"""Tracks of a file become points to follow: chosen, parted at pauses, thinned, cleaned."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from algorithms.errors import InputError
from backend.errors import NotFoundError
from backend.files.options import ReadLimits, ReadOptions
from backend.files.reading import NamedFile, read_recording
from backend.files.recorded_tracks import RecordedTracks, TrackChoice, read_tracks
from backend.files.recording_writer import write_truth
from backend.files.report import Findings

HEADER = "time_s,target,true_latitude_deg,true_longitude_deg,true_height_m\n"


def tracks_of(folder: Path, text: str, limits: ReadLimits | None = None, **choice: Any) -> RecordedTracks:
    path = folder / "tracks.csv"
    path.write_text(text, encoding="utf-8")
    return read_tracks(
        NamedFile("tracks.csv", path), ReadOptions(), limits or ReadLimits(), TrackChoice(**choice), Findings()
    )


def rows(name: str, times: list[float], latitude: float = 55.0) -> str:
    return "".join(f"{t},{name},{latitude + 1e-3 * i},37,{1000 + i}\n" for i, t in enumerate(times))


def test_points_are_reports_at_least_so_far_apart(tmp_path: Path) -> None:
    found = tracks_of(tmp_path, HEADER + rows("A", [100.5 + 4 * i for i in range(11)]), spacing_s=10)
    (track,) = found.tracks
    # Counted from the whole second before the first; the last report is always one of the points.
    assert track.time_s.tolist() == [0.5, 12.5, 24.5, 36.5, 40.5]
    assert track.place[1].tolist() == pytest.approx([55.003, 37, 1003])
    assert (track.is_geodetic, track.reports, track.left_out, found.start_utc) == (True, 11, {}, None)


def test_a_pause_parts_a_track_and_the_longest_are_taken(tmp_path: Path) -> None:
    text = HEADER + rows("A", [0, 5, 500, 505, 510]) + rows("B", [0, 30]) + rows("C", [7])
    every = tracks_of(tmp_path, text, spacing_s=0)
    assert [(t.name, t.reports) for t in every.tracks] == [("A", 2), ("A (2)", 3), ("B", 2)]
    assert [t.name for t in tracks_of(tmp_path, text, most_targets=1).tracks] == ["B"]
    assert [t.name for t in tracks_of(tmp_path, text, targets=["A"]).tracks] == ["A", "A (2)"]
    assert [t.name for t in tracks_of(tmp_path, text, first_s=100).tracks] == ["A"]
    assert every.found == 3


def test_what_cannot_be_a_path_is_left_out_and_counted(tmp_path: Path) -> None:
    # The third report repeats an instant; the fourth is 1100 km away within a second.
    text = HEADER + "0,A,55,37,0\n10,A,55.01,37,0\n10,A,55.02,37,5\n11,A,65,37,0\n20,A,55.03,37,0\n"
    (track,) = tracks_of(tmp_path, text, spacing_s=0).tracks
    assert track.time_s.tolist() == [0, 10, 20]
    assert track.left_out == {"same_time": 1, "jump": 1}


def test_positions_of_a_local_frame_stay_there(tmp_path: Path) -> None:
    text = "time_s,true_east_m,true_north_m,true_up_m\n0,0,0,100\n10,2000,0,100\n"
    (track,) = tracks_of(tmp_path, text).tracks
    assert (track.name, track.is_geodetic) == ("1", False)
    assert track.place.tolist() == [[0, 0, 100], [2000, 0, 100]]


def test_a_long_track_is_followed_less_closely(tmp_path: Path) -> None:
    text = "time_s,true_east_m,true_north_m,true_up_m\n" + "".join(f"{t},{t},0,1\n" for t in range(5000))
    (track,) = tracks_of(tmp_path, text, spacing_s=0).tracks
    assert 1500 < len(track.time_s) <= 2000


@pytest.mark.parametrize(
    ("text", "choice", "code", "pointer"),
    [
        (HEADER + rows("A", [0, 5]), {"targets": ["A", "Z"]}, "track_unknown", "/options/tracks/targets/1"),
        (HEADER + rows("A", [0]), {}, "no_tracks", "/file"),
        (HEADER + rows("A", [0, 5]), {"first_s": 50, "last_s": 60}, "no_tracks", "/file"),
        ("time_s,range_m,azimuth_deg\n0,1,2\n", {}, "missing_column", "/file"),
        (HEADER + "a,b,c,d,e\n", {}, "no_usable_rows", "/file"),
    ],
)
def test_what_holds_no_tracks_says_so(
    tmp_path: Path, text: str, choice: dict[str, Any], code: str, pointer: str
) -> None:
    with pytest.raises(InputError) as e:
        tracks_of(tmp_path, text, **choice)
    assert (e.value.code, e.value.pointer) == (code, pointer)


def test_a_window_goes_forwards() -> None:
    with pytest.raises(ValueError, match="last_s must be later"):
        TrackChoice(first_s=5, last_s=5)


def test_a_recording_without_paths_has_none_to_write(tmp_path: Path) -> None:
    path = tmp_path / "plots.csv"
    path.write_text("time_s,range_m,azimuth_deg\n0,1000,45\n", encoding="utf-8")
    recording, _ = read_recording([NamedFile("plots.csv", path)])
    with pytest.raises(NotFoundError) as e:
        write_truth(recording, tmp_path / "truth.csv", "csv")
    assert e.value.code == "no_true_paths"
    assert not (tmp_path / "truth.csv").exists()
