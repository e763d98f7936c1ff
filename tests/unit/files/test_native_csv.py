from __future__ import annotations

import numpy as np
import pytest

from algorithms.errors import InputError, UnsupportedFormatError
from algorithms.recording import AntennaPlots, DopplerPairs, PolarPlots, ToaMarks

MARKS = "time_s,toa_A_ns,toa_B_ns,altitude_m,target,emitter_type\n0.5,100.25,2e3,9000,T1,S\n1.5,,300,,T2,\n"


def test_toa_marks_in_si_units(read):
    recording, report = read(MARKS)
    assert isinstance(recording, ToaMarks)
    assert (report.kind, report.format, report.rows_read, report.rows_accepted) == ("toa_marks", "native_csv", 2, 2)
    assert report.rejections == ()
    assert report.warnings == ()
    assert recording.stations == ("A", "B")
    np.testing.assert_array_equal(recording.toa_s[:, :, 0], [[100.25 / 1e9, 2e-6], [np.nan, 3e-7]])
    np.testing.assert_array_equal(recording.altitude_m[:, 0], [9000, np.nan])
    assert recording.targets == ("T1", "T2")
    assert recording.target.tolist() == [0, 1]
    assert recording.emitter_types == ("S",)
    assert recording.emitter_type.tolist() == [0, -1]
    assert recording.row.tolist() == [1, 2]
    assert report.time_span_s == (0.5, 1.5)


def test_polar_plots(read):
    recording, _ = read(
        "time_s,range_m,azimuth_deg,radar,scan,elevation_deg,callsign\n1,1000,90,N,4,45,KLM\n2,5,180,S,,,\n"
    )
    assert isinstance(recording, PolarPlots)
    np.testing.assert_allclose(recording.azimuth_rad[:, 0], [np.pi / 2, np.pi])
    np.testing.assert_allclose(recording.elevation_rad[:, 0], [np.pi / 4, np.nan])
    assert recording.radars == ("N", "S")
    assert recording.scan.tolist() == [4, -1]
    assert recording.callsign.tolist() == [0, -1]


def test_cartesian_plots_and_a_moving_radar(read):
    recording, _ = read("time_s,east_m,north_m,radar_east_m,radar_north_m\n1,10,20,-5,7\n")
    assert recording.kind == "polar_plots"
    assert np.isnan(recording.range_m).all()
    assert (recording.east_m[0, 0], recording.radar_east_m[0], recording.radar_north_m[0]) == (10, -5, 7)


def test_antenna_plots(read):
    recording, _ = read("time_s,range_m,bicone_elevation_deg,bicone_azimuth_deg\n1,1000,1.5,-2\n")
    assert isinstance(recording, AntennaPlots)
    np.testing.assert_allclose(recording.bicone_azimuth_rad, np.radians([[-2]]))


@pytest.mark.parametrize("channels", [("1",), ("1", "2"), ("11", "12", "21", "22")])
def test_doppler_pairs(read, channels):
    names = ",".join(f"doppler_{c}_hz" for c in channels)
    recording, _ = read(f"time_s,{names},doppler_rate_1_hz_s\n1,{','.join('5' for _ in channels)},-0.5\n")
    assert isinstance(recording, DopplerPairs)
    assert recording.channels == channels
    assert recording.doppler_hz.shape == (1, len(channels), 1)
    np.testing.assert_array_equal(recording.doppler_rate_hz_s[0, :, 0], [-0.5, np.nan])


@pytest.mark.parametrize("names", ["doppler_1_hz,doppler_11_hz", "doppler_11_hz,doppler_12_hz,doppler_21_hz"])
def test_incomplete_doppler_channels(read, names):
    with pytest.raises(InputError) as e:
        read(f"time_s,{names}\n1,1,1,1\n")
    assert e.value.code == "doppler_channels"


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_delimiters_and_line_ends(read, delimiter, line_end):
    recording, report = read(MARKS.replace(",", delimiter).replace("\n", line_end))
    assert report.rows_accepted == 2
    assert recording.toa_s[0, 0, 0] == 100.25 / 1e9


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_comma(read, delimiter):
    recording, report = read(MARKS.replace(",", delimiter).replace(".", ","))
    assert recording.toa_s[0, 0, 0] == 100.25 / 1e9
    assert report.warnings == ()


def test_mixed_decimal_marks(read, warning):
    recording, report = read("time_s;toa_A_ns;toa_B_ns\n1;1,5;2.5\n2;1,25;2\n")
    assert warning(report, "mixed_decimal_marks").count == 2
    assert recording.toa_s[0, :, 0].tolist() == [1.5 / 1e9, 2.5 / 1e9]


def test_thousands_are_not_guessed(read):
    _, report = read("time_s;toa_A_ns\n1;1.234,5\n2;5\n")
    assert [(r.row, r.code) for r in report.rejections] == [(1, "not_a_number")]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1251"])
def test_encodings(read, encoding):
    text = "time_s,toa_Север_ns,toa_B_ns,target\n1,5,6,Борт-1\n2,6,7,Борт-2\n"
    recording, report = read(text.encode(encoding))
    assert recording.stations == ("Север", "B")
    assert recording.targets == ("Борт-1", "Борт-2")
    assert [w.code for w in report.warnings] == (["encoding_guessed"] if encoding == "cp1251" else [])


def test_excel_separator_line(read):
    _, report = read("sep=;\n" + MARKS.replace(",", ";"))
    assert report.rows_accepted == 2


def test_commas_in_names_and_numbers_are_no_delimiters(read):
    notes = "Note, first, a;Note, second, b;Note, third, c;Note, fourth, d"
    _, report = read(f"time_s;toa_A_ns;toa_B_ns;altitude_m;{notes}\n0,5;100,25;2000,0;9000,5;a;b;c;d\n")
    assert report.rows_accepted == 1


def test_in_file_truth_local(read):
    recording, _ = read("time_s,toa_A_ns,true_east_m,true_north_m,true_up_m\n1,5,1,2,3\n2,6,,,\n")
    assert recording.has_truth
    np.testing.assert_array_equal(recording.truth_m, [[1, 2, 3], [np.nan] * 3])


def test_in_file_truth_wgs84(read):
    text = "time_s,toa_A_ns,true_latitude_deg,true_longitude_deg,true_height_m\n1,5,50,30.001,100\n"
    recording, _ = read(text, origin={"latitude_deg": 50, "longitude_deg": 30})
    # One thousandth of a degree of longitude at 50 degrees north: 71.7 m.
    np.testing.assert_allclose(recording.truth_m, [[71.697, 0.0, 100.0]], atol=1e-2)


def test_wgs84_truth_without_an_origin_is_kept_out_and_said(read, warning):
    text = "time_s,toa_A_ns,true_latitude_deg,true_longitude_deg,true_height_m\n1,5,50,30.001,100\n"
    recording, report = read(text)
    assert not recording.has_truth
    assert warning(report, "truth_without_origin").count == 1


def test_incomplete_truth(read, warning):
    recording, report = read("time_s,toa_A_ns,true_east_m,true_north_m,true_up_m\n1,5,1,,3\n2,6,1,2,3\n")
    assert warning(report, "truth_incomplete").count == 1
    assert np.isnan(recording.truth_m[0]).all()


def test_truth_columns_that_are_missing(read):
    with pytest.raises(InputError, match="true_up_m") as e:
        read("time_s,toa_A_ns,true_east_m,true_north_m\n1,5,1,2\n")
    assert e.value.code == "missing_column"


def test_plane_truth_lies_at_zero(read, warning):
    recording, report = read("time_s,range_m,azimuth_deg,true_east_m,true_north_m\n1,5,1,2,3\n")
    assert warning(report, "truth_up_zero").count == 1
    assert recording.truth_m.tolist() == [[2, 3, 0]]


def test_truth_twice(read):
    with pytest.raises(InputError) as e:
        read("time_s,toa_A_ns,true_east_m,true_latitude_deg\n1,5,1,2\n")
    assert e.value.code == "truth_twice"


def test_ignored_columns_are_named(read, warning):
    _, report = read("time_s,toa_A_ns,remark,\n1,5,hello,\n")
    assert "remark" in warning(report, "columns_ignored").detail


def test_missing_time_column_suggests_the_misspelt_one(read):
    with pytest.raises(InputError, match="'Time_s' looks like 'time_s'") as e:
        read("Time_s,toa_A_ns\n1,5\n")
    assert (e.value.code, e.value.pointer) == ("missing_column", "/options/mapping")


def test_unknown_columns_ask_for_a_mapping(read):
    with pytest.raises(UnsupportedFormatError, match="foo, bar") as e:
        read("foo,bar\n1,2\n")
    assert e.value.pointer == "/options/mapping"


def test_two_kinds_in_one_file_ask_for_the_kind(read):
    text = "time_s,range_m,azimuth_deg,doppler_1_hz\n1,2,3,4\n"
    with pytest.raises(InputError) as e:
        read(text)
    assert (e.value.code, e.value.pointer) == ("kind_ambiguous", "/options/kind")
    assert read(text, kind="doppler_pairs")[0].kind == "doppler_pairs"


def test_format_option(read):
    with pytest.raises(InputError) as e:
        read(MARKS, format="strange")
    assert (e.value.code, e.value.pointer) == ("format_unknown", "/options/format")
    assert read(MARKS, format="native_csv")[1].rows_accepted == 2


def test_edition_is_of_no_use_here(read, warning):
    _, report = read(MARKS, edition="1.2")
    warning(report, "option_ignored")


TWICE = "time_s,doppler_1_hz,doppler_2_hz,azimuth_deg\n0,5,,359\n0,,6,\n1,4,5,\n1,4.5,,10\n1,5,9,12\n2,3,4,1\n"


def test_rows_of_one_instant_become_one(read):
    """Those of two receivers complete each other; a second value of the same receiver is rejected with its reason."""
    recording, report = read(TWICE)
    assert recording.time_s.tolist() == [0, 1, 2]
    assert recording.row.tolist() == [1, 3, 6]
    assert recording.doppler_hz[:, :, 0].tolist() == [[5, 6], [4, 5], [3, 4]]
    assert np.degrees(recording.azimuth_rad[0, 0]) % 360 == pytest.approx(359)
    assert np.isnan(recording.azimuth_rad[1, 0])
    assert [(r.row, r.code) for r in report.rejections] == [
        (2, "joined_row"),
        (4, "second_doppler"),
        (5, "second_doppler"),
    ]
    assert (report.rows_read, report.rows_accepted) == (6, 3)


def test_dopplers_of_one_instant_are_averaged_on_request(read, warning):
    recording, report = read(TWICE, equal_times="average")
    assert recording.doppler_hz[:, :, 0].tolist() == [[5, 6], [4.5, 7], [3, 4]]
    assert np.degrees(recording.azimuth_rad[1, 0]) == pytest.approx(11)
    assert [(r.row, r.code) for r in report.rejections] == [
        (2, "joined_row"),
        (4, "averaged_row"),
        (5, "averaged_row"),
    ]
    assert warning(report, "dopplers_averaged").count == 2
    around = "time_s,doppler_1_hz,azimuth_deg\n0,5,359\n0,7,3\n"
    assert np.degrees(read(around, equal_times="average")[0].azimuth_rad[0, 0]) == pytest.approx(1)


def test_targets_have_instants_of_their_own(read):
    recording, report = read("time_s,doppler_1_hz,doppler_2_hz,target\n0,5,6,A\n0,7,8,B\n1,5,6,A\n")
    assert len(recording) == 3
    assert report.rejections == ()


def test_files_of_two_receivers_become_pairs(read):
    one = "time_s,doppler_1_hz,doppler_2_hz\n0,5,\n1,4,\n2,3,\n"
    other = "time_s,doppler_1_hz,doppler_2_hz\n1,,5\n2,,4\n3,,3\n"
    recording, report = read(one, other)
    assert recording.time_s.tolist() == [0, 1, 2, 3]
    assert np.nan_to_num(recording.doppler_hz[:, :, 0]).tolist() == [[5, 0], [4, 5], [3, 4], [0, 3]]
    assert [r.row for r in report.rejections] == [4, 5]
