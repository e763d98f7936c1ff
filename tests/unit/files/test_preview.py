from __future__ import annotations

import numpy as np
import pytest

from algorithms.errors import InputError
from algorithms.recording import KINDS
from backend.files.column_guess import native_columns, suggest
from backend.files.options import ReadOptions
from backend.files.preview import ROWS_SHOWN, preview
from backend.files.reading import NamedFile


@pytest.fixture
def look(tmp_path):
    def run(text, **options):
        path = tmp_path / "file.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return preview([NamedFile("file.csv", path)], options=ReadOptions(**options))

    return run


def plain(suggestion):
    return {n: (s.column, s.unit) for n, s in suggestion.mapping.items()}


def test_a_native_file_needs_no_mapping(look):
    found = look("time_s,toa_A_ns,toa_B_ns\n1,0,100\n2,0,x\n3,0,5\n")
    assert found.format == "native_csv"
    assert found.columns == ("time_s", "toa_A_ns", "toa_B_ns")
    assert found.rows[1] == ("2", "0", "x")
    assert (found.report.rows_read, found.report.rows_accepted) == (3, 2)
    assert found.report.rejections[0].row == 2
    assert (found.suggestion.kind, plain(found.suggestion)) == ("toa_marks", {})


def test_a_foreign_file_gets_a_suggestion_that_is_not_applied(look):
    text = "ToD (ms);Rho [NM];Theta;FL;Code\n" + "".join(
        f"{1000 * i};{20 + i},5;{30 * i};310;7000\n" for i in range(12)
    )
    found = look(text)
    assert found.format is None
    assert found.report is None
    assert found.error.code == "unsupported_format"
    assert found.suggestion.kind == "polar_plots"
    assert plain(found.suggestion) == {
        "time_s": ("ToD (ms)", "ms"),
        "range_m": ("Rho [NM]", "NM"),
        "azimuth_deg": ("Theta", None),
        "altitude_m": ("FL", "FL"),
    }
    mapping = {n: s.model_dump() for n, s in found.suggestion.mapping.items()}
    applied = look(text, mapping=mapping, kind=found.suggestion.kind)
    assert applied.report.rows_accepted == 12


def test_the_suggestion_reads_the_quantities_right(tmp_path):
    from backend.files.reading import read_recording

    path = tmp_path / "radar.csv"
    path.write_text("timestamp_us,range_km,az_rad\n" + "".join(f"{i * 1e6},{i + 1},{i / 4}\n" for i in range(20)))
    found = preview([NamedFile("radar.csv", path)])
    options = ReadOptions(mapping=dict(found.suggestion.mapping), kind=found.suggestion.kind)
    recording, _ = read_recording([NamedFile("radar.csv", path)], options=options)
    np.testing.assert_allclose(recording.time_s, np.arange(20))
    np.testing.assert_allclose(recording.range_m[:, 0], 1000 * (np.arange(20) + 1))
    np.testing.assert_allclose(recording.azimuth_rad[:, 0], np.arange(20) / 4)


@pytest.mark.parametrize(
    ("names", "kind", "expected"),
    [
        (
            ["time", "toa1_us", "TOA North (ns)", "rx_3", "alt_ft"],
            "toa_marks",
            {
                "time_s": ("time", None),
                "toa_1_ns": ("toa1_us", "us"),
                "toa_north_ns": ("TOA North (ns)", None),
                "toa_3_ns": ("rx_3", None),
                "altitude_m": ("alt_ft", "ft"),
            },
        ),
        (["t", "x", "y"], "polar_plots", {"time_s": ("t", None), "east_m": ("x", None), "north_m": ("y", None)}),
        (
            ["time_s", "range", "bicone_elevation_mrad", "biconeAzimuth"],
            "antenna_plots",
            {
                "range_m": ("range", None),
                "bicone_elevation_deg": ("bicone_elevation_mrad", "mrad"),
                "bicone_azimuth_deg": ("biconeAzimuth", None),
            },
        ),
        (
            ["utc", "doppler1_khz", "fd2"],
            "doppler_pairs",
            {"time_s": ("utc", None), "doppler_1_hz": ("doppler1_khz", "kHz"), "doppler_2_hz": ("fd2", None)},
        ),
        (["name", "colour"], None, {}),
    ],
)
def test_names_are_understood(names, kind, expected):
    found = suggest(names, [], None)
    assert (found.kind, plain(found)) == (kind, expected)


def test_radians_are_told_from_the_values_of_an_azimuth():
    rows = [[str(i), "5", str(i / 4)] for i in range(20)]
    assert plain(suggest(["t", "range", "bearing"], rows, None))["azimuth_deg"] == ("bearing", "rad")
    degrees = [[str(i), "5", str(i * 15)] for i in range(20)]
    assert plain(suggest(["t", "range", "bearing"], degrees, None))["azimuth_deg"] == ("bearing", None)


def test_the_kind_that_the_user_names_is_kept():
    assert suggest(["a", "b"], [], "antenna_plots").kind == "antenna_plots"


@pytest.mark.parametrize("kind", KINDS)
def test_every_native_column_has_units_that_serve(kind):
    columns = {c.name: c.units for c in native_columns(kind)}
    assert columns["time_s"][0] == "s"
    assert "epoch_ms" in columns["time_s"]
    assert columns["target"] == ()
    assert columns["true_latitude_deg"] == ("deg", "rad", "mrad", "turn", "turn/65536")


def test_only_the_first_rows_are_shown(look):
    found = look("time_s,range_m,azimuth_deg\n" + "".join(f"{i},1,1\n" for i in range(100)))
    assert len(found.rows) == ROWS_SHOWN
    assert found.report.rows_read == 100


def test_a_mapping_that_fits_nothing_is_told(look):
    found = look("a,b,c\n1,2,3\n", mapping={"time_s": "zeit"}, kind="polar_plots")
    assert found.columns == ("a", "b", "c")
    assert found.error.pointer == "/options/mapping/time_s/column"


def test_a_row_filter_is_counted(look):
    found = look("time_s,range_m,azimuth_deg,who\n1,1,1,a\n2,1,1,b\n", where={"who": "b"})
    assert found.report.rows_read == 1
    assert [w.code for w in found.report.warnings] == ["rows_filtered"]


def test_locards_is_recognised(look):
    text = 'id,timeAtServer,aircraft,measurements\n7,2.5,766,"[[263,2605679765,49],[141,2605694015,76]]"\n'
    assert look(text).format == "locards_csv"


def test_a_file_that_is_no_text(look):
    with pytest.raises(InputError):
        look(b"PK\x03\x04" + bytes(100))
