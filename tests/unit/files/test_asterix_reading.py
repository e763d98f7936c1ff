"""ASTERIX files as plots, scans, sites and truth."""

import json

import numpy as np
import pytest

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.asterix import reading
from backend.files.reading import ReadLimits
from tests.asterix_files import NM, adsb, block, cat048, north, plot, sector, source, turning_radar

T = 36_000.0


def codes(report):
    return {w.code for w in report.warnings}


def test_a_plot_with_everything(read, warning):
    data = cat048(
        plot(T, 54.0, 90.0, address=0x4B1234, callsign="SWR12AB", level=300, squawk="0021"),
        plot(T + 1, 54.5, 91.0, type=1),
    )
    plots, report = read(data + cat048(plot(T + 2, 55, 92)))
    assert (report.format, report.kind, report.rows_read, report.rows_accepted) == ("asterix", "polar_plots", 3, 3)
    assert plots.time_s.tolist() == [T, T + 1, T + 2]
    np.testing.assert_allclose(plots.range_m[:, 0], np.array([54, 54.5, 55]) * NM)
    np.testing.assert_allclose(np.degrees(plots.azimuth_rad[:, 0]), [90, 91, 92], atol=3e-3)
    np.testing.assert_allclose(plots.altitude_m[:, 0], [300 * 30.48, np.nan, np.nan])
    assert plots.radars == ("1/2",)
    assert (plots.address.tolist(), plots.addresses) == ([0, -1, -1], ("4B1234",))
    assert (plots.callsign.tolist(), plots.callsigns) == ([0, -1, -1], ("SWR12AB",))
    assert (plots.mode_3a.tolist(), plots.modes_3a) == ([0, -1, -1], ("0021",))
    assert plots.row.tolist() == [1, 2, 3]
    assert plots.start_utc is None
    assert warning(report, "flight_level").count == 1
    assert "CAT 048 1.32 (= 1.31" in warning(report, "editions_used").detail


def test_codes_that_the_radar_does_not_trust_stay_empty(read, warning):
    plots, report = read(
        cat048(plot(T, level=100, unsure=1), plot(T + 1, squawk="7700", garbled=1), plot(T + 2, simulated=1))
    )
    assert np.isnan(plots.altitude_m).all()
    assert plots.modes_3a == ()
    assert warning(report, "codes_unsure").count == 2
    assert warning(report, "test_targets").count == 1


def test_radars_of_one_file_are_kept_apart(read):
    one, turns = turning_radar(4)
    two, _ = turning_radar(3, period_s=7.0, radar=(9, 200))
    mixed = [b for pair in zip(one, two + [b""] * (len(one) - len(two)), strict=True) for b in pair]
    plots, report = read(b"".join(mixed))
    assert plots.radars == ("1/2", "9/200")
    assert plots.scan[plots.radar == 0].tolist() == turns
    assert (plots.radar == 1).sum() == 24
    assert {w.detail for w in report.warnings if w.code == "scans_cut"} >= {
        "Scans of 1/2 were told by 4 marks; period 5 s.",
        "Scans of 9/200 were told by 3 marks; period 7 s.",
    }


@pytest.mark.parametrize("marks", [True, False])
def test_scans_by_marks_and_by_azimuth_agree(read, warning, marks):
    data, turns = turning_radar(30, plots=12, marks=marks)
    plots, report = read(b"".join(data))
    assert plots.scan.tolist() == turns
    assert ("marks" if marks else "north") in warning(report, "scans_cut").detail


def test_scans_by_sectors_with_turns_missing(read):
    data = [sector(T + 5 * turn + 5 * k / 8, 45 * k) for turn in (0, 1, 4) for k in range(8)]
    data += [cat048(plot(T + 5 * turn + 2.5, 30, 180)) for turn in (0, 1, 4)]
    plots, _ = read(b"".join(data))
    assert plots.scan.tolist() == [1, 2, 5]


def test_scans_by_period_and_its_errors(read, warning):
    data = [cat048(plot(T + 5 * k, 30, 90)) for k in range(8)]
    plots, report = read(b"".join(data), scan_cut="period", scan_period_s=20)
    assert plots.scan.tolist() == [1] * 4 + [2] * 4
    assert "20 s" in warning(report, "scans_cut").detail
    with pytest.raises(InputError) as e:
        read(b"".join(data), scan_cut="period")
    assert (e.value.code, e.value.pointer) == ("period_unknown", "/options/scan_period_s")
    still = [cat048(plot(T + 3 * k, 30, (k * k * 47) % 360)) for k in range(40)]
    plots, report = read(b"".join(still))
    assert (plots.scan == -1).all()
    assert warning(report, "scans_unknown").count == 1


def test_scans_of_a_table_only_on_request(read, warning):
    rows = [(36000 + 5 * (t + (k + 0.5) / 8), 20000 + k, 360 * (k + 0.5) / 8) for t in range(20) for k in range(8)]
    table = "time_s,range_m,azimuth_deg\n" + "".join(f"{t},{r},{a}\n" for t, r, a in rows)
    plots, report = read(table)
    assert (plots.scan == -1).all()
    plots, report = read(table, scan_cut="azimuth")
    assert plots.scan.tolist() == [1 + i // 8 for i in range(160)]
    assert "period 5 s" in warning(report, "scans_cut").detail
    _, report = read("time_s,toa_A_ns\n0,1\n", scan_cut="azimuth")
    assert warning(report, "option_ignored").count == 1


def test_over_midnight(read, warning):
    # Written as a radar does: the time of day begins anew.
    times = [86_400 - 25 + k for k in range(50)]
    raw = b"".join(cat048(plot(t % 86_400, 30, (72 * k) % 360)) for k, t in enumerate(times))
    plots, report = read(raw)
    np.testing.assert_allclose(plots.time_s, times)
    assert warning(report, "midnight_crossed").count == 1
    assert "rows_out_of_order" not in codes(report)


def test_steps_of_the_clock_and_clocks_that_differ(read, warning):
    times = [T, T + 1, T + 2, T + 500, T + 501, T + 100]
    _, report = read(b"".join(cat048(plot(t, 30, 10 * t % 360)) for t in times))
    assert warning(report, "time_jumps").count == 2
    assert "record 4 " in warning(report, "time_jumps").detail
    assert "+498" in warning(report, "time_jumps").detail

    data, turns = turning_radar(20, marks=False)
    mixed = []
    for turn in range(20):
        mixed += [north(T + 3600 + 5 * turn), *data[8 * turn : 8 * turn + 8]]
    plots, report = read(b"".join(mixed))
    assert "CAT 034 1/2 (+3600 s)" in warning(report, "clocks_differ").detail
    assert "north" in warning(report, "scans_cut").detail
    assert plots.scan.tolist() == turns


def test_truncated_times_are_completed_by_cat_002(read, warning):
    def mark(time_s):
        return block(2, {"010": source(), "000": 1, "030": (time_s % 86_400, "s")})

    def short(time_s):
        return block(
            1,
            {
                "010": source(),
                "020": ((0, 0, 2, 0, 0, 0, None),),
                "040": (("RHO", (40, "NM")), ("THETA", (12, "°"))),
                "070": (0, 0, 0, 0, ("MODE3A", "1234")),
                "090": (0, 0, ("HGT", (100, "FL"))),
                "141": (time_s % 86_400 % 512, "s"),
            },
            uap="plot",
        )

    times = [86_400 - 10 + k for k in range(0, 20, 2)]
    plots, report = read(b"".join(mark(t) + short(t + 0.5) for t in times))
    np.testing.assert_allclose(plots.time_s, np.array(times) + 0.5)
    assert plots.modes_3a == ("1234",)
    plots, report = read(b"".join(short(t) for t in (500.0, 510.0, 514.0)))
    np.testing.assert_allclose(np.diff(plots.time_s), [10, 4])
    assert warning(report, "time_truncated").count == 3


def test_tracks_and_plots_of_cat_001_in_one_block(read):
    common = {"010": source(), "040": (("RHO", (40, "NM")), ("THETA", (12, "°"))), "141": (10, "s")}
    first = block(1, common | {"020": ((0, 0, 2, 0, 0, 0, None),)}, uap="plot")
    second = block(1, common | {"020": ((1, 0, 2, 0, 0, 0, None),), "161": 7}, uap="track")
    body = first[3:] + second[3:]
    plots, report = read(bytes([1]) + (len(body) + 3).to_bytes(2, "big") + body)
    assert len(plots) == 1  # the same plot twice: nothing that is read differs
    assert [r.code for r in report.rejections] == ["duplicate_row"]


def test_the_file_tells_where_its_radar_stands(read, warning):
    place = (("HGT", (155, "m")), ("LAT", (50.1, "°")), ("LON", (14.25, "°")))
    data = north(T, i041=(4.8, "s"), i120=place) + cat048(plot(T + 1, 30, 77))
    plots, report = read(data)
    radar = plots.site.radars[0]
    assert (radar.name, radar.height_m, radar.range_kind, radar.period_s) == ("1/2", 155, "slant", 4.796875)
    assert radar.latitude_deg == pytest.approx(50.1, abs=2e-5)
    assert warning(report, "site_from_file").count == 1
    site = {"radars": [{"name": "1/2", "east_m": 5, "north_m": 6}]}
    plots, report = read(data, site=json.dumps(site))
    assert plots.site.radars[0].east_m == 5
    assert "site_from_file" not in codes(report)


def test_positions_of_cat_021_are_the_truth_of_plots_with_that_address(read):
    place = (("HGT", (0, "m")), ("LAT", (50.0, "°")), ("LON", (14.0, "°")))
    data = north(T, i120=place)
    for k in range(10):
        data += adsb(T + k, 50.0 + 0.01 * k, 14.0, 0x4B1234) + adsb(T + k, 50.5, 14.0, 0x4B9999)
        data += cat048(plot(T + k + 0.5, 30, k, address=0x4B1234), plot(T + k + 0.5, 31, 200 + k))
    plots, report = read(data)
    tracks = plots.truth_tracks
    assert (tracks.targets, len(tracks)) == (("4B1234", "4B9999"), 20)
    assert tracks.position_m[0, 2] == pytest.approx(10_000 * 0.3048, abs=1)
    known = np.isfinite(plots.truth_m).all(axis=1)
    assert known.sum() == 9
    assert {plots.addresses[a] for a in plots.address[known]} == {"4B1234"}
    # Half way between two positions a hundredth of a degree apart.
    assert plots.truth_m[known][0, 1] == pytest.approx(0.005 * 111_229, rel=1e-3)
    assert report.rows_read == report.rows_accepted == 20


def test_asterix_as_truth_file(read):
    truth = b"".join(adsb(T + k, 50.0 + 0.01 * k, 14.0, 0x4B1234) for k in range(10))
    radar = {"radars": [{"name": "1/2", "latitude_deg": 50.0, "longitude_deg": 14.0, "height_m": 0}]}
    data = b"".join(cat048(plot(T + k, 30, 36 * k, address=0x4B1234)) for k in range(10))
    plots, _ = read(data, truth=truth, site=json.dumps(radar))
    assert np.isfinite(plots.truth_m).all()
    assert plots.truth_tracks.targets == ("4B1234",)
    with pytest.raises(InputError) as e:
        read(data, truth=data, site=json.dumps(radar))
    assert (e.value.code, e.value.pointer) == ("no_usable_rows", "/truth")


def test_positions_alone_are_cartesian_plots_with_their_targets(read, warning):
    data = b"".join(adsb(T + k, 50.0, 14.0 + 0.01 * k, 0x4B1234) for k in range(3))
    plots, report = read(data, origin={"latitude_deg": 50, "longitude_deg": 14})
    assert plots.targets == ("4B1234",)
    assert plots.east_m[1, 0] == pytest.approx(0.01 * 71_700, rel=1e-3)
    assert np.isnan(plots.range_m).all()
    assert plots.site.origin.latitude_deg == 50
    plots, report = read(data)
    assert "50, 14 degrees" in warning(report, "origin_chosen").detail


def test_tracks_of_cat_062_in_the_plane_of_their_system(read, warning):
    def track(time_s, x, number):
        return block(
            62,
            {
                "010": source(3, 4),
                "070": (time_s, "s"),
                "100": (("X", (x, "m")), ("Y", (-50.5, "m"))),
                "040": number,
                "136": (200, "FL"),
            },
        )

    plots, report = read(b"".join(track(T + k, 100.5 * k, 7 + k % 2) for k in range(4)))
    np.testing.assert_allclose(plots.east_m[:, 0], [0, 100.5, 201, 301.5])
    np.testing.assert_allclose(plots.north_m[:, 0], -50.5)
    assert plots.targets == ("3/4 track 7", "3/4 track 8")
    assert warning(report, "reference_plane").count == 4
    assert plots.altitude_m[0, 0] == 200 * 30.48


def test_surface_reports_of_cat_010_without_its_status_messages(read):
    report_ = {"010": source(), "000": 1, "140": (T, "s"), "040": (("RHO", (1500, "m")), ("TH", (45, "°")))}
    data = block(10, report_) + block(10, {"010": source(), "000": 2, "140": (T, "s")})
    plots, report = read(data)
    assert (plots.range_m[0, 0], report.rows_read) == (1500, 1)


def test_editions_by_option(read, warning):
    data = cat048(plot(T), edition="1.27") + north(T)
    _, report = read(data, edition="48:1.30 34:1.28")
    assert "CAT 048 1.30." in warning(report, "editions_used").detail
    _, report = read(data, edition="1.28")
    assert "CAT 034 1.28; CAT 048 1.28." in warning(report, "editions_used").detail
    for edition in ("9.9", "48:0.1", "newest"):
        with pytest.raises(InputError) as e:
            read(data, edition=edition)
        assert (e.value.code, e.value.pointer) == ("edition_unknown", "/options/edition")


def test_a_wrong_edition_is_told_with_the_right_one(read, warning):
    old = {"010": source(), "040": 0, "030": (T, "s"), "130": (("LAT", (50, "°")), ("LON", (14, "°"))), "080": 0x4B1234}
    data = b"".join(block(21, old | {"030": (T + k, "s")}, edition="0.26") for k in range(5))
    plots, report = read(data)
    assert "CAT 021 0.26" in warning(report, "editions_used").detail
    assert plots.targets == ("4B1234",)
    with pytest.raises(InputError) as e:
        read(data, edition="2.4")
    assert e.value.code == "no_usable_rows"
    plots, report = read(cat048(plot(T)) + data, edition="21:2.4")
    assert (len(plots), report.rows_read) == (1, 1 + len(report.rejections))
    assert "edition 0.26 5" in warning(report, "edition_misfit").detail


def test_what_has_no_time_or_place_is_listed_with_its_byte(read):
    late = plot(T) | {"140": (90_000, "s")}
    nowhere = {n: v for n, v in plot(T).items() if n != "040"}
    timeless = {n: v for n, v in plot(T).items() if n != "140"}
    data = cat048(plot(T), late) + cat048(nowhere) + cat048(timeless)
    plots, report = read(data)
    first = len(cat048(plot(T), late))
    assert [(r.row, r.code) for r in report.rejections] == [
        (2, "out_of_range"),
        (3, "missing_value"),
        (4, "missing_value"),
    ]
    assert f"byte {first + 3}, CAT 048: it has no position" in report.rejections[1].detail
    assert (len(plots), report.rows_read) == (1, 4)


def test_repeated_blocks(read, warning):
    data = cat048(plot(T)) + cat048(plot(T + 1))
    plots, report = read(data + data)
    assert (len(plots), warning(report, "blocks_repeated").count) == (2, 2)
    assert [r.code for r in report.rejections] == ["duplicate_row"] * 2


def test_two_files_go_on_with_their_marks(read):
    data, turns = turning_radar(12)
    half = 6 * 9
    plots, _ = read(b"".join(data[:half]), b"".join(data[half:]))
    assert plots.scan.tolist() == turns
    assert plots.row.tolist()[-1] == len(data)


def test_of_too_many_records_the_first_are_read(read, warning):
    data = [cat048(plot(T + k)) for k in range(7)]
    plots, report = read(b"".join(data), limits=ReadLimits(max_rows=4))
    assert plots.time_s.tolist() == read(b"".join(data[:4]))[0].time_s.tolist()
    assert report.rows_read == 4
    assert "more than 4 rows" in warning(report, "rows_beyond_limit").detail


def test_a_file_that_ends_within_a_record_is_used_up_to_it(read):
    data = b"".join(cat048(plot(T + k / 8, 20 + k)) for k in range(100))
    plots, report = read(data[:-5])
    assert (len(plots), report.rows_read, [r.code for r in report.rejections]) == (99, 100, ["no_data_block"])


def test_of_too_many_bytes_the_first_are_read(read, warning, monkeypatch):
    """What the limit cuts is not broken: the file goes on."""
    data = b"".join(cat048(plot(T + k / 8, 20 + k)) for k in range(100))
    size = len(data) // 100
    most = 10 * size + 5
    monkeypatch.setattr(reading, "_BYTES_A_ROW", 1)
    monkeypatch.setattr(reading, "_LEAST_ROWS", most)
    plots, report = read(data, limits=ReadLimits(max_rows=100))
    assert (len(plots), report.rows_read, report.rejections) == (10, 10, ())
    assert f"longer than {most} bytes" in warning(report, "rows_beyond_limit").detail


def test_marks_alone_are_no_recording(read):
    with pytest.raises(InputError) as e:
        read(north(T) + north(T + 5))
    assert e.value.code == "no_rows"


def test_other_binaries_are_not_taken_for_asterix(read):
    for seed in range(20):
        data = np.random.default_rng(seed).integers(0, 256, 5000, dtype=np.uint8).tobytes()
        with pytest.raises((UnsupportedFormatError, InputError)) as e:
            read(data)
        assert e.value.code in ("unsupported_format", "encoding")
