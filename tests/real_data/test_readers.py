"""The readers on real recordings (see ../shared/data/README.md); nothing here is tuned to their numbers."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from algorithms.recording import PolarPlots, ToaMarks
from backend.files.native_csv_writer import write_native_csv
from backend.files.reading import NamedFile, ReadOptions, read_recording
from backend.files.truth_tracks import TruthTrack

DATA = Path(__file__).resolve().parents[2].parent / "shared" / "data"
LOCARDS, JOYRIDE, AUTOFERRY = DATA / "multilateration_locards", DATA / "radar_joyride", DATA / "radar_autoferry"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the real recordings (../shared/data) are not here")


def files(folder: Path, *names: str) -> list[NamedFile]:
    return [NamedFile(n, folder / n) for n in names]


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def locards():
    return read_recording(files(LOCARDS, "set_1.csv", "set_2.csv"), site=(LOCARDS / "sensors.csv").read_bytes())


def test_locards_is_read_whole(locards):
    recording, report = locards
    assert isinstance(recording, ToaMarks)
    assert (report.format, report.rows_read, report.rows_accepted, report.rejections) == ("locards_csv", 660, 660, ())
    assert len(recording.stations) == len(recording.site.stations) == 27
    assert len(recording.targets) == 225
    assert (np.isfinite(recording.toa_s).sum(axis=(1, 2)) == 5).all()
    assert [w.code for w in report.warnings] == ["pressure_altitude"]
    assert (np.diff(recording.time_s) >= 0).all()
    assert sorted(recording.row) == list(range(1, 661))


def test_locards_times_are_the_stamps_of_the_file(locards):
    """Every reception, from the JSON of the file and in integers."""
    recording, _ = locards
    rows = [r for n in ("set_1.csv", "set_2.csv") for r in rows_of(LOCARDS / n)]
    for i in range(0, len(recording), 13):
        row = rows[recording.row[i] - 1]
        assert recording.targets[recording.target[i]] == row["aircraft"]
        gate_ns = round(recording.time_s[i] * 1000) * 1_000_000
        for serial, stamp, _ in json.loads(row["measurements"]):
            toa_s = recording.toa_s[i, recording.stations.index(str(serial)), 0]
            assert round(toa_s * 1e9) + gate_ns == stamp
            assert 0 < toa_s < 0.01


def test_locards_truth_explains_the_times(locards):
    """Truth, stations and times agree: the residuals are nanoseconds and not the light time between stations."""
    recording, _ = locards
    assert recording.has_truth
    range_m = np.linalg.norm(recording.truth_m[:, None] - recording.site.station_positions()[None], axis=2)
    residual_m = recording.toa_s[:, :, 0] * 299_792_458.0 - range_m
    residual_m -= np.nanmedian(residual_m, axis=1, keepdims=True)
    assert np.nanmedian(np.abs(residual_m)) < 60
    assert np.nanpercentile(np.abs(residual_m), 90) < 500


def test_locards_without_a_site_and_again_with_the_site_json(locards):
    with_table, _ = locards
    without, report = read_recording(files(LOCARDS, "set_1.csv", "set_2.csv"))
    assert report.rows_accepted == 660
    assert without.site is None
    assert "truth_without_origin" in [w.code for w in report.warnings]
    site = json.dumps(with_table.site.to_json()).encode()
    again, _ = read_recording(files(LOCARDS, "set_1.csv", "set_2.csv"), site=site)
    assert again.site == with_table.site
    np.testing.assert_array_equal(again.toa_s, with_table.toa_s)
    np.testing.assert_array_equal(again.truth_m, with_table.truth_m)


def test_locards_as_native_csv_and_back(locards, tmp_path):
    recording, _ = locards
    path = tmp_path / "native.csv"
    with path.open("w", newline="") as stream:
        write_native_csv(recording, stream)
    site = json.dumps(recording.site.to_json()).encode()
    back, report = read_recording([NamedFile("native.csv", path)], site=site)
    assert report.rejections == ()
    assert back.stations == recording.stations
    np.testing.assert_array_equal(back.time_s, recording.time_s)
    np.testing.assert_allclose(back.toa_s, recording.toa_s, rtol=5e-16)
    np.testing.assert_array_equal(back.truth_m, recording.truth_m)


def test_joyride_plots_by_mapping():
    options = ReadOptions(mapping={"time_s": "t_s"})
    recording, report = read_recording(files(JOYRIDE, "joyride_plots.csv"), options=options)
    assert isinstance(recording, PolarPlots)
    assert (report.rows_read, report.rows_accepted) == (432, 432)
    assert len(np.unique(recording.scan)) <= 238
    assert recording.north_m[0, 0] == 7114.88427734375


def test_joyride_truth_by_mapping():
    options = ReadOptions(
        mapping={"time_s": "t_s"},
        truth_mapping={
            "time_s": "t_s",
            "true_east_m": "tgt_east_m",
            "true_north_m": "tgt_north_m",
            "true_velocity_east_mps": "tgt_ve",
            "true_velocity_north_mps": "tgt_vn",
        },
    )
    truth = NamedFile("joyride_truth.csv", JOYRIDE / "joyride_truth.csv")
    recording, report = read_recording(files(JOYRIDE, "joyride_plots.csv"), truth=truth, options=options)
    codes = {w.code for w in report.warnings}
    assert "truth_up_zero" in codes
    known = np.isfinite(recording.truth_m).all(axis=1)
    assert known.mean() > 0.9
    plot = np.concatenate([recording.east_m, recording.north_m], axis=1)
    distance = np.linalg.norm(plot[known] - recording.truth_m[known, :2], axis=1)
    # About half of the plots are other vessels; those of the boat lie within tens of metres.
    assert (distance < 50).mean() > 0.3
    assert np.isfinite(recording.truth_velocity_mps[known, :2]).all()


AUTOFERRY_MAPPING = {
    "time_s": {"column": "t", "unit": "epoch"},
    "east_m": {"column": "east_m", "minus": "own_east_m"},
    "north_m": {"column": "north_m", "minus": "own_north_m"},
    "radar_east_m": "own_east_m",
    "radar_north_m": "own_north_m",
}


def test_autoferry_plots_relative_to_the_moving_radar():
    options = ReadOptions(mapping=AUTOFERRY_MAPPING, where={"scenario": "scenario16"})
    recording, report = read_recording(files(AUTOFERRY, "plots.csv"), options=options)
    rows = rows_of(AUTOFERRY / "plots.csv")
    assert report.rows_read == sum(r["scenario"] == "scenario16" for r in rows)
    assert report.rows_accepted == report.rows_read
    assert recording.start_utc == "2021-05-05T09:06:46Z"
    source = [rows[i - 1] for i in recording.row]
    np.testing.assert_allclose(
        recording.east_m[:, 0] + recording.radar_east_m, [float(r["east_m"]) for r in source], atol=1e-9
    )
    np.testing.assert_allclose(
        recording.north_m[:, 0] + recording.radar_north_m, [float(r["north_m"]) for r in source], atol=1e-9
    )


def autoferry(scenario: str, **options):
    return ReadOptions(
        mapping=AUTOFERRY_MAPPING,
        truth_mapping={
            "time_s": {"column": "t", "unit": "epoch"},
            "true_east_m": "east_m",
            "true_north_m": "north_m",
        },
        where={"scenario": scenario},
        **options,
    )


def test_autoferry_truth_of_two_targets_belongs_to_no_single_plot():
    truth = NamedFile("truth.csv", AUTOFERRY / "truth.csv")
    recording, report = read_recording(files(AUTOFERRY, "plots.csv"), truth=truth, options=autoferry("scenario16"))
    assert not recording.has_truth
    assert "truth_not_assigned" in [w.code for w in report.warnings]


@pytest.mark.parametrize("scenario", ["scenario16", "scenario2", "scenario4"])
def test_autoferry_truth_is_a_scan_late_and_moving_it_moves_the_estimate(scenario):
    """The plots of a scan carry one time; they fit the truth of about a scan (1.68 s) before it best."""
    truth = NamedFile("truth.csv", AUTOFERRY / "truth.csv")
    told = []
    for applied in (0.0, 5.0):
        options = autoferry(scenario, truth_shift_s=applied)
        _, report = read_recording(files(AUTOFERRY, "plots.csv"), truth=truth, options=options)
        detail = next(w.detail for w in report.warnings if w.code == "truth_time_shift")
        told.append(float(detail.split("truth_shift_s = ")[1].split(" ")[0]))
    assert 1.2 < told[0] < 2.5
    assert told[1] == pytest.approx(told[0], abs=0.05)


@pytest.mark.parametrize("scenario", ["scenario16", "scenario5", "scenario6"])
def test_autoferry_truth_between_its_own_rows(scenario):
    """Every second row of each target, interpolated at the times of the others."""
    rows = [r for r in rows_of(AUTOFERRY / "truth.csv") if r["scenario"] == scenario]
    for target in ("1", "2"):
        own = np.array([[float(r[c]) for c in ("t", "east_m", "north_m")] for r in rows if r["target"] == target])
        position = np.column_stack([own[:, 1:], np.zeros(len(own))])
        even = TruthTrack.of(own[::2, 0], position[::2], np.full((len(own[::2]), 3), np.nan), np.arange(len(own[::2])))
        inner = own[1:-1:2]
        error = even.at(inner[:, 0]).position_m[:, :2] - inner[:, 1:]
        assert np.isfinite(error).all()
        assert np.median(np.hypot(*error.T)) < 0.5


def test_autoferry_truth_positions_are_read_per_target():
    """The truth file itself as a recording of plots: both targets, every row."""
    mapping = {"time_s": {"column": "t", "unit": "epoch"}}
    recording, report = read_recording(files(AUTOFERRY, "truth.csv"), options=ReadOptions(mapping=mapping))
    assert set(recording.targets) == {"1", "2"}
    assert report.rows_accepted + len(report.rejections) == report.rows_read
    assert {r.code for r in report.rejections} <= {"duplicate_row"}
