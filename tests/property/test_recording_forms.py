"""What is written in any form is read back as the same recording, whatever the numbers and the names."""

from __future__ import annotations

import math
import string
from dataclasses import fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from algorithms.recording import AntennaPlots, DopplerPairs, PolarPlots, Recording, ToaMarks, TruthTracks
from algorithms.site import Site
from backend.files.native_csv_writer import write_native_csv
from backend.files.reading import NamedFile, read_recording
from backend.files.recording_writer import RecordingForm, write_recording, write_truth

# Names as users write them: separators, quotes and line ends included. White space around a name means nothing.
NAME = st.text(string.ascii_letters + "0123456789 ,;\"'|\n.-_=Яж中", min_size=1, max_size=12).filter(
    lambda s: s == s.strip()
)


def numbers(low: float, high: float, *, empty: bool = True) -> st.SearchStrategy[float]:
    values = st.floats(low, high, allow_nan=False, allow_subnormal=False)
    return st.one_of(values, st.just(math.nan)) if empty else values


def column(m: int, values: st.SearchStrategy[float]) -> st.SearchStrategy[np.ndarray]:
    return st.lists(values, min_size=m, max_size=m).map(lambda v: np.array(v, float))


def codes(m: int, low: int, names: int) -> st.SearchStrategy[np.ndarray]:
    return st.lists(st.integers(low, names - 1), min_size=m, max_size=m).map(lambda v: np.array(v, np.int64))


@st.composite
def common(draw: st.DrawFn, m: int) -> dict:
    times = draw(st.lists(st.floats(-1e5, 1e8, allow_subnormal=False), min_size=m, max_size=m, unique=True))
    targets = tuple(draw(st.lists(NAME, min_size=1, max_size=3, unique=True)))
    out = {
        "time_s": np.sort(np.array(times)),
        "row": np.arange(1, m + 1),
        "target": draw(codes(m, 0, len(targets))),
        "targets": targets,
    }
    if draw(st.booleans()):
        position = numbers(-1e8, 1e8, empty=False)
        out["truth_m"] = np.stack([draw(column(m, position)) for _ in range(3)], axis=1)
        out["truth_velocity_mps"] = np.stack([draw(column(m, numbers(-1e4, 1e4))) for _ in range(3)], axis=1)
    return out


@st.composite
def toa_marks(draw: st.DrawFn) -> ToaMarks:
    m = draw(st.integers(1, 6))
    stations = tuple(draw(st.lists(NAME, min_size=1, max_size=4, unique=True)))
    types = tuple(draw(st.lists(NAME, max_size=2, unique=True)))
    toa = np.stack([draw(column(m, numbers(-9.0, 9.0))) for _ in stations], axis=1)
    altitude = draw(column(m, numbers(-1e3, 1e5, empty=False)))
    return ToaMarks(
        **draw(common(m)),
        toa_s=toa[:, :, None],
        altitude_m=altitude[:, None],
        stations=stations,
        emitter_type=draw(codes(m, -1, len(types))),
        emitter_types=types,
    )


@st.composite
def polar_plots(draw: st.DrawFn) -> PolarPlots:
    m = draw(st.integers(1, 6))
    radars, addresses, callsigns, modes_3a = (
        tuple(draw(st.lists(NAME, min_size=1, max_size=3, unique=True))) for _ in range(4)
    )
    position = numbers(-1e8, 1e8)
    return PolarPlots(
        **draw(common(m)),
        range_m=draw(column(m, numbers(0, 1e8, empty=False)))[:, None],
        azimuth_rad=draw(column(m, numbers(-6.28, 6.28, empty=False)))[:, None],
        elevation_rad=draw(column(m, numbers(-1.57, 1.57)))[:, None],
        altitude_m=draw(column(m, numbers(-1e3, 1e5)))[:, None],
        east_m=draw(column(m, position))[:, None],
        north_m=draw(column(m, position))[:, None],
        radar=draw(codes(m, 0, len(radars))),
        radars=radars,
        radar_east_m=draw(column(m, position)),
        radar_north_m=draw(column(m, position)),
        scan=np.array(draw(st.lists(st.integers(-1, 10**12), min_size=m, max_size=m))),
        address=draw(codes(m, -1, len(addresses))),
        addresses=addresses,
        callsign=draw(codes(m, -1, len(callsigns))),
        callsigns=callsigns,
        mode_3a=draw(codes(m, -1, len(modes_3a))),
        modes_3a=modes_3a,
    )


@st.composite
def antenna_plots(draw: st.DrawFn) -> AntennaPlots:
    m = draw(st.integers(1, 6))
    angle = numbers(-3.14, 3.14, empty=False)
    return AntennaPlots(
        **draw(common(m)),
        range_m=draw(column(m, numbers(0, 1e8, empty=False)))[:, None],
        bicone_elevation_rad=draw(column(m, angle))[:, None],
        bicone_azimuth_rad=draw(column(m, angle))[:, None],
    )


@st.composite
def doppler_pairs(draw: st.DrawFn) -> DopplerPairs:
    m = draw(st.integers(1, 6))
    channels = draw(st.sampled_from([("1",), ("1", "2"), ("11", "12", "21", "22")]))
    frequency = numbers(-1e9, 1e9)
    doppler = np.stack([draw(column(m, numbers(-1e9, 1e9, empty=c != channels[0]))) for c in channels], axis=1)
    rate = np.stack([draw(column(m, frequency)) for _ in range(2)], axis=1)
    return DopplerPairs(
        **draw(common(m)),
        doppler_hz=doppler[:, :, None],
        doppler_rate_hz_s=rate[:, :, None],
        azimuth_rad=draw(column(m, numbers(-6.28, 6.28)))[:, None],
        elevation_rad=draw(column(m, numbers(-1.57, 1.57)))[:, None],
        channels=channels,
    )


def written_and_read(recording: Recording, form: RecordingForm = "csv") -> Recording:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "recording"
        write_recording(recording, path, form)
        back, report = read_recording([NamedFile("recording", path)])
    assert report.rejections == ()
    return back


# One kind converts by a factor, so that writing and reading each round once.
_UNITS_DIFFER = {"toa_s", "azimuth_rad", "elevation_rad", "bicone_elevation_rad", "bicone_azimuth_rad"}
_NAMES = {
    "target": "targets",
    "emitter_type": "emitter_types",
    "radar": "radars",
    "address": "addresses",
    "callsign": "callsigns",
    "mode_3a": "modes_3a",
}


def assert_same(back: Recording, recording: Recording) -> None:
    assert back.kind == recording.kind
    for field in fields(recording):
        before, after = getattr(recording, field.name), getattr(back, field.name)
        if field.name in _NAMES:
            # Codes are numbered as the names are met; what they name must be the same.
            names_before, names_after = getattr(recording, _NAMES[field.name]), getattr(back, _NAMES[field.name])
            assert [names_after[c] if c >= 0 else None for c in after] == [
                names_before[c] if c >= 0 else None for c in before
            ]
        elif isinstance(before, np.ndarray):
            rtol = 5e-16 if field.name in _UNITS_DIFFER else 0
            np.testing.assert_allclose(after, before, rtol=rtol, atol=0, err_msg=field.name)
        elif field.name not in _NAMES.values():
            assert after == before


@settings(deadline=None, derandomize=True, max_examples=60)
@given(st.one_of(toa_marks(), polar_plots(), antenna_plots(), doppler_pairs()))
def test_round_trip(recording):
    assert_same(written_and_read(recording), recording)


@pytest.mark.parametrize("form", ["parquet", "mat", "npz"])
@settings(deadline=None, derandomize=True, max_examples=30)
@given(recording=st.one_of(toa_marks(), polar_plots(), antenna_plots(), doppler_pairs()), start=st.booleans())
def test_round_trip_of_binary_forms(form, recording, start):
    recording = replace(recording, start_utc="2026-03-01T12:00:00Z" if start else None)
    assert_same(written_and_read(recording, form), recording)


@st.composite
def true_paths(draw: st.DrawFn) -> TruthTracks:
    targets = tuple(draw(st.lists(NAME, min_size=1, max_size=3, unique=True)))
    m = draw(st.integers(len(targets), 8))
    times = np.array(draw(st.lists(st.floats(-1e5, 1e8, allow_subnormal=False), min_size=m, max_size=m, unique=True)))
    # Every target has a point: one without any is not in a file.
    target = np.arange(m) % len(targets)
    found = TruthTracks.of(
        time_s=times,
        target=target,
        position_m=np.stack([draw(column(m, numbers(-1e8, 1e8, empty=False))) for _ in range(3)], axis=1),
        velocity_mps=np.stack([draw(column(m, numbers(-1e4, 1e4))) for _ in range(3)], axis=1),
        targets=targets,
    )
    assert found is not None
    return found


@pytest.mark.parametrize("form", ["csv", "parquet", "mat", "npz"])
@settings(deadline=None, derandomize=True, max_examples=20)
@given(paths=true_paths(), dated=st.booleans())
def test_round_trip_of_true_paths(form, paths, dated):
    """Rows and paths written apart and read together: the paths are whole, wherever the rows lie."""
    time = np.array([0.25])
    recording = AntennaPlots(
        time_s=time,
        row=np.array([1]),
        target=np.zeros(1, np.int64),
        range_m=np.ones((1, 1)),
        bicone_elevation_rad=np.zeros((1, 1)),
        bicone_azimuth_rad=np.zeros((1, 1)),
        truth_tracks=paths,
        start_utc="2026-03-01T12:00:00Z" if dated and form != "csv" else None,
    )
    with TemporaryDirectory() as folder:
        data, truth = Path(folder) / "data", Path(folder) / "truth"
        write_recording(recording, data, form)
        write_truth(recording, truth, form)
        back, _ = read_recording([NamedFile("data", data)], truth=NamedFile("truth", truth))
    assert back.start_utc == recording.start_utc
    found = back.truth_tracks
    assert found is not None
    names = [paths.targets[k] for k in paths.target]
    order = {name: k for k, name in enumerate(found.targets)}
    assert sorted(order) == sorted(paths.targets)
    for name in paths.targets:
        mine, theirs = np.array([n == name for n in names]), found.target == order[name]
        np.testing.assert_array_equal(found.time_s[theirs], paths.time_s[mine])
        np.testing.assert_array_equal(found.position_m[theirs], paths.position_m[mine])
        np.testing.assert_array_equal(found.velocity_mps[theirs], paths.velocity_mps[mine])


@pytest.mark.parametrize("form", ["csv", "parquet", "mat"])
def test_data_site_and_truth_give_the_same_recording_again(form, tmp_path):
    """A moving radar, truth at other times than the plots: interpolated once, the same is interpolated again."""
    (tmp_path / "plots.csv").write_text(
        "time_s,range_m,azimuth_deg,target,radar_east_m,radar_north_m\n1.5,1000,45,A,0,0\n4.5,1100,46,A,10,5\n"
    )
    truth = "".join(f"{t},A,{700 + 10.1 * t * t},{710 - t},{100 + t / 3}\n" for t in range(7))
    (tmp_path / "truth.csv").write_text(f"time_s,target,true_east_m,true_north_m,true_up_m\n{truth}")
    site = Site.model_validate({"radars": [{"name": "ship", "east_m": 0, "north_m": 0, "sigma_range_m": 5}]})
    site_json = site.model_dump_json(exclude_none=True).encode()

    def read(data, paths):
        return read_recording([NamedFile("data", data)], site=site_json, truth=NamedFile("truth", paths))[0]

    first = read(tmp_path / "plots.csv", tmp_path / "truth.csv")
    assert np.isfinite(first.truth_m).all()
    write_recording(first, tmp_path / "data", form)
    write_truth(first, tmp_path / "paths", form)
    again = read(tmp_path / "data", tmp_path / "paths")
    assert_same(replace(again, truth_tracks=None), replace(first, truth_tracks=None))
    assert again.truth_tracks is not None
    assert first.truth_tracks is not None
    np.testing.assert_array_equal(again.truth_tracks.position_m, first.truth_tracks.position_m)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(st.decimals(-(10**9), 10**9, places=3, allow_nan=False, allow_infinity=False))
def test_a_decimal_of_the_file_is_written_as_it_was(nanoseconds):
    text = f"time_s,toa_A_ns\n1.0,{nanoseconds}\n"
    with TemporaryDirectory() as folder:
        path = Path(folder) / "recording.csv"
        path.write_text(text)
        recording, _ = read_recording([NamedFile("recording.csv", path)])
        with path.open("w", newline="") as stream:
            write_native_csv(recording, stream)
        assert float(path.read_text().splitlines()[1].split(",")[1]) == float(nanoseconds)
