"""Files whose variables have the wrong shape, and tables that are far too wide: short errors that name the cause."""

from __future__ import annotations

import csv
import io
import time

import numpy as np
import pytest
import scipy.io
from scipy.io.matlab import MatlabObject

from algorithms.errors import InputError
from algorithms.recording import PolarPlots
from backend.files.native_csv_writer import write_native_csv
from tests.unit.files.test_containers import cells, mat5

TIME = np.array([0.0, 1.0, 2.0])
SCANS = {"time_s": "time", "north_m": "plots_1", "east_m": "plots_2"}


@pytest.mark.parametrize(
    ("plots", "words"),
    [
        (cells(np.ones((2, 2)), np.ones((1, 3)), np.ones((3, 2))), "plots (3 cells: 1 x 3, 2 x 2, 3 x 2)"),
        (cells(np.ones((2, 5)), np.ones((2, 4)), np.ones((2, 3))), "plots (3 cells: 2 x 3, 2 x 4, 2 x 5)"),
        (cells(np.ones((2, 2, 2)), np.ones((1, 2)), np.ones((3, 2))), "plots (3 cells: 1 x 2, 3 x 2, other)"),
        (np.ones((3, 2, 4)), "plots (3 x 2 x 4 float64)"),
    ],
    ids=["widths differ", "transposed", "three axes in a cell", "three axes"],
)
def test_plots_of_the_wrong_shape_are_named_with_their_shape(read, plots, words):
    with pytest.raises(InputError) as e:
        read(mat5({"plots": plots, "time": TIME}), mapping=SCANS, kind="polar_plots")
    assert e.value.code == "missing_column"
    assert words in e.value.message


def test_times_that_do_not_belong_to_the_scans(read):
    plots = cells(np.ones((2, 2)), np.ones((1, 2)), np.ones((3, 2)))
    with pytest.raises(InputError) as e:
        read(mat5({"plots": plots, "time": TIME[:2]}), mapping=SCANS, kind="polar_plots")
    assert "'time'; the columns are scan, plots_1, plots_2. These variables are no columns" in e.value.message


def test_an_object_of_a_class_is_its_fields_and_nothing_is_called(read):
    fields = np.zeros((1, 1), dtype=[("note", object), ("shape", object)])
    fields[0, 0]["note"], fields[0, 0]["shape"] = np.ones(5), np.ones((2, 2, 2))
    native = {"time_s": TIME, "range_m": TIME + 1, "azimuth_deg": TIME}
    recording, report = read(mat5({"thing": MatlabObject(fields, "myclass"), **native}))
    assert len(recording) == 3
    (left_out,) = [w for w in report.warnings if w.code == "variables_left_out"]
    assert left_out.detail.endswith("note, thing.shape (2 x 2 x 2 float64).")


def test_complex_numbers_are_refused_not_halved(read):
    with pytest.raises(InputError) as e:
        read(mat5({"time_s": TIME, "range_m": TIME + 1j, "azimuth_deg": TIME}))
    assert (e.value.code, e.value.pointer) == ("complex_numbers", "/file")


def test_a_sparse_matrix_is_no_column(read):
    out = io.BytesIO()
    scipy.io.savemat(out, {"time_s": TIME, "range_m": scipy.sparse.csc_matrix(np.ones((3, 1))), "azimuth_deg": TIME})
    with pytest.raises(InputError) as e:
        read(out.getvalue())
    assert "range_m (object)" in e.value.message


WIDE = [f"c{i}" for i in range(10_000)]


def wide(names: list[str], first: list[str], rows: int = 100) -> bytes:
    lines = [",".join([*names, *WIDE])]
    lines += [",".join([str(k), *first, *["1"] * len(WIDE)]) for k in range(rows)]
    return "\n".join(lines).encode()


def test_ten_thousand_columns_that_nothing_reads(read):
    began = time.process_time()
    recording, report = read(wide(["time_s", "range_m", "azimuth_deg"], ["1000", "45"]))
    assert len(recording) == 100
    assert {w.code: w.count for w in report.warnings} == {"columns_ignored": 10_000}
    assert all(len(w.detail) < 300 for w in report.warnings)
    # A million cells; bounded, whatever else the machine does.
    assert time.process_time() - began < 20


def test_ten_thousand_columns_that_mean_nothing(read):
    with pytest.raises(InputError) as e:
        read(wide(["t", "r", "a"], ["1000", "45"]))
    assert e.value.code == "unsupported_format"
    assert "9995 more" in e.value.message
    assert len(e.value.message) < 300


def test_a_formula_among_the_names_is_escaped_and_read_back(read):
    text = 'time_s,range_m,azimuth_deg,callsign\n0,1000,45,=1+1\n1,1000,45,"=HYPERLINK(""x"")"\n'
    recording, _ = read(text.encode())
    out = io.StringIO()
    write_native_csv(recording, out)
    cell = [row[-1] for row in csv.reader(io.StringIO(out.getvalue()))]
    assert cell == ["callsign", "'=1+1", '\'=HYPERLINK("x")']
    again, _ = read(out.getvalue().encode())
    assert isinstance(again, PolarPlots)
    assert [again.callsigns[c] for c in again.callsign] == ["=1+1", '=HYPERLINK("x")']
