from __future__ import annotations

import json

import numpy as np
import pytest

from algorithms.errors import InputError

C = 299_792_458.0
MARKS = "time_s,toa_A_ns,toa_B_ns,toa_C_ns\n1,0,100,200\n2,0,100,200\n"


def site(*names, **fields):
    stations = [{"name": n, "east_m": 1000.0 * i, "north_m": 0, "up_m": 0} for i, n in enumerate(names)]
    return json.dumps({"stations": stations} | fields)


def test_columns_follow_the_order_of_the_site(read):
    recording, report = read(MARKS, site=site("C", "A", "B", sigma_toa_ns=5))
    assert recording.stations == ("C", "A", "B")
    np.testing.assert_allclose(recording.toa_s[0, :, 0], [200e-9, 0, 100e-9])
    assert recording.site.sigma_toa_ns == 5
    assert report.warnings == ()


def test_a_clock_offset_is_left_to_the_algorithms(read):
    stations = [{"name": n, "east_m": 1e3 * i, "north_m": 0, "clock_offset_ns": 50} for i, n in enumerate("ABC")]
    recording, _ = read(MARKS, site=json.dumps({"stations": stations}))
    np.testing.assert_allclose(recording.toa_s[0, :, 0], [0, 100e-9, 200e-9])


def test_a_station_that_the_site_lacks(read):
    with pytest.raises(InputError, match=r"'toa_C_ns'.*A, B, c") as e:
        read(MARKS, site=site("A", "B", "c"))
    assert (e.value.code, e.value.pointer) == ("station_unknown", "/site/stations")


def test_a_station_that_the_recording_lacks(read, warning):
    recording, report = read(MARKS, site=site("A", "B", "D", "C"))
    assert "D" in warning(report, "station_without_receptions").detail
    assert recording.stations == ("A", "B", "D", "C")
    assert np.isnan(recording.toa_s[:, 2]).all()


@pytest.mark.parametrize(
    ("stations", "pointer", "code"),
    [
        ([{"name": "A", "east_m": 0, "north_m": 0}], "/site", "site_invalid"),
        (
            [{"name": "A", "east_m": 0, "north_m": 0}, {"name": "B", "east_m": 0, "north_m": 0.001}],
            "/site",
            "site_invalid",
        ),
        ([{"name": "", "east_m": 0, "north_m": 0}], "/site/stations/0/name", "site_invalid"),
        (
            [{"name": "A", "east_m": 0, "north_m": 0}, {"name": "B", "east_m": "x", "north_m": 0}],
            "/site/stations/1/east_m",
            "site_invalid",
        ),
        (
            [{"name": "A", "east_m": 0, "north_m": 0}, {"name": "B", "east_m": 1e300, "north_m": 0}],
            "/site/stations/1/east_m",
            "site_invalid",
        ),
        ([{"name": "A", "latitude_deg": 91, "longitude_deg": 0}], "/site/stations/0/latitude_deg", "site_invalid"),
    ],
)
def test_sites_that_are_not_sound(read, stations, pointer, code):
    with pytest.raises(InputError) as e:
        read(MARKS, site=json.dumps({"stations": stations}))
    assert (e.value.code, e.value.pointer) == (code, pointer)
    # Who reads the sentence alone, as the page shows it, finds the field in it.
    if pointer.startswith("/site/stations/0/"):
        assert f"stations[0].{pointer.rpartition('/')[2]}: " in str(e.value)


def test_equal_stations_are_both_named(read):
    twice = [{"name": n, "east_m": 5, "north_m": 6} for n in ("north", "south")]
    with pytest.raises(InputError, match=r"south.*north"):
        read(MARKS, site=json.dumps({"stations": twice}))


@pytest.mark.parametrize("text", ["{", '{"stations": [NaN]}', "[1, 2]", '{"stations": [{"name": "A", "east_m": NaN}]}'])
def test_site_that_is_no_site(read, text):
    with pytest.raises(InputError) as e:
        read(MARKS, site=text)
    assert e.value.code in ("site_json", "site_invalid")
    assert e.value.pointer.startswith("/site")


def test_measurements_and_site_in_each_others_place(read):
    with pytest.raises(InputError, match="neither Site JSON nor a sensor table: its columns are time_s") as e:
        read(MARKS, site=MARKS)
    assert (e.value.code, e.value.pointer) == ("missing_column", "/site")
    assert "measurements go into the recording" in e.value.remedy
    site = {"stations": [{"name": "north", "east_m": 5, "north_m": 6}]}
    for text in (json.dumps(site), json.dumps(site, indent=1)):
        with pytest.raises(InputError, match="is JSON, not a table of measurements") as e:
            read(text)
        assert (e.value.code, e.value.pointer) == ("no_columns", "/file")


def test_broken_site_json(read):
    with pytest.raises(InputError) as e:
        read(MARKS, site='{"stations": [')
    assert e.value.code == "site_json"


def test_empty_and_oversized_site(read):
    with pytest.raises(InputError) as e:
        read(MARKS, site=" ")
    assert (e.value.code, e.value.pointer) == ("empty_file", "/site")
    with pytest.raises(InputError) as e:
        read(MARKS, site="{" + " " * (9 << 20) + "}")
    assert e.value.code == "site_large"


def test_a_site_of_radars_for_marks_and_the_reverse(read):
    radars = json.dumps({"radars": [{"name": "R", "east_m": 0, "north_m": 0}]})
    with pytest.raises(InputError) as e:
        read(MARKS, site=radars)
    assert (e.value.code, e.value.pointer) == ("site_kind", "/site/stations")
    with pytest.raises(InputError) as e:
        read("time_s,range_m,azimuth_deg\n1,2,3\n", site=site("A", "B"))
    assert (e.value.code, e.value.pointer) == ("site_kind", "/site/radars")


def test_radars_by_name(read):
    radars = json.dumps({"radars": [{"name": n, "east_m": i, "north_m": 0} for i, n in enumerate("PQ")]})
    recording, _ = read("time_s,range_m,azimuth_deg,radar\n1,2,3,Q\n2,2,3,P\n", site=radars)
    assert recording.radars == ("P", "Q")
    assert recording.radar.tolist() == [1, 0]
    for text in ("time_s,range_m,azimuth_deg,radar\n1,2,3,X\n", "time_s,range_m,azimuth_deg\n1,2,3\n"):
        with pytest.raises(InputError) as e:
            read(text, site=radars)
        assert e.value.code == "radar_unknown"


def test_the_only_radar_needs_no_column(read):
    radars = json.dumps({"radars": [{"name": "R", "east_m": 0, "north_m": 0}]})
    recording, _ = read("time_s,range_m,azimuth_deg\n1,2,3\n", site=radars)
    assert recording.radars == ("R",)


def test_wgs84_stations_get_an_explicit_origin(read):
    stations = [{"name": n, "latitude_deg": 50 + 0.01 * i, "longitude_deg": 30} for i, n in enumerate("ABC")]
    recording, _ = read(MARKS, site=json.dumps({"stations": stations}))
    assert recording.site.origin.latitude_deg == pytest.approx(50.01, abs=1e-6)
    origin = {"latitude_deg": 50, "longitude_deg": 30}
    recording, _ = read(MARKS, site=json.dumps({"stations": stations}), origin=origin)
    assert recording.site.origin.latitude_deg == 50


def test_two_origins(read):
    with pytest.raises(InputError) as e:
        read(
            MARKS,
            site=site("A", "B", "C", origin={"latitude_deg": 1, "longitude_deg": 2}),
            origin={"latitude_deg": 2, "longitude_deg": 2},
        )
    assert (e.value.code, e.value.pointer) == ("origin_twice", "/options/origin")


def test_truth_of_the_file_uses_the_origin_of_the_site(read):
    text = "time_s,toa_A_ns,toa_B_ns,true_latitude_deg,true_longitude_deg,true_height_m\n1,0,100,50,30,77\n"
    recording, _ = read(text, site=site("A", "B", origin={"latitude_deg": 50, "longitude_deg": 30, "height_m": 7}))
    np.testing.assert_allclose(recording.truth_m, [[0, 0, 70]], atol=1e-6)


def test_times_in_microseconds_are_refused(read):
    # 3000 ns between stations 1000 m apart: 900 m are possible, 3 000 000 ns are not.
    good = "time_s,toa_A_ns,toa_B_ns\n" + "".join(f"{i},0,3000\n" for i in range(10))
    assert read(good, site=site("A", "B"))[1].rows_accepted == 10
    with pytest.raises(InputError, match="A, B") as e:
        read(good.replace("3000", "3000000"), site=site("A", "B"))
    assert (e.value.code, e.value.pointer) == ("check_units", "/site/stations")


@pytest.mark.parametrize(("wrong", "refuse"), [(5, False), (6, True)])
def test_less_than_half_of_impossible_marks_is_for_the_algorithms(read, wrong, refuse):
    rows = "".join(f"{i},0,{3_000_000 if i < wrong else 3000}\n" for i in range(10))
    if refuse:
        with pytest.raises(InputError):
            read("time_s,toa_A_ns,toa_B_ns\n" + rows, site=site("A", "B"))
    else:
        assert read("time_s,toa_A_ns,toa_B_ns\n" + rows, site=site("A", "B"))[1].rows_accepted == 10


def test_the_slack_is_five_standard_deviations(read):
    limit_ns = 1000 / C * 1e9
    text = "time_s,toa_A_ns,toa_B_ns\n1,0,{}\n"
    read(text.format(limit_ns + 4.9 * 20), site=site("A", "B", sigma_toa_ns=20))
    with pytest.raises(InputError):
        read(text.format(limit_ns + 5.1 * 20), site=site("A", "B", sigma_toa_ns=20))


def test_clock_offsets_are_taken_off_before_the_check(read):
    stations = [
        {"name": "A", "east_m": 0, "north_m": 0},
        {"name": "B", "east_m": 1000, "north_m": 0, "clock_offset_ns": 1e6},
    ]
    assert (
        read("time_s,toa_A_ns,toa_B_ns\n1,0,1000100\n", site=json.dumps({"stations": stations}))[1].rows_accepted == 1
    )


TRUTH = "time_s,true_east_m,true_north_m,true_up_m\n1,10,20,30\n3,11,21,31\n"


def test_truth_file_by_exact_time(read, warning):
    marks = "time_s,toa_A_ns\n1,0\n3,0\n"
    recording, report = read(marks, truth=TRUTH)
    np.testing.assert_array_equal(recording.truth_m, [[10, 20, 30], [11, 21, 31]])
    np.testing.assert_allclose(recording.truth_velocity_mps, [[0.5] * 3] * 2)
    assert report.warnings == ()


def test_names_without_true_in_a_file_of_truth(read):
    """`east_m` there is `true_east_m`, unless another column is said to be that."""
    plots = "time_s,east_m,north_m\n1,10,20\n2,30,40\n"
    truth = "time_s,east_m,north_m,velocity_east_mps\n1,11,21,7\n2,31,41,8\n"
    recording, _ = read(plots, truth=truth)
    np.testing.assert_allclose(recording.truth_m[:, :2], [[11, 21], [31, 41]])
    np.testing.assert_allclose(recording.truth_velocity_mps[:, 0], [7, 8])
    swapped = {"true_east_m": "north_m", "true_north_m": "east_m"}
    recording, _ = read(plots, truth=truth, truth_mapping=swapped)
    np.testing.assert_allclose(recording.truth_m[:, :2], [[21, 11], [41, 31]])


def test_truth_between_the_rows_of_its_file(read, warning):
    recording, report = read(MARKS, truth=TRUTH)
    np.testing.assert_allclose(recording.truth_m, [[10, 20, 30], [10.5, 20.5, 30.5]])
    assert warning(report, "truth_interpolated").count == 1
    assert "2 s apart" in warning(report, "truth_interpolated").detail


def test_rows_without_truth_and_why(read, warning):
    times = [0.5, 1, 2, 3, 7.5, 12, 13]
    marks = "time_s,toa_A_ns,target\n" + "".join(f"{t},5,x\n" for t in times) + "3,6,y\n"
    truth = "time_s,target,true_east_m,true_north_m,true_up_m\n" + "".join(
        f"{t},{'z' if t == 9 else 'x'},{t},0,0\n" for t in (1, 2, 3, 9, 11, 12)
    )
    recording, report = read(marks, truth=truth)
    assert np.isfinite(recording.truth_m[:, 0]).sum() == 4
    found = warning(report, "rows_without_truth")
    assert found.count == 4
    assert "1 of a target" in found.detail
    assert "2 before the first" in found.detail
    assert "1 in a gap" in found.detail
    assert "rows 4, 5" in warning(report, "truth_unmatched").detail


def test_truth_in_wgs84_is_interpolated_in_the_local_frame(read):
    origin = {"latitude_deg": 50, "longitude_deg": 30, "height_m": 0}
    truth = "time_s,true_latitude_deg,true_longitude_deg,true_height_m\n0,50,30,1000\n2,50,30,1100\n4,50,30,1200\n"
    recording, _ = read(MARKS, truth=truth, site=site("A", "B", "C", origin=origin))
    np.testing.assert_allclose(recording.truth_m, [[0, 0, 1050], [0, 0, 1100]], atol=1e-6)
    np.testing.assert_allclose(recording.truth_velocity_mps, [[0, 0, 50]] * 2, atol=1e-6)


def test_a_shift_of_the_truth_by_option(read, warning):
    recording, report = read(MARKS, truth=TRUTH, truth_shift_s=1)
    np.testing.assert_array_equal(recording.truth_m, [[np.nan] * 3, [10, 20, 30]])
    assert "+1 s" in warning(report, "truth_shifted").detail


def test_truth_file_by_target(read):
    marks = "time_s,toa_A_ns,target\n1,5,x\n1,6,y\n"
    truth = "time_s,target,true_east_m,true_north_m,true_up_m\n1,y,1,1,1\n1,x,2,2,2\n"
    recording, report = read(marks, truth=truth)
    assert recording.truth_m[:, 0].tolist() == [2, 1]
    assert report.warnings == ()


def test_truth_file_without_the_column_target(read):
    with pytest.raises(InputError) as e:
        read("time_s,toa_A_ns,target\n1,5,x\n1,6,y\n", truth=TRUTH)
    assert (e.value.code, e.value.pointer) == ("missing_column", "/truth")


def test_truth_of_several_targets_for_unnamed_measurements(read, warning):
    truth = "time_s,target,true_east_m,true_north_m,true_up_m\n1,y,1,1,1\n1,x,2,2,2\n"
    recording, report = read(MARKS, truth=truth)
    assert not recording.has_truth
    assert warning(report, "truth_not_assigned").count == 2
    tracks = recording.truth_tracks
    assert [tracks.targets[i] for i in tracks.target] == ["y", "x"]
    assert tracks.position_m.tolist() == [[1, 1, 1], [2, 2, 2]]


def test_true_paths_keep_points_that_serve_no_measurement_and_count_from_the_given_start(read):
    marks = "time_s,toa_A_ns\n1620205606.25,5\n1620205607.5,6\n"
    truth = "time_s,true_east_m,true_north_m,true_up_m\n1620205600,0,0,0\n1620205609,1,2,3\n"
    recording, _ = read(marks, truth=truth, start_utc="2021-05-05T09:06:40Z")
    np.testing.assert_allclose(recording.truth_tracks.time_s, [0, 9])
    np.testing.assert_allclose(recording.time_s, [6.25, 7.5])


def test_truth_file_with_epoch_times(read):
    marks = "time_s,toa_A_ns\n1620205606.25,5\n1620205607.5,6\n"
    truth = "t,true_east_m,true_north_m,true_up_m\n1620205600,0,0,0\n1620205607.5,1,2,3\n"
    recording, _ = read(marks, truth=truth, truth_mapping={"time_s": {"column": "t", "unit": "epoch"}})
    np.testing.assert_allclose(recording.truth_m[1], [1, 2, 3])
    np.testing.assert_allclose(recording.truth_m[0], np.array([1, 2, 3]) * 6.25 / 7.5)
    with pytest.raises(InputError) as e:
        read(MARKS, truth=truth, truth_mapping={"time_s": "t"})
    assert (e.value.code, e.value.pointer) == ("mixed_time_bases", "/truth")


@pytest.mark.parametrize(
    ("truth", "code"),
    [
        ("", "empty_file"),
        ("time_s,x\n1,2\n", "missing_column"),
        ("true_east_m,true_north_m,true_up_m\n1,2,3\n", "missing_column"),
        ("time_s,true_east_m,true_north_m,true_up_m\nx,1,2,3\n", "no_usable_rows"),
    ],
)
def test_truth_files_that_cannot_serve(read, truth, code):
    with pytest.raises(InputError) as e:
        read(MARKS, truth=truth)
    assert (e.value.code, e.value.pointer) == (code, "/truth")


def test_unusable_rows_of_a_truth_file(read, warning):
    _, report = read(MARKS, truth=TRUTH + "2,x,1,1\n")
    assert warning(report, "truth_rows_unusable").count == 1
    assert "row 3" in warning(report, "truth_rows_unusable").detail
    assert report.rows_read == report.rows_accepted == 2


def test_where_also_filters_the_truth(read):
    marks = "scenario,time_s,toa_A_ns\na,1,5\nb,1,6\n"
    truth = "scenario,time_s,true_east_m,true_north_m,true_up_m\nb,1,7,7,7\na,1,8,8,8\n"
    recording, _ = read(marks, truth=truth, where={"scenario": "a"})
    assert recording.truth_m.tolist() == [[8, 8, 8]]
