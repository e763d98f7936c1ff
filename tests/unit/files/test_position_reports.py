"""Lines of position reports as truth: OpenARIA CSV and NOP lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from algorithms.errors import InputError
from algorithms.recording import Recording
from algorithms.site import Origin
from backend.files.reading import NamedFile, ReadLimits, ReadOptions, ReadReport, read_recording

ORIGIN = Origin(latitude_deg=42.2, longitude_deg=-83.3, height_m=200)
NOP = "[RH],STARS,D21,03/24/2018,14:47:{second},EDV4062,CRJ2,,2274,{altitude},385,244,{place},2711,2274,19.1,9.1,{{RH}}"


def nop(second: str, altitude: str = "117", place: str = "42.36550,-082.94917") -> str:
    return NOP.format(second=second, altitude=altitude, place=place)


def read_with_truth(
    folder: Path, truth: str, target: str, times: tuple[str, ...], limits: ReadLimits | None = None
) -> tuple[Recording, ReadReport]:
    plots = "\n".join(f"{time},{10_000 + i},45,{target}" for i, time in enumerate(times))
    (folder / "plots.csv").write_text(f"time_s,range_m,azimuth_deg,target\n{plots}\n", encoding="utf-8")
    (folder / "truth.txt").write_text(truth, encoding="utf-8")
    return read_recording(
        [NamedFile("plots.csv", folder / "plots.csv")],
        truth=NamedFile("truth.txt", folder / "truth.txt"),
        options=ReadOptions(origin=ORIGIN),
        limits=limits,
    )


def test_openaria_lines_become_the_truth_of_their_vehicle(tmp_path: Path) -> None:
    truth = (
        ",,2024-09-15T22:19:27.010,VIN_A,042.30000,-083.30000,1000,\n"
        "DFW,9v,2024-09-15T22:19:31.010Z,VIN_A,042.31000,-083.30000,1000,AA123,raw\n"
        ",,2024-09-15T22:19:31.010Z,VIN_B,043.31000,-083.30000,2500,\n"
    )
    times = ("2024-09-15T22:19:27.010Z", "2024-09-15T22:19:31.010Z")
    recording, _ = read_with_truth(tmp_path, truth, "VIN_A", times)
    # One hundredth of a degree of latitude is 1111 m here; 1000 feet are 304.8 m, less the curvature.
    assert recording.truth_m[1, 1] - recording.truth_m[0, 1] == pytest.approx(1110.8, abs=1)
    assert recording.truth_m[:, 2] == pytest.approx(304.8 - 200, abs=12)
    assert recording.truth_tracks is not None
    assert recording.truth_tracks.targets == ("VIN_A", "VIN_B")


def test_nop_lines_name_facility_and_track(tmp_path: Path) -> None:
    lines = [nop("52.471"), nop("57.471", "118", "42.37550,-082.94917")]
    times = ("2018-03-24T14:47:52.471Z", "2018-03-24T14:47:57.471Z")
    recording, report = read_with_truth(tmp_path, "\n".join(lines), "D21/2711", times)
    assert np.isfinite(recording.truth_m).all()
    assert recording.start_utc == "2018-03-24T14:47:52Z"
    assert {w.code: w.count for w in report.warnings}["truth_pressure_altitude"] == 2


@pytest.mark.parametrize(
    "line",
    [
        "[RH],Center,ZOB_B,07-10-2016,17:24:37.000,X1,E170,L,7336,270,443,077,41.3725,-80.8414,809,,,,,ZOB/70,,,{RH}",
        "[RH],MEARTS,ZOB_B,07-10-2016,17:24:37.000,X1,B737,L,2646,270,450,239,041.3725,-80.8414,809,,67.5,145.9,{RH}",
    ],
)
def test_lines_of_en_route_centres_have_dashes_in_their_dates(tmp_path: Path, line: str) -> None:
    recording, report = read_with_truth(tmp_path, line, "ZOB_B/809", ("2016-07-10T17:24:37Z",))
    # On a sphere: 2.4586 degrees of longitude east and 0.8275 of latitude south of the origin.
    assert recording.truth_m[0, :2] == pytest.approx([205_100, -89_100], abs=1_000)
    assert "truth_rows_unusable" not in {w.code for w in report.warnings}


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("gibberish", "does not begin"),
        (nop("52.471").replace("STARS", "TOWER"), "TOWER"),
        ("[RH],STARS,D21", "3 cells"),
        (nop("72.471"), "no date"),
        (nop("52.471", "000"), "no altitude"),
        (nop("52.471", "xxx"), "no altitude"),
        (nop("52.471", place="north,-082.9"), "'north'"),
        (nop("52.471", place="4_2,-082.9"), "'4_2'"),
        (nop("52.471", place="142.3,-082.9"), "latitude 142.3"),
        (nop("52.471").replace(",2711,", ",,"), "number of a track"),
        ("x" * 200_000, "longer than"),
    ],
)
def test_lines_that_hold_no_position_are_counted_and_told(tmp_path: Path, line: str, word: str) -> None:
    truth = "\n".join([nop("52.471"), "", line, nop("57.471")])
    times = ("2018-03-24T14:47:52.471Z", "2018-03-24T14:47:57.471Z")
    _, report = read_with_truth(tmp_path, truth, "D21/2711", times)
    (unusable,) = [w for w in report.warnings if w.code == "truth_rows_unusable"]
    assert unusable.count == 1
    assert "row 2, line 3" in unusable.detail
    assert word in unusable.detail


@pytest.mark.parametrize(
    ("cells", "word"),
    [
        (",,2024-09-15T22:19:28,,42.3,-83.3,1000", "no name"),
        (",,yesterday,VIN_A,42.3,-83.3,1000", "yesterday"),
        (",,2024-09-15T22:19:28,VIN_A,42.3,-83.3,high", "'high'"),
        (",,2024-09-15T22:19:28,VIN_A,42.3,-83.3,nan", "'nan'"),
        (",,2024-09-15T22:19:28,VIN_A", "4 cells"),
    ],
)
def test_openaria_lines_that_hold_no_position(tmp_path: Path, cells: str, word: str) -> None:
    good = ",,2024-09-15T22:19:{},VIN_A,42.3,-83.3,1000,"
    truth = "\n".join([good.format("27"), cells, good.format("29")])
    _, report = read_with_truth(tmp_path, truth, "VIN_A", ("2024-09-15T22:19:27Z", "2024-09-15T22:19:29Z"))
    (unusable,) = [w for w in report.warnings if w.code == "truth_rows_unusable"]
    assert word in unusable.detail


def test_nothing_usable_is_an_error_and_too_much_is_told(tmp_path: Path) -> None:
    times = ("2018-03-24T14:47:52.471Z", "2018-03-24T14:47:57.471Z")
    with pytest.raises(InputError) as none:
        read_with_truth(tmp_path, "\n".join([nop("52.471", "000")] * 2), "D21/2711", times)
    assert (none.value.code, none.value.pointer) == ("no_usable_rows", "/truth")
    _, many = read_with_truth(tmp_path, "\n".join([nop("52.471")] * 9), "D21/2711", times, ReadLimits(max_rows=8))
    assert "rows_beyond_limit" in [w.code for w in many.warnings]


@pytest.mark.parametrize("kind", [None, "polar_plots"])
def test_as_measurements_they_are_refused(tmp_path: Path, kind: str | None) -> None:
    path = tmp_path / "tracks.txt"
    path.write_text("\n".join([nop("52.471")] * 3), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_recording([NamedFile("tracks.txt", path)], options=ReadOptions.model_validate({"kind": kind}))
    assert refused.value.code == "truth_only"


def test_a_line_of_no_known_system_has_its_code() -> None:
    from backend.files.cells import Problem
    from backend.files.nop_lines import _parse

    found = _parse("gibberish")
    assert isinstance(found, Problem)
    assert found.code == "not_a_report"
