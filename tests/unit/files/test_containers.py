"""Parquet, MATLAB and NumPy files of the forms that users have, and of forms that cannot serve."""

from __future__ import annotations

import io

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io

from algorithms.errors import InputError, UnsupportedFormatError
from algorithms.recording import PolarPlots
from backend.files.reading import ReadLimits

TIME = np.array([0.5, 1.0, 2.5])
RANGE = np.array([1000.0, 2000.0, 3000.0])
AZIMUTH = np.array([10.0, 20.0, 350.0])
NATIVE = {"time_s": TIME, "range_m": RANGE, "azimuth_deg": AZIMUTH}
# Plots per scan: two, none, one.
PLOTS = [np.array([[10.0, 1.0], [20.0, 2.0]]), np.empty((0, 0)), np.array([[30.0, 3.0]])]
SCAN_MAPPING = {"time_s": "time", "north_m": "plots_1", "east_m": "plots_2"}


def parquet(columns, **options) -> bytes:
    out = io.BytesIO()
    pq.write_table(pa.table(columns), out, **options)
    return out.getvalue()


def mat5(variables, **options) -> bytes:
    out = io.BytesIO()
    scipy.io.savemat(out, variables, **options)
    return out.getvalue()


def npz(**arrays) -> bytes:
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


def cells(*values) -> np.ndarray:
    out = np.empty((len(values), 1), object)
    for i, value in enumerate(values):
        out[i, 0] = value
    return out


class Mat73:
    """Writes HDF5 as MATLAB does: axes reversed, texts as 16-bit characters, cells as references."""

    def __init__(self) -> None:
        self.out = io.BytesIO()
        self.file = h5py.File(self.out, "w", userblock_size=512)
        self.refs = self.file.create_group("#refs#")

    def add(self, name, value, group=None, **options):
        group = self.file if group is None else group
        if isinstance(value, dict):
            made = group.create_group(name)
            made.attrs["MATLAB_class"] = np.bytes_("struct")
            for field, item in value.items():
                self.add(field, item, made)
            return made
        if isinstance(value, str):
            data, kind = np.array([[ord(c)] for c in value], np.uint16), "char"
        elif isinstance(value, list):
            refs = [self.add(f"{name}_{i}_{len(self.refs)}", v, self.refs).ref for i, v in enumerate(value)]
            data, kind = np.array([refs], h5py.ref_dtype), "cell"
        else:
            data, kind = np.atleast_2d(value).T, "double"
        if isinstance(value, np.ndarray) and not value.size:
            made = group.create_dataset(name, data=np.array([0, 0], np.uint64))
            made.attrs["MATLAB_empty"] = np.uint8(1)
        else:
            made = group.create_dataset(name, data=data, **options)
        made.attrs["MATLAB_class"] = np.bytes_(kind)
        return made

    def done(self) -> bytes:
        self.file.close()
        data = bytearray(self.out.getvalue())
        text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64"
        data[: len(text)] = text
        return bytes(data)


def mat73(variables) -> bytes:
    file = Mat73()
    for name, value in variables.items():
        file.add(name, value)
    return file.done()


def assert_native(recording):
    assert isinstance(recording, PolarPlots)
    assert recording.time_s.tolist() == TIME.tolist()
    assert recording.range_m[:, 0].tolist() == RANGE.tolist()
    np.testing.assert_allclose(np.degrees(recording.azimuth_rad[:, 0]), AZIMUTH, rtol=1e-15)


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (parquet(NATIVE), "parquet"),
        (mat5(NATIVE), "matlab"),
        (mat5({"plots": NATIVE}, do_compression=True), "matlab"),
        (mat73(NATIVE), "matlab73"),
        (mat73({"plots": NATIVE}), "matlab73"),
        (npz(**NATIVE), "numpy"),
    ],
    ids=["parquet", "mat", "mat struct", "mat 7.3", "mat 7.3 struct", "npz"],
)
def test_native_columns(read, data, name):
    recording, report = read(data)
    assert_native(recording)
    assert (report.format, report.rows_read, report.warnings) == (name, 3, ())


def test_an_array_of_structs_is_a_row_each(read):
    fields = [("time_s", "O"), ("range_m", "O"), ("azimuth_deg", "O"), ("target", "O")]
    rows = [(t, r, a, n) for t, r, a, n in zip(TIME, RANGE, AZIMUTH, ("one", "two", "one"), strict=True)]
    recording, _ = read(mat5({"plots": np.array(rows, fields)}))
    assert_native(recording)
    assert [recording.targets[i] for i in recording.target] == ["one", "two", "one"]


@pytest.mark.parametrize("names", [("one", "two"), ()], ids=["texts", "none"])
def test_whole_numbers_beside_their_texts(read, names):
    codes = np.array([0.0, 2.0, 1.0]) if names else np.zeros(3)
    recording, report = read(mat5({"plots": {**NATIVE, "callsign": codes, "callsign_names": cells(*names)}}))
    assert [recording.callsigns[i] if i >= 0 else None for i in recording.callsign] == [
        names[int(c) - 1] if c else None for c in codes
    ]
    assert report.warnings == ()


def test_named_fields_of_a_npy(read):
    out = io.BytesIO()
    fields = [("time_s", "f8"), ("range_m", "f4"), ("azimuth_deg", "i2")]
    np.save(out, np.array(list(zip(TIME, RANGE, AZIMUTH, strict=True)), fields))
    assert_native(read(out.getvalue())[0])


@pytest.mark.parametrize("write", [mat5, mat73], ids=["mat", "mat 7.3"])
def test_a_matrix_is_mapped_by_the_numbers_of_its_columns(read, write):
    matrix = np.stack([TIME * 1000, RANGE, AZIMUTH], axis=1)
    mapping = {"time_s": {"column": "m_1", "unit": "ms"}, "range_m": "m_2", "azimuth_deg": "m_3"}
    assert_native(read(write({"m": matrix}), mapping=mapping)[0])


@pytest.mark.parametrize("write", [mat5, mat73], ids=["mat", "mat 7.3"])
def test_an_object_array_of_plots_per_scan(read, warning, write):
    plots = cells(*PLOTS) if write is mat5 else PLOTS
    truth = np.arange(12.0).reshape(3, 4)
    data = write({"plots": plots, "time": TIME, "target": truth, "note": np.ones((2, 2, 2)) if write is mat5 else "x"})
    recording, report = read(data, mapping=SCAN_MAPPING)
    assert recording.time_s.tolist() == [0.5, 0.5, 2.5]
    assert recording.scan.tolist() == [0, 0, 2]
    assert recording.north_m[:, 0].tolist() == [10, 20, 30]
    assert recording.east_m[:, 0].tolist() == [1, 2, 3]
    assert "target_1" in warning(report, "columns_ignored").detail
    if write is mat5:
        assert "note" in warning(report, "variables_left_out").detail


def test_the_same_file_gives_the_truth_of_its_scans(read):
    data = mat5({"plots": cells(*PLOTS), "time": TIME, "target": np.arange(12.0).reshape(3, 4)})
    truth = {"time_s": "time", "true_north_m": "target_1", "true_east_m": "target_3"}
    recording, _ = read(data, truth=data, mapping=SCAN_MAPPING, truth_mapping=truth)
    assert recording.truth_m[:, 1].tolist() == [0, 0, 8]


def test_texts_of_parquet_and_its_dates(read):
    import datetime

    start = datetime.datetime(2026, 3, 1, 12, tzinfo=datetime.UTC)
    when = [start, start + datetime.timedelta(milliseconds=250), None]
    recording, report = read(
        parquet(
            {
                "when": pa.array(when, pa.timestamp("us", tz="Europe/Moscow")),
                "toa_A_ns": pa.array([1, 2, 3], pa.int32()),
                "target": pa.array(["x", None, "y"]).dictionary_encode(),
                "nested": pa.array([[1], [2], [3]]),
            }
        ),
        mapping={"time_s": {"column": "when", "unit": "date"}},
    )
    assert recording.start_utc == "2026-03-01T12:00:00Z"
    assert recording.time_s.tolist() == [0.0, 0.25]
    assert [recording.targets[i] for i in recording.target] == ["x", ""]
    assert [(r.row, r.code, r.detail) for r in report.rejections] == [(3, "missing_value", "column 'when' is empty")]
    assert [w.code for w in report.warnings] == ["columns_nested"]


def test_a_filter_works_on_numbers_and_texts(read):
    data = parquet({**NATIVE, "scenario": ["a", "b", "a"], "site": [1, 1, 2]})
    assert read(data, where={"scenario": "a"})[0].time_s.tolist() == [0.5, 2.5]
    assert read(data, where={"scenario": "a", "site": 2})[0].time_s.tolist() == [2.5]


def test_an_infinite_number_costs_its_row(read):
    _, report = read(npz(**{**NATIVE, "range_m": np.array([1.0, np.inf, 3.0])}))
    assert [(r.row, r.code) for r in report.rejections] == [(2, "not_finite")]


@pytest.mark.parametrize(
    "data",
    [
        mat5({"f": np.array([[1.0]])}),
        mat5({"c": cells(np.ones((2, 2)), "text")}),
        mat73({"a": np.ones((1, 1))}),
        npz(a=np.ones((2, 2, 2))),
        parquet({"nested": pa.array([[1], [2]])}),
    ],
    ids=["scalar", "mixed cells", "mat 7.3 scalar", "three axes", "nested"],
)
def test_files_without_a_table(read, data):
    with pytest.raises(InputError) as e:
        read(data)
    assert (e.value.code, e.value.pointer) == ("no_table", "/file")


def test_objects_are_left_out_and_named(read, warning):
    out = io.BytesIO()
    np.savez(out, **NATIVE, objects=np.array([{"a": 1}, None, 3], object))
    recording, report = read(out.getvalue())
    assert_native(recording)
    assert "objects" in warning(report, "variables_left_out").detail


def test_links_out_of_the_file_are_not_followed(read, warning, tmp_path):
    secret = tmp_path / "secret"
    secret.write_bytes(b"12345678" * 3)
    file = Mat73()
    for name, value in NATIVE.items():
        file.add(name, value)
    file.file.create_dataset("outside", (3,), "f8", external=[(str(secret), 0, 24)])
    file.file["soft"] = h5py.ExternalLink(str(secret), "/x")
    _, report = read(file.done())
    assert "outside" in warning(report, "variables_left_out").detail
    assert "soft" in warning(report, "variables_left_out").detail


@pytest.mark.parametrize("data", [parquet(NATIVE), mat5(NATIVE), mat73(NATIVE), npz(**NATIVE)], ids=list("pm7n"))
def test_files_that_are_cut_off(read, data):
    for length in (len(data) // 3, len(data) - 40):
        with pytest.raises(InputError) as e:
            read(data[:length])
        assert e.value.code in ("damaged_file", "damaged_archive", "no_table", "unsupported_format")
        # What a library says is put in one sentence of ours, or the Russian page could not say it.
        if e.value.code == "damaged_file":
            assert e.value.message.count(". ") == 0
            assert not e.value.message.endswith("..")


def test_small_files_that_unpack_to_much(read):
    zeros = np.zeros(400_000)
    file = Mat73()
    file.add("a", zeros, compression="gzip", chunks=True)
    for data in (
        mat5({"a": zeros}, do_compression=True),
        file.done(),
        npz(a=zeros),
        parquet({"a": zeros}, use_dictionary=False, compression="gzip"),
    ):
        with pytest.raises(InputError) as e:
            read(data, limits=ReadLimits(max_expanded_bytes=1 << 20))
        assert e.value.code == "expands_too_much"


def test_of_too_many_rows_the_first_are_read_and_the_rest_counted(read, warning):
    file = Mat73()
    for name, values in NATIVE.items():
        file.add(name, values)
    for data in (parquet(NATIVE, row_group_size=1), npz(**NATIVE), mat5(NATIVE), file.done()):
        recording, report = read(data, limits=ReadLimits(max_rows=1))
        assert recording.time_s.tolist() == TIME.tolist()[:1]
        beyond = warning(report, "rows_beyond_limit")
        assert "has 3 rows; only the first 1 of them were read, 2 were left out" in beyond.detail
        assert beyond.count == 2


def test_rows_of_scans_are_counted_too(read, warning):
    data = mat5({"plots": cells(*PLOTS), "time": TIME})
    _, report = read(data, mapping=SCAN_MAPPING, limits=ReadLimits(max_rows=2))
    beyond = warning(report, "rows_beyond_limit")
    assert ("has 3 rows" in beyond.detail, beyond.count) == (True, 1)


def test_a_column_that_is_there_twice(read):
    table = pa.Table.from_arrays([pa.array([1.0]), pa.array([2.0])], names=["time_s", "time_s"])
    out = io.BytesIO()
    pq.write_table(table, out)
    with pytest.raises(InputError) as e:
        read(out.getvalue())
    assert e.value.code == "duplicate_column"


def test_columns_that_nothing_maps(read):
    with pytest.raises(UnsupportedFormatError, match="rho"):
        read(npz(t=TIME, rho=RANGE, theta=AZIMUTH))
