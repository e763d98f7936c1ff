import numpy as np
import pytest

from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions, RecordingView
from tests.chart_views import complete_run, marks, plots

RUN = charts("run")["receptions"].draw
RECORDING = charts("recording")["receptions"].draw


def test_the_raster_is_the_share_of_marks_by_station_and_bin(traces_of) -> None:
    recording = marks(1200)
    recording.toa_s[:50, 0] = np.nan
    recording.toa_s[25:50, 1] = np.nan
    drawn = RECORDING(RecordingView(recording), ChartOptions())
    raster = next(t for t in drawn["data"] if t["type"] == "heatmap")
    assert raster["y"] == ["west", "east", "north", "middle"]
    assert raster["z"].shape == (4, 24)
    np.testing.assert_allclose(raster["z"][:, 0], [0, 50, 98, 100])
    assert raster["x"].tolist() == (50.0 * np.arange(25)).tolist()


def test_bins_without_marks_are_empty_not_zero() -> None:
    time = np.concatenate([np.arange(100.0), np.arange(900.0, 1000.0)])
    drawn = RECORDING(RecordingView(marks(200, time_s=time)), ChartOptions())
    raster = next(t for t in drawn["data"] if t["type"] == "heatmap")
    assert np.isnan(raster["z"][:, 5]).all()
    bars = [t for t in drawn["data"] if t["type"] == "bar"]
    assert all(np.isnan(t["y"][5]) for t in bars)


def test_shares_by_number_of_receptions_add_up(traces_of) -> None:
    recording = marks(1200)
    recording.toa_s[:10, :2] = np.nan
    recording.toa_s[10:12, :3] = np.nan
    drawn = RECORDING(RecordingView(recording), ChartOptions())
    bars = {t["name"]: t for t in drawn["data"] if t["type"] == "bar"}
    assert list(bars) == ["complete (4 receptions)", "3 receptions", "2 receptions", "fewer than 2"]
    # The second mark of the example lacks one station more.
    first = [bars[name]["y"][0] for name in bars]
    assert first == pytest.approx([76, 0, 18, 6])
    assert [int(bars[name]["text"][0]) for name in bars] == [38, 0, 9, 3]


def test_many_stations_share_a_group_for_the_overdetermined() -> None:
    recording = marks(20, site=None, toa_s=np.full((20, 7, 1), 1e-4), stations=tuple(f"s{i}" for i in range(7)))
    drawn = RECORDING(RecordingView(recording), ChartOptions())
    names = [t["name"] for t in drawn["data"] if t["type"] == "bar"]
    assert names == ["5 or more receptions", "4 receptions", "3 receptions", "2 receptions", "fewer than 2"]
    assert next(t for t in drawn["data"] if t["type"] == "bar")["y"][0] == 100


def test_a_run_adds_the_share_that_each_entry_used(traces_of) -> None:
    recording = marks(1200)
    used = ["west" if i % 4 else None for i in range(1200)]
    (share,) = traces_of(RUN(complete_run(recording, used=used), ChartOptions()), "series")
    assert share["meta"]["label"] == "a"
    np.testing.assert_allclose(share["y"], 75, atol=1)


def test_other_kinds_have_no_receptions() -> None:
    drawn = RECORDING(RecordingView(plots()), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "other_kind"
