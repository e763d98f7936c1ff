"""Whatever bytes come in, the answer is a recording with every row accounted for, or an error made for the user."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from algorithms.errors import InputError
from algorithms.recording import Recording
from backend.files.reading import NamedFile, ReadOptions, ReadReport, read_recording

MARKS = b"time_s,toa_A_ns,toa_B_ns,altitude_m,target\n" + b"".join(
    b"%d.5,%d,%d.25,9000,T%d\n" % (i, 100 * i, 50 * i, i % 3) for i in range(12)
)
LOCARDS = b"aircraft,latitude,longitude,baroAltitude,geoAltitude,measurements\n" + b"".join(
    b'%d,48.%d,9.1,9000,8900,"[[10,%d,5],[11,%d,6]]"\n' % (i, i, 10**9 * i + 10**10, 10**9 * i + 10**10 + 7)
    for i in range(12)
)
PLOTS = "time_s;range_m;azimuth_deg;callsign\n" + "".join(f"{i},5;{1000 + i};{i},25;Борт{i}\n" for i in range(12))
SEEDS = st.sampled_from([MARKS, LOCARDS, PLOTS.encode(), PLOTS.encode("cp1251"), PLOTS.encode("utf-16")])
BITES = st.sampled_from([b"\0", b'"', b"\n", b"\r", b",", b";", b"\xff", b"\xd0", b"nan", b"1e999", b"[[", b"-", b" "])


@st.composite
def spoiled(draw: st.DrawFn) -> bytes:
    """A good file with bytes put in, taken out and written over."""
    data = bytearray(draw(SEEDS))
    for _ in range(draw(st.integers(1, 6))):
        place = draw(st.integers(0, len(data)))
        length = draw(st.integers(0, 8))
        data[place : place + length] = draw(BITES)
    return bytes(data)


def attempt(data: bytes, *, site: bytes | None = None, **options: object) -> tuple[Recording, ReadReport] | InputError:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "upload"
        path.write_bytes(data)
        try:
            return read_recording([NamedFile("upload", path)], site=site, options=ReadOptions(**options))
        except InputError as e:
            return e


def check(data: bytes, **options: object) -> None:
    found = attempt(data, **options)
    if isinstance(found, InputError):
        assert found.message
        assert found.code
        assert found.remedy
        assert found.pointer.startswith("/")
        return
    recording, report = found
    assert report.rows_read == report.rows_accepted + len(report.rejections)
    assert report.rows_accepted == len(recording) > 0
    rows = [*recording.row.tolist(), *(r.row for r in report.rejections)]
    assert len(set(rows)) == len(rows)
    assert np.isfinite(recording.time_s).all()
    assert (np.diff(recording.time_s) >= 0).all()
    for array in recording.to_arrays().values():
        assert array.dtype.kind != "f" or not np.isinf(array).any()


@settings(deadline=None, derandomize=True, max_examples=300)
@given(spoiled())
def test_spoiled_files(data):
    check(data)


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.binary(max_size=400))
def test_any_bytes(data):
    check(data)


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.binary(max_size=200), st.sampled_from(["toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"]))
def test_any_bytes_below_a_header(data, kind):
    check(
        b"time_s,toa_A_ns,range_m,azimuth_deg,bicone_elevation_deg,bicone_azimuth_deg,doppler_1_hz\n" + data, kind=kind
    )


@settings(deadline=None, derandomize=True, max_examples=100)
@given(spoiled(), st.sampled_from([b"serial,latitude,longitude,height\n", b'{"stations": [']), st.binary(max_size=80))
def test_any_site(data, start, rest):
    check(data, site=start + rest)
