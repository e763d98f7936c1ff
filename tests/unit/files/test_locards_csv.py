from __future__ import annotations

import json

import numpy as np
import pytest

from algorithms.errors import InputError

HEADER = "id,timeAtServer,aircraft,latitude,longitude,baroAltitude,geoAltitude,numMeasurements,measurements\n"
SENSORS = """serial,latitude,longitude,height,type,good
1,50.0,30.0,100,x,TRUE
2,50.1,30.0,200,x,TRUE
3,0,0,0,x,FALSE
4,50.1,30.0,200,x,TRUE
5,50.0,30.1,150,x,TRUE
6,51.0,31.0,150,x,TRUE
"""


def row(measurements, aircraft=7, position="50.05,30.05", altitude="9000,8900"):
    return f'1,2.5,{aircraft},{position},{altitude},5,"{json.dumps(measurements)}"\n'


T = 123_456_789_012


def test_gate_and_offsets_are_exact(read):
    recording, report = read(HEADER + row([[1, T, 50], [2, T + 7, 60], [5, T - 3, 70]]))
    assert (report.kind, report.format) == ("toa_marks", "locards_csv")
    # The median is 123 456 789 012 ns; one millisecond earlier, rounded down to the millisecond: 123.455 s.
    assert recording.time_s.tolist() == [123.455]
    assert recording.stations == ("1", "2", "5")
    np.testing.assert_array_equal(recording.toa_s[0, :, 0], [1_789_012 / 1e9, 1_789_019 / 1e9, 1_789_009 / 1e9])
    assert recording.targets == ("7",)
    assert recording.altitude_m[0, 0] == 9000


def test_epoch_nanoseconds_keep_their_last_digit(read):
    t = 1_620_205_606_491_287_123
    recording, _ = read(HEADER + row([[1, t, 1], [2, t + 1, 1], [5, t + 2, 1]]))
    assert recording.start_utc == "2021-05-05T09:06:46Z"
    assert recording.time_s.tolist() == [0.490]
    np.testing.assert_array_equal(recording.toa_s[0, :, 0], [1_287_123 / 1e9, 1_287_124 / 1e9, 1_287_125 / 1e9])


def test_site_holds_only_stations_in_use(read, warning):
    recording, report = read(HEADER + row([[1, T, 1], [2, T, 1], [5, T, 1]]), site=SENSORS)
    assert [s.name for s in recording.site.stations] == ["1", "2", "5"]
    assert recording.site.sigma_toa_ns == 90
    assert recording.site.sigma_altitude_m == 125
    assert recording.site.origin.height_m == 0
    origin = recording.site.origin
    assert 50.0 <= origin.latitude_deg <= 50.1
    assert 30.0 <= origin.longitude_deg <= 30.1
    assert recording.site.stations[1].latitude_deg == 50.1
    assert warning(report, "pressure_altitude").count == 1
    # On a sphere: 111.2 km per degree of latitude, 71.5 km per degree of longitude.
    expected = [(30.05 - origin.longitude_deg) * 71_500, (50.05 - origin.latitude_deg) * 111_200, 8900]
    np.testing.assert_allclose(recording.truth_m[0], expected, atol=25)


def test_stations_without_a_position(read, warning):
    recording, report = read(HEADER + row([[1, T, 1], [2, T, 1], [3, T, 1], [99, T, 1]]), site=SENSORS)
    found = warning(report, "station_without_position")
    assert found.count == 2
    assert "3, 99" in found.detail
    assert recording.stations == ("1", "2")


def test_two_stations_at_one_place(read, warning):
    recording, report = read(HEADER + row([[1, T, 1], [2, T, 1], [4, T, 1]]), site=SENSORS)
    found = warning(report, "station_same_place")
    assert found.count == 1
    assert "4" in found.detail
    assert "2" in found.detail
    assert recording.stations == ("1", "2")


def test_marks_that_lose_all_receptions(read):
    rows = row([[1, T, 1], [2, T, 1]]) + row([[3, T + 10**9, 1]], altitude=",8900") + row([[3, T + 2 * 10**9, 1]])
    recording, report = read(HEADER + rows, site=SENSORS)
    assert [(r.row, r.code) for r in report.rejections] == [(2, "empty_row")]
    assert recording.row.tolist() == [1, 3]
    assert np.isnan(recording.toa_s[1]).all()


def test_too_few_stations(read):
    with pytest.raises(InputError) as e:
        read(HEADER + row([[1, T, 1], [3, T, 1]]), site=SENSORS)
    assert (e.value.code, e.value.pointer) == ("too_few_stations", "/site")


def test_without_a_site(read, warning):
    recording, report = read(HEADER + row([[1, T, 1], [2, T, 1]]))
    assert recording.site is None
    assert not recording.has_truth
    warning(report, "truth_without_origin")


def test_with_site_json(read, warning):
    stations = [{"name": n, "east_m": 1e4 * i, "north_m": 0} for i, n in enumerate(["2", "1", "8"])]
    recording, report = read(
        HEADER + row([[1, T, 1], [2, T, 1], [5, T, 1]]), site=json.dumps({"stations": stations, "sigma_toa_ns": 50})
    )
    assert recording.stations == ("2", "1", "8")
    assert "5" in warning(report, "station_without_position").detail
    assert "8" in warning(report, "station_without_receptions").detail
    assert recording.site.sigma_toa_ns == 50
    assert recording.site.sigma_altitude_m == 125


def test_site_json_of_other_stations(read):
    stations = [{"name": n, "east_m": 1e4 * i, "north_m": 0} for i, n in enumerate(["A", "B"])]
    with pytest.raises(InputError) as e:
        read(HEADER + row([[1, T, 1], [2, T, 1]]), site=json.dumps({"stations": stations}))
    assert e.value.code == "station_unknown"


def test_station_twice_in_one_mark(read, warning):
    recording, report = read(HEADER + row([[1, T + 5, 1], [2, T, 1], [1, T + 2, 1]]))
    assert warning(report, "repeated_station").count == 1
    assert recording.toa_s[0, 0, 0] - recording.toa_s[0, 1, 0] == pytest.approx(2e-9, abs=1e-15)


def test_a_clock_that_is_far_off(read, warning):
    recording, report = read(HEADER + row([[1, T, 1], [2, T, 1], [5, T + 11 * 10**9, 1]]))
    found = warning(report, "clock_far_off")
    assert (found.count, "5" in found.detail) == (1, True)
    assert recording.stations == ("1", "2")


@pytest.mark.parametrize(
    "measurements",
    [
        "nonsense",
        "[[1,2",
        "{}5",
        "[1,2]",
        "[[1]]",
        "[[1,8.6e9,1]]",
        "[[1,null,1]]",
        "[[1,NaN,1]]",
        "[[true,5,1]]",
        f"[[1,{10**30},1]]",
        "[" * 5000,
    ],
)
def test_broken_measurements(read, measurements):
    good = row([[1, T, 1], [2, T, 1]])
    recording, report = read(HEADER + f'1,2,3,,,,,5,"{measurements}"\n' + good)
    assert [(r.row, r.code) for r in report.rejections] == [(1, "bad_measurements")]
    assert recording.row.tolist() == [2]


def test_no_receptions(read):
    _, report = read(HEADER + row([]) + row([[1, T, 1], [2, T, 1]]))
    assert [(r.row, r.code) for r in report.rejections] == [(1, "empty_row")]


def test_truth_without_a_height(read, warning):
    text = 'aircraft,latitude,longitude,measurements\n7,50,30,"[[1,5000000000,1],[2,5000000000,1]]"\n'
    recording, report = read(text, site=SENSORS)
    assert not recording.has_truth
    warning(report, "truth_unusable")


def test_the_same_message_with_another_id(read):
    one = row([[1, T, 1], [2, T, 1]])
    _, report = read(HEADER + one + "9" + one)
    assert [(r.row, r.code) for r in report.rejections] == [(2, "duplicate_row")]


def test_sensor_table_with_bad_rows(read, warning):
    table = SENSORS + "7,north,30,100,x,TRUE\n1,50.5,30.5,100,x,TRUE\n"
    recording, report = read(HEADER + row([[2, T, 1], [5, T, 1], [1, T, 1]]), site=table)
    assert warning(report, "sensor_rows_unusable").count == 1
    assert "1" in warning(report, "sensor_repeated").detail
    assert recording.stations == ("2", "5")


@pytest.mark.parametrize("table", ["serial,latitude,longitude\n1,2,3\n", "a,b\n1,2\n"])
def test_sensor_table_without_its_columns(read, table):
    with pytest.raises(InputError) as e:
        read(HEADER + row([[2, T, 1]]), site=table)
    assert (e.value.code, e.value.pointer) == ("missing_column", "/site")


def test_sensor_table_without_rows(read):
    with pytest.raises(InputError) as e:
        read(HEADER + row([[2, T, 1]]), site="serial,latitude,longitude,height\n")
    assert (e.value.code, e.value.pointer) == ("no_usable_rows", "/site")


def test_sensor_table_for_native_marks(read):
    recording, _ = read("time_s,toa_1_ns,toa_5_ns\n1,5,6\n", site=SENSORS)
    assert recording.stations == ("1", "5")
    with pytest.raises(InputError, match="toa_77_ns") as e:
        read("time_s,toa_1_ns,toa_77_ns\n1,5,6\n", site=SENSORS)
    assert e.value.code == "station_unknown"


def test_sensor_table_for_plots(read):
    with pytest.raises(InputError) as e:
        read("time_s,range_m,azimuth_deg\n1,5,6\n", site=SENSORS)
    assert e.value.code == "site_kind"
