from __future__ import annotations

from datetime import date

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.errors import InputError
from backend.files.reading import ReadOptions

HEADER = "time_s,toa_A_ns,toa_B_ns\n"


def test_epoch_seconds_count_from_the_first_whole_second(read, warning):
    recording, report = read(HEADER + "1620205606.25,5,6\n1620205608.5,5,6\n")
    assert recording.start_utc == "2021-05-05T09:06:46Z"
    assert recording.time_s.tolist() == [0.25, 2.5]
    warning(report, "epoch_time")


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_epoch_in_smaller_units(read, warning, unit, factor):
    recording, report = read(HEADER + f"{1620205606.25 * factor:.0f},5,6\n{1620205608.5 * factor:.0f},5,6\n")
    assert recording.start_utc == "2021-05-05T09:06:46Z"
    np.testing.assert_allclose(recording.time_s, [0.25, 2.5], atol=3e-7)
    assert f"as {unit} of" in warning(report, "epoch_time").detail


@pytest.mark.parametrize("zone", ["", "Z", "+00:00"])
def test_dates(read, zone):
    recording, report = read(HEADER + f"2021-05-05T09:06:46.25{zone},5,6\n2021-05-05 09:06:48.5{zone},5,6\nsoon,5,6\n")
    assert recording.start_utc == "2021-05-05T09:06:46Z"
    np.testing.assert_allclose(recording.time_s, [0.25, 2.5], atol=3e-7)
    assert [(r.row, r.code) for r in report.rejections] == [(3, "not_a_date")]


def test_days_of_matlab(read):
    """MATLAB counts days from the year 0, Python's ordinal from the year 1, which is 366 days later."""
    day = date(2021, 5, 5).toordinal() + 366
    rows = "".join(f"{day + seconds / 86_400!r};5\n" for seconds in (32_806.25, 32_808.5))
    mapping = {"time_s": {"column": "when", "unit": "datenum"}, "toa_A_ns": "A"}
    recording, report = read("when;A\n" + rows, kind="toa_marks", mapping=mapping)
    assert recording.start_utc == "2021-05-05T09:06:46Z"
    np.testing.assert_allclose(recording.time_s, [0.25, 2.5], atol=1e-5)
    assert report.rejections == ()


def test_start_utc_of_the_user(read):
    recording, _ = read(HEADER + "1,5,6\n", start_utc="2021-05-05T12:06:46+03:00")
    assert (recording.start_utc, recording.time_s.tolist()) == ("2021-05-05T09:06:46Z", [1])
    recording, _ = read(HEADER + "1620205606.25,5,6\n", start_utc="2021-05-05T09:06:40Z")
    assert (recording.start_utc, recording.time_s.tolist()) == ("2021-05-05T09:06:40Z", [6.25])


def test_start_utc_must_be_a_date():
    with pytest.raises(ValidationError, match="2026-03-01T12:00:00Z"):
        ReadOptions(start_utc="yesterday")


def test_a_relative_time_among_epoch_times(read):
    recording, report = read(HEADER + "1620205606.25,5,6\n7,5,6\n1620205608.5,5,6\n")
    assert [(r.row, r.code) for r in report.rejections] == [(2, "out_of_range")]
    assert recording.row.tolist() == [1, 3]


def test_epochs_of_two_files_are_brought_together(read):
    recording, _ = read(HEADER + "1620205606.5,5,6\n", HEADER + "1620205600.25,5,6\n")
    assert recording.start_utc == "2021-05-05T09:06:40Z"
    assert recording.time_s.tolist() == [0.25, 6.5]
    assert recording.row.tolist() == [2, 1]


def test_whole_times_far_apart_look_like_milliseconds(read, warning):
    rows = "".join(f"{i * 500},5,6\n" for i in range(10))
    _, report = read(HEADER + rows)
    warning(report, "time_unit_suspect")
    _, report = read(HEADER + rows, mapping={"time_s": {"column": "time_s", "unit": "ms"}})
    assert report.warnings == ()
    assert report.time_span_s == (0, 4.5)


def test_whole_seconds_are_not_suspected(read):
    _, report = read(HEADER + "".join(f"{i},5,6\n" for i in range(10)))
    assert report.warnings == ()


@pytest.mark.parametrize(("step", "suspect"), [(1000, True), (25, True), (7, False)])
def test_altitudes_in_feet(read, step, suspect):
    rows = "".join(f"{i},5,6,{step * (30000 // step + i)}\n" for i in range(10))
    _, report = read("time_s,toa_A_ns,toa_B_ns,altitude_m\n" + rows)
    assert ("altitude_unit_suspect" in [w.code for w in report.warnings]) is suspect


@pytest.mark.parametrize(
    ("first", "last", "suspect"),
    [(0.0, 6.28, True), (-3.14, 3.14, True), (0.0, 359.0, False), (20.0, 26.0, False), (1.0, 5.0, False)],
)
def test_azimuths_in_radians(read, first, last, suspect):
    rows = "".join(f"{i * 0.05},{20_000 + 10 * i},{first + (last - first) * i / 99}\n" for i in range(100))
    _, report = read("time_s,range_m,azimuth_deg\n" + rows)
    assert ("azimuth_unit_suspect" in [w.code for w in report.warnings]) is suspect
    # As what they are they raise no suspicion.
    if suspect:
        _, report = read(
            "time_s,range_m,azimuth_deg\n" + rows, mapping={"azimuth_deg": {"column": "azimuth_deg", "unit": "rad"}}
        )
        assert "azimuth_unit_suspect" not in [w.code for w in report.warnings]


@pytest.mark.parametrize(("name", "said"), [("altitude_ft", True), ("Altitude (ft)", True), ("remark_ft", False)])
def test_a_column_in_another_unit_is_named(read, warning, name, said):
    text = f"time_s,toa_A_ns,toa_B_ns,{name}\n1,5,6,30000\n"
    _, report = read(text)
    codes = [w.code for w in report.warnings]
    assert ("column_in_other_unit" in codes) is said
    if said:
        assert f"{name!r} looks like 'altitude_m'" in warning(report, "column_in_other_unit").detail
        recording, report = read(text, mapping={"altitude_m": {"column": name, "unit": "ft"}})
        assert report.warnings == ()
        np.testing.assert_allclose(recording.altitude_m, [[9144.0]])


@pytest.mark.parametrize(
    ("unit", "value", "metres"),
    [("m", "5", 5), ("km", "5", 5000), ("ft", "1000", 304.8), ("FL", "330", 10058.4), ("NM", "1", 1852)],
)
def test_units_of_length(read, unit, value, metres):
    recording, _ = read(
        f"t,a,alt\n1,5,{value}\n",
        mapping={"time_s": "t", "toa_X_ns": "a", "altitude_m": {"column": "alt", "unit": unit}},
    )
    np.testing.assert_allclose(recording.altitude_m, [[metres]], rtol=1e-15)
    assert recording.stations == ("X",)


@pytest.mark.parametrize(("unit", "value"), [("s", "5e-6"), ("ms", "5e-3"), ("us", "5"), ("ns", "5000")])
def test_units_of_time_of_arrival(read, unit, value):
    recording, _ = read(f"t,a\n1,{value}\n", mapping={"time_s": "t", "toa_X_ns": {"column": "a", "unit": unit}})
    np.testing.assert_allclose(recording.toa_s, 5e-6, rtol=1e-15)


def test_units_of_angle(read):
    text = "t,r,a\n1,5,1.5\n"
    recording, _ = read(
        text,
        mapping={
            "time_s": "t",
            "range_m": {"column": "r", "unit": "nm"},
            "azimuth_deg": {"column": "a", "unit": "rad"},
        },
    )
    assert recording.azimuth_rad[0, 0] == 1.5
    assert recording.range_m[0, 0] == 5 * 1852


def test_limits_hold_in_the_unit_of_the_source(read):
    _, report = read(
        "t,r,a\n1,5,7\n2,5,6\n", mapping={"time_s": "t", "range_m": "r", "azimuth_deg": {"column": "a", "unit": "rad"}}
    )
    assert [(r.row, r.code) for r in report.rejections] == [(1, "out_of_range")]


def test_speed_of_truth_in_knots(read):
    recording, _ = read(
        "time_s,toa_A_ns,true_east_m,true_north_m,true_up_m,v\n1,5,1,2,3,10\n",
        mapping={"true_velocity_east_mps": {"column": "v", "unit": "kn"}},
    )
    np.testing.assert_allclose(recording.truth_velocity_mps[0, 0], 18520 / 3600)


@pytest.mark.parametrize(
    ("mapping", "code", "pointer"),
    [
        ({"time": "t"}, "unknown_native_column", "/options/mapping/time"),
        ({"time_s": "T"}, "missing_column", "/options/mapping/time_s/column"),
        ({"time_s": {"column": "t", "unit": "m"}}, "unit", "/options/mapping/time_s/unit"),
        ({"time_s": {"column": "t", "unit": "fortnight"}}, "unit", "/options/mapping/time_s/unit"),
        ({"time_s": {"column": "t", "minus": "x"}}, "missing_column", "/options/mapping/time_s/minus"),
    ],
)
def test_mappings_that_cannot_be(read, mapping, code, pointer):
    with pytest.raises(InputError) as e:
        read("t,a\n1,5\n", mapping={"toa_X_ns": "a", "time_s": "t"} | mapping)
    assert (e.value.code, e.value.pointer) == (code, pointer)


def test_a_mapping_that_leaves_the_kind_open(read):
    with pytest.raises(InputError) as e:
        read("t,a\n1,5\n", mapping={"time_s": "t", "altitude_m": "a"})
    assert (e.value.code, e.value.pointer) == ("kind_unknown", "/options/kind")


def test_minus_takes_the_own_position_off(read):
    recording, report = read(
        "t,e,n,oe,on\n1,100,200,10,20\n2,100,200,,20\n",
        mapping={
            "time_s": "t",
            "east_m": {"column": "e", "minus": "oe"},
            "north_m": {"column": "n", "minus": "on"},
            "radar_east_m": "oe",
            "radar_north_m": "on",
        },
    )
    assert (recording.east_m[0, 0], recording.north_m[0, 0]) == (90, 180)
    assert (recording.radar_east_m[0], recording.radar_north_m[0]) == (10, 20)
    assert [(r.row, r.code) for r in report.rejections] == [(2, "missing_value")]


def test_where_keeps_rows(read, warning):
    text = "scenario,run,time_s,toa_A_ns\ns1,1.0,1,5\ns2,1,2,5\ns1,2,3,5\ns1,1,4,x\n"
    recording, report = read(text, where={"scenario": "s1", "run": 1})
    assert recording.row.tolist() == [1]
    assert (report.rows_read, report.rows_accepted) == (2, 1)
    assert [(r.row, r.code) for r in report.rejections] == [(4, "not_a_number")]
    assert warning(report, "rows_filtered").count == 2


def test_rows_of_the_second_file_go_on_after_filtered_ones(read):
    text = "scenario,time_s,toa_A_ns\ns1,1,5\ns2,2,5\n"
    recording, _ = read(text, text.replace(",5", ",6"), where={"scenario": "s1"})
    assert recording.row.tolist() == [1, 3]


def test_where_with_nothing_left(read):
    with pytest.raises(InputError) as e:
        read("s,time_s,toa_A_ns\na,1,5\n", where={"s": "b"})
    assert (e.value.code, e.value.pointer) == ("where_matches_nothing", "/options/where")


def test_where_with_an_unknown_column(read):
    with pytest.raises(InputError) as e:
        read("s,time_s,toa_A_ns\na,1,5\n", where={"S": "b"})
    assert (e.value.code, e.value.pointer) == ("missing_column", "/options/where/S")


def test_scan_numbers_are_whole(read):
    _, report = read("time_s,range_m,azimuth_deg,scan\n1,2,3,4.5\n2,2,3,4.0\n")
    assert [(r.row, r.code) for r in report.rejections] == [(1, "not_whole")]


def test_kind_that_the_format_does_not_hold(read):
    text = 'aircraft,measurements\n1,"[[1,5000000000,1],[2,5000000010,1]]"\n'
    with pytest.raises(InputError) as e:
        read(text, kind="polar_plots")
    assert e.value.code == "kind_unfit"
