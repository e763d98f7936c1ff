"""Each thing that can be wrong with a file: its code, its row, and what is still used."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import zipfile

import pyarrow
import pytest

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.reading import ReadLimits


def _zstd(data: bytes) -> bytes:
    return pyarrow.Codec("zstd").compress(data, asbytes=True)


def _zip(*files: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for i, data in enumerate(files):
            archive.writestr(f"day/{i}.csv", data)
    return out.getvalue()


PACKINGS = {"gzip": gzip.compress, "bzip2": bz2.compress, "xz": lzma.compress, "zstd": _zstd, "zip": _zip}
HEADER = "time_s,toa_A_ns,toa_B_ns,altitude_m\n"


def refused(report):
    return [(r.row, r.code) for r in report.rejections]


@pytest.mark.parametrize("data", [b"", b"\n\n", b"\xef\xbb\xbf", b"\xff\xfe", b"  \t \r\n"])
def test_empty_file(read, data):
    with pytest.raises(InputError) as e:
        read(data)
    assert (e.value.code, e.value.pointer) == ("empty_file", "/file")
    assert e.value.remedy


def test_header_only(read):
    with pytest.raises(InputError) as e:
        read(HEADER)
    assert e.value.code == "no_rows"


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (bytes(range(256)) * 40, "not text"),
        (b"%PDF-1.7 rest", "PDF"),
        (b"Rar!rest", "RAR"),
    ],
)
def test_binary_files(read, data, words):
    with pytest.raises(UnsupportedFormatError, match=words) as e:
        read(data)
    assert (e.value.code, e.value.pointer) == ("unsupported_format", "/file")


@pytest.mark.parametrize("text", ["time_s toa_A_ns\n1 2\n", "just words\nand more\n"])
def test_wrong_delimiter(read, text):
    with pytest.raises(UnsupportedFormatError) as e:
        read(text)
    assert e.value.code == "no_columns"


def test_numbers_in_the_first_line(read):
    with pytest.raises(InputError) as e:
        read("1,2,3\n4,5,6\n")
    assert e.value.code == "no_header"


def test_duplicated_column(read):
    with pytest.raises(InputError, match="toa_A_ns") as e:
        read("time_s,toa_A_ns,toa_A_ns\n1,2,3\n")
    assert e.value.code == "duplicate_column"


@pytest.mark.parametrize(
    ("cell", "code"),
    [
        ("abc", "not_a_number"),
        ("1_000", "not_a_number"),
        ("0x10", "not_a_number"),
        ("1 000", "not_a_number"),
        ("1e", "not_a_number"),
        ("12:30", "not_a_number"),
        ("inf", "not_finite"),
        ("-Infinity", "not_finite"),
        ("1e999", "not_finite"),
        ("1e300", "out_of_range"),
        ("1620205606491287123", "out_of_range"),
    ],
)
def test_cells_that_are_no_measurement(read, cell, code):
    recording, report = read(HEADER + f"1,5,6,7\n2,{cell},6,7\n3,5,6,7\n")
    assert refused(report) == [(2, code)]
    assert recording.row.tolist() == [1, 3]
    assert report.rows_read == report.rows_accepted + len(report.rejections) == 3
    assert "toa_A_ns" in report.rejections[0].detail
    assert "line 3" in report.rejections[0].detail
    assert report.rejections[0].file == "file_0.csv"


@pytest.mark.parametrize("word", ["NaN", "nan", "NULL", "N/A", "-"])
def test_words_for_empty(read, warning, word):
    recording, report = read(HEADER + f"1,{word},6,7\n")
    assert warning(report, "word_for_empty").count == 1
    assert recording.toa_s[0, 0, 0] != recording.toa_s[0, 0, 0]


@pytest.mark.parametrize("cell", [" 5", "5 ", "\u22125", "+5", ".5", "5.", "5e0"])
def test_numbers_in_every_dress(read, cell):
    recording, report = read(HEADER + f"1,{cell},6,7\n")
    assert report.rejections == ()
    assert abs(recording.toa_s[0, 0, 0]) in (5 / 1e9, 0.5 / 1e9)


@pytest.mark.parametrize("time", ["", "NaN", "soon"])
def test_a_row_needs_its_time(read, time):
    _, report = read(HEADER + f"{time},5,6,7\n2,5,6,7\n")
    assert refused(report) == [(1, "not_a_number" if time == "soon" else "missing_value")]


def test_rows_without_a_measurement(read):
    _, report = read(HEADER + "1,,,\n2,5,,\n3,,,7\n")
    assert refused(report) == [(1, "empty_row")]


def test_half_a_plot(read):
    _, report = read("time_s,range_m,azimuth_deg\n1,5,\n2,5,6\n")
    assert refused(report) == [(1, "missing_value")]


def test_ragged_rows(read):
    _, report = read(HEADER + "1,5,6\n2,5,6,7\n3,5,6,7,8\n4,5,6,7,,\n")
    assert refused(report) == [(1, "wrong_cell_count"), (3, "wrong_cell_count")]


def test_blank_lines_are_not_rows(read):
    recording, report = read("\n" + HEADER + "1,5,6,7\n\n2,5,x,7\n3,5,6,7\n\n")
    assert recording.row.tolist() == [1, 3]
    assert refused(report) == [(2, "not_a_number")]
    assert "line 5" in report.rejections[0].detail


def test_nul_bytes(read):
    recording, report = read(HEADER + "1,5,6,7\n2,5\0,6,7\n3,5,6,7\n")
    assert refused(report) == [(2, "null_byte")]
    assert recording.row.tolist() == [1, 3]


def test_overlong_line(read):
    recording, report = read(HEADER + "1,5,6,7\n2," + "5" * 200_000 + ",6,7\n3,5,6,7\n")
    assert refused(report) == [(2, "line_too_long")]
    assert recording.row.tolist() == [1, 3]


def test_quoted_newline(read):
    recording, report = read('time_s,toa_A_ns,target\n1,5,"a\nb"\n2,5,c\n3,x,d\n')
    assert recording.targets[0] == "a\nb"
    assert recording.row.tolist() == [1, 2]
    assert refused(report) == [(3, "not_a_number")]
    assert "line 5" in report.rejections[0].detail


def test_an_open_quotation_mark_costs_one_line(read):
    rows = "".join(f"{i},5,t\n" for i in range(2, 60))
    recording, report = read('time_s,toa_A_ns,target\n1,5,"t\n' + rows)
    assert refused(report) == [(1, "unclosed_quote")]
    assert len(recording) == 58


def test_an_open_quotation_mark_near_the_end(read):
    recording, report = read('time_s,toa_A_ns,target\n1,5,t\n2,5,"t\n3,5,t\n')
    assert refused(report) == [(2, "unclosed_quote")]
    assert recording.row.tolist() == [1, 3]


def test_a_quotation_mark_within_a_cell_is_a_character(read):
    recording, report = read('time_s,toa_A_ns,target\n1,5,5" tube\n2,5,t\n')
    assert report.rejections == ()
    assert recording.targets[0] == '5" tube'


def test_identical_rows(read):
    recording, report = read(HEADER + "1,5,6,7\n1,5,6,8\n1,5.0,6,7\n2,5,6,7\n")
    assert refused(report) == [(3, "duplicate_row")]
    assert "row 1" in report.rejections[0].detail
    assert recording.row.tolist() == [1, 2, 4]


def test_identical_rows_of_two_files(read):
    _, report = read(HEADER + "1,5,6,7\n2,5,6,7\n", HEADER + "2,5,6,7\n3,5,6,7\n")
    assert [(r.row, r.code, r.file) for r in report.rejections] == [(3, "duplicate_row", "file_1.csv")]


def test_plots_of_one_time_are_no_duplicates(read):
    _, report = read("time_s,range_m,azimuth_deg\n1,5,6\n1,7,8\n")
    assert report.rejections == ()


def test_descending_times_are_sorted(read, warning):
    recording, report = read(HEADER + "1,5,6,7\n5,5,6,7\n2.5,5,6,7\n3,5,6,7\n6,5,6,7\n")
    assert recording.time_s.tolist() == [1, 2.5, 3, 5, 6]
    assert recording.row.tolist() == [1, 3, 4, 2, 5]
    found = warning(report, "rows_out_of_order")
    assert found.count == 2
    assert "2.5 s" in found.detail


def test_descending_times_rejected(read):
    recording, report = read(HEADER + "1,5,6,7\n5,5,6,7\n2.5,5,6,7\n5,5,6,8\n", order="reject")
    assert refused(report) == [(3, "out_of_order")]
    assert recording.row.tolist() == [1, 2, 4]


def test_files_are_merged_by_time_without_a_warning(read):
    recording, report = read(HEADER + "1,5,6,7\n5,5,6,7\n", HEADER + "2,5,6,7\n")
    assert recording.time_s.tolist() == [1, 2, 5]
    assert recording.row.tolist() == [1, 3, 2]
    assert report.warnings == ()


def test_merged_files_with_other_stations(read):
    recording, _ = read("time_s,toa_A_ns,toa_B_ns,target\n1,5,6,x\n", "time_s,toa_C_ns,toa_B_ns,target\n2,7,8,y\n")
    assert recording.stations == ("A", "B", "C")
    assert (recording.toa_s[1, :, 0] * 1e9)[1:].round(9).tolist() == [8, 7]
    assert recording.targets == ("x", "y")
    assert recording.target.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("second", "code"),
    [
        ("time_s,range_m,azimuth_deg\n1,2,3\n", "mixed_kinds"),
        (HEADER + "1620205606.5,5,6,7\n", "mixed_time_bases"),
    ],
)
def test_files_that_do_not_belong_together(read, second, code):
    with pytest.raises(InputError) as e:
        read(HEADER + "1,5,6,7\n", second)
    assert e.value.code == code


def test_files_with_other_channels(read):
    with pytest.raises(InputError) as e:
        read("time_s,doppler_1_hz\n1,2\n", "time_s,doppler_1_hz,doppler_2_hz\n1,2,3\n")
    assert e.value.code == "mixed_channels"


def test_nothing_usable_says_why(read):
    with pytest.raises(InputError, match="row 1") as e:
        read(HEADER + "a,5,6,7\nb,5,6,7\n")
    assert e.value.code == "no_usable_rows"


def test_of_too_many_rows_the_first_are_read(read, warning):
    recording, report = read(HEADER + "1,5,6,7\nx,5,6,7\n3,5,6,7\n4,5,6,7\n", limits=ReadLimits(max_rows=3))
    assert recording.time_s.tolist() == [1, 3]
    assert (report.rows_read, report.rows_accepted) == (3, 2)
    assert "more than 3 rows" in warning(report, "rows_beyond_limit").detail
    _, whole = read(HEADER + "1,5,6,7\n2,5,6,7\n3,5,6,7\n", limits=ReadLimits(max_rows=3))
    assert whole.warnings == ()


def test_no_file(read):
    with pytest.raises(InputError) as e:
        read()
    assert e.value.code == "no_file"


def test_a_path_in_a_name_is_only_a_label(read):
    for name in ("../../etc/passwd", "C:\\data\\passwd", "/passwd"):
        _, report = read(HEADER + "1,5,6,7\nx,5,6,7\n", names=(name,))
        assert report.rejections[0].file == "passwd"


def test_gzip(read):
    recording, _ = read(gzip.compress((HEADER + "1,5,6,7\n").encode()))
    assert len(recording) == 1


def test_damaged_gzip(read):
    with pytest.raises(InputError) as e:
        read(gzip.compress((HEADER + "1,5,6,7\n" * 1000).encode())[:-20])
    assert e.value.code == "damaged_archive"


@pytest.mark.parametrize("packing", PACKINGS)
def test_every_packing(read, packing):
    recording, _ = read(PACKINGS[packing]((HEADER + "1,5,6,7\n").encode()))
    assert len(recording) == 1


@pytest.mark.parametrize("packing", PACKINGS)
def test_packed_files_that_are_cut_off(read, packing):
    whole = PACKINGS[packing]((HEADER + "".join(f"{i},{i * 7919 % 1000},6,7\n" for i in range(3000))).encode())
    with pytest.raises(InputError) as e:
        read(whole[: len(whole) // 2])
    assert e.value.code == "damaged_archive"


@pytest.mark.parametrize("packing", PACKINGS)
def test_packed_files_that_grow_too_much(read, packing):
    data = PACKINGS[packing](HEADER.encode() + b"1,5,6,7\n" * 300_000)
    with pytest.raises(InputError) as e:
        read(data, limits=ReadLimits(max_expanded_bytes=1 << 20))
    assert e.value.code == "expands_too_much"


def test_a_zip_is_a_folder_of_files(read):
    recording, report = read(_zip(HEADER.encode() + b"1,5,6,7\n", b"time_s,toa_A_ns,toa_B_ns\n0.5,1,2\nx,1,2\n"))
    assert recording.time_s.tolist() == [0.5, 1.0]
    assert [(r.row, r.file) for r in report.rejections] == [(3, "1.csv")]


def test_a_zip_that_lies_about_the_size_of_what_it_holds(read):
    data = bytearray(_zip(HEADER.encode() + b"1,5,6,7\n" * 3_000_000))
    central = data.rindex(b"PK\x01\x02")
    data[central + 24 : central + 28] = (100).to_bytes(4, "little")
    with pytest.raises(InputError) as e:
        read(bytes(data))
    assert e.value.code == "damaged_archive"


def test_archives_that_are_no_recording(read):
    for members, code in (({}, "archive_members"), ({"[Content_Types].xml": b"<x/>"}, "unsupported_format")):
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w") as archive:
            for name, data in members.items():
                archive.writestr(name, data)
            archive.writestr("folder/", b"")
        with pytest.raises(InputError) as e:
            read(out.getvalue())
        assert e.value.code == code


def test_a_gzip_that_grows_too_much(read):
    data = gzip.compress(HEADER.encode() + b"1,5,6,7\n" * 4_000_000)
    with pytest.raises(InputError) as e:
        read(data)
    assert e.value.code == "expands_too_much"
    with pytest.raises(InputError) as e:
        read(gzip.compress(HEADER.encode() * 100), limits=ReadLimits(max_expanded_bytes=1000))
    assert e.value.code == "expands_too_much"


def test_bytes_in_no_encoding(read):
    # 0x98 is no character of Windows-1251.
    with pytest.raises(InputError) as e:
        read(HEADER.encode() + b"1,5,6,\x98\xff\n")
    assert e.value.code == "encoding"


def test_an_endless_first_line(read):
    with pytest.raises(UnsupportedFormatError) as e:
        read("time_s," + ",".join(f"toa_{i}_ns" for i in range(20_000)) + "\n")
    assert e.value.code == "no_columns"
