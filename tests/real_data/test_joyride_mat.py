"""The MATLAB file of a marine radar, with its object array of plots per scan, holds what its CSV files hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from algorithms.recording import PolarPlots
from backend.files.preview import preview
from backend.files.reading import NamedFile, ReadOptions, read_recording

TIME = {"column": "time", "unit": "epoch"}
OPTIONS = ReadOptions(
    mapping={"time_s": TIME, "north_m": "measurements_1", "east_m": "measurements_2"},
    truth_mapping={"time_s": TIME, "true_north_m": "target_1", "true_east_m": "target_3"},
)


def test_plots_and_truth_of_one_file(shared_data: Path) -> None:
    folder = shared_data / "radar_joyride"
    file = NamedFile("joyride.mat", folder / "joyride.mat")
    recording, report = read_recording([file], truth=file, options=OPTIONS)
    plots = np.genfromtxt(folder / "joyride_plots.csv", delimiter=",", names=True)
    assert isinstance(recording, PolarPlots)
    assert (report.format, report.rejections, len(recording)) == ("matlab", (), len(plots))
    np.testing.assert_array_equal(recording.scan, plots["scan"])
    np.testing.assert_array_equal(recording.north_m[:, 0], plots["north_m"])
    np.testing.assert_array_equal(recording.east_m[:, 0], plots["east_m"])
    # The CSV counts scans of 2.512 s, the original has the radar's clock.
    np.testing.assert_allclose(recording.time_s - recording.time_s[0], plots["t_s"], atol=1e-3)
    truth = np.genfromtxt(folder / "joyride_truth.csv", delimiter=",", names=True)
    assert recording.truth_tracks is not None
    np.testing.assert_array_equal(recording.truth_tracks.position_m[:, 1], truth["tgt_north_m"])
    np.testing.assert_array_equal(recording.truth_tracks.position_m[:, 0], truth["tgt_east_m"])


def test_a_look_shows_the_columns_of_every_table(shared_data: Path) -> None:
    file = NamedFile("joyride.mat", shared_data / "radar_joyride" / "joyride.mat")
    seen = preview([file])
    assert {"measurements_1", "measurements_2", "target_4", "time", "scan"} <= set(seen.columns)
    assert seen.error is not None  # nothing is guessed
    mapped = preview([file], options=OPTIONS)
    assert mapped.report is not None
    assert mapped.report.rows_accepted == 432
    assert mapped.rows[0][mapped.columns.index("measurements_1")].startswith("7114.88")
