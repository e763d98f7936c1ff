"""Files as radars and people leave them: units, order, a radar that moves, an antenna that stops; up to the tracks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.errors import InputError
from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.tracks import life_cycle
from backend.files.reading import NamedFile, ReadOptions, ReadReport, read_recording

ACCURACY: dict[str, Any] = {"sigma_range_m": 100.0, "sigma_azimuth_deg": 0.1}
ALTITUDE_M = 4572.0
SHIP_MPS = 12.0
SITE = (
    b'{"radars": [{"name": "A", "east_m": 0, "north_m": 0, "up_m": 0, "sigma_range_m": 100, "sigma_azimuth_deg": 0.1}]}'
)


@dataclass
class Flight:
    """Plots (n,) of one aircraft from a radar at rest, and from one that moves north."""

    time_s: np.ndarray
    place: np.ndarray
    noise: np.ndarray

    def polar(self, north_m: np.ndarray | float = 0.0, altitude_m: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        east, north = self.place[:, 0], self.place[:, 1] - north_m
        rho = np.sqrt(east**2 + north**2 + altitude_m**2) + 100.0 * self.noise[0]
        return rho, np.mod(np.degrees(np.arctan2(east, north)) + 0.1 * self.noise[1], 360.0)


def flight(scans: int = 40) -> Flight:
    time = 5.0 * np.arange(scans)
    place = np.stack([-20e3 + 180.0 * time, 9e3 + 40.0 * time], axis=1)
    return Flight(time, place, np.random.default_rng(9).standard_normal((2, scans)))


def read(folder: Path, columns: dict[str, Any], mapping: dict[str, Any] | None = None, site: bytes | None = None,
         order: np.ndarray | None = None) -> tuple[PolarPlots, ReadReport]:  # fmt: skip
    rows = np.stack([np.asarray(c, float) for c in columns.values()], axis=1)
    rows = rows if order is None else rows[order]
    text = ",".join(columns) + "\n" + "\n".join(",".join(repr(float(v)) for v in row) for row in rows) + "\n"
    path = folder / "plots.csv"
    path.write_text(text, encoding="utf-8")
    recording, report = read_recording(
        [NamedFile(path.name, path)], site=site, options=ReadOptions(kind="polar_plots", mapping=mapping or {})
    )
    assert isinstance(recording, PolarPlots)
    return recording, report


TRACKERS: dict[str, Callable[[PolarPlots], Result]] = {
    "joint": lambda r: imm_tracker.run(r, ImmParameters(**ACCURACY), LocalContext()),
    "curvature": lambda r: curvature_tracker.run(r, CurvatureParameters(**ACCURACY), LocalContext()),
}
each = pytest.mark.parametrize("tracker", TRACKERS.values(), ids=TRACKERS)


def error_of(result: Result, truth: Flight) -> float:
    """Rms error of the second half of a single track's estimates, m."""
    a = result.arrays
    assert set(a["estimate_track"].tolist()) == {1}
    late = a["estimate_time_s"] > truth.time_s[-1] / 2
    true = [np.interp(a["estimate_time_s"][late], truth.time_s, truth.place[:, i]) for i in (0, 1)]
    return float(np.sqrt(np.mean(np.sum((a["estimate_state"][late, :2].T - true) ** 2, axis=0))))


@each
def test_azimuths_in_parts_of_a_turn(tracker: Callable[[PolarPlots], Result], tmp_path: Path) -> None:
    truth = flight()
    rho, azimuth = truth.polar()
    parts = np.round(azimuth / 360 * 65536) % 65536
    columns = {"time_s": truth.time_s, "range_m": rho, "acp": parts}
    recording, _ = read(tmp_path, columns, {"azimuth_deg": {"column": "acp", "unit": "turn/65536"}})
    assert error_of(tracker(recording), truth) < 100
    # The same numbers taken for degrees are refused row by row, or where they are used; never tracked.
    with pytest.raises(InputError) as caught:
        tracker(read(tmp_path, columns, {"azimuth_deg": "acp"})[0])
    assert caught.value.code in ("azimuth_unit", "no_usable_rows")


@each
@pytest.mark.parametrize(("unit", "metres"), [("ft", 0.3048), ("FL", 30.48), ("m", 1.0)])
def test_altitudes_in_feet_and_flight_levels(
    tracker: Callable[[PolarPlots], Result], unit: str, metres: float, tmp_path: Path
) -> None:
    truth = flight()
    rho, azimuth = truth.polar(altitude_m=ALTITUDE_M)
    columns = {"time_s": truth.time_s, "range_m": rho, "azimuth_deg": azimuth,
               "height": np.full(rho.size, ALTITUDE_M / metres)}  # fmt: skip
    recording, _ = read(tmp_path, columns, {"altitude_m": {"column": "height", "unit": unit}}, SITE)
    assert np.allclose(recording.altitude_m, ALTITUDE_M)
    assert error_of(tracker(recording), truth) < 120
    if unit == "ft":
        # Feet taken for metres: a range below the altitude is left out and counted, the rest is far off.
        wrong, _ = read(tmp_path, columns, {"altitude_m": {"column": "height", "unit": "m"}}, SITE)
        result = tracker(wrong)
        noted = sum(note.count for note in result.notes if note.code == "range_below_altitude")
        assert noted > 0
        assert noted == int((rho < ALTITUDE_M / metres).sum())


@each
def test_rows_and_scans_out_of_order_make_the_same_tracks(
    tracker: Callable[[PolarPlots], Result], tmp_path: Path
) -> None:
    truth = flight()
    rho, azimuth = truth.polar()
    columns = {"time_s": truth.time_s, "range_m": rho, "azimuth_deg": azimuth, "scan": np.arange(rho.size) + 1.0}
    plain, report = read(tmp_path, columns)
    assert "rows_out_of_order" not in [w.code for w in report.warnings]
    shuffled, report = read(tmp_path, columns, order=np.random.default_rng(3).permutation(rho.size))
    assert "rows_out_of_order" in [w.code for w in report.warnings]
    a, b = tracker(plain).arrays, tracker(shuffled).arrays
    assert a["estimate_state"].tobytes() == b["estimate_state"].tobytes()


@each
def test_an_antenna_that_stops_and_goes_on(tracker: Callable[[PolarPlots], Result], tmp_path: Path) -> None:
    truth = flight()
    rho, azimuth = truth.polar()
    columns = {"time_s": truth.time_s, "range_m": rho, "azimuth_deg": azimuth}
    kept = np.flatnonzero((truth.time_s < 60) | (truth.time_s >= 120))
    result = tracker(read(tmp_path, columns, order=kept)[0])
    a = result.arrays
    assert set(a["estimate_track"].tolist()) == {1, 2}
    dropped = (a["event_state"] == life_cycle.DROPPED) & (a["event_track"] == 1)
    assert a["event_reason"][dropped].tolist() == [life_cycle.SENSOR_SILENT]
    # Nobody invents places for the time in which nothing was looked at.
    assert not ((a["estimate_time_s"] > 56) & (a["estimate_time_s"] < 119)).any()
    # A stop of one scan is coasted over.
    short = np.flatnonzero((truth.time_s < 60) | (truth.time_s >= 65))
    assert error_of(tracker(read(tmp_path, columns, order=short)[0]), truth) < 100


@each
def test_a_radar_that_moves(tracker: Callable[[PolarPlots], Result], tmp_path: Path) -> None:
    truth = flight()
    ship = SHIP_MPS * truth.time_s
    rho, azimuth = truth.polar(ship)
    columns = {"time_s": truth.time_s, "range_m": rho, "azimuth_deg": azimuth}
    told, _ = read(tmp_path, {**columns, "radar_east_m": 0.0 * ship, "radar_north_m": ship})
    assert error_of(tracker(told), truth) < 100
    # Taken for one at rest it is off by the way of the ship.
    untold, _ = read(tmp_path, columns)
    assert error_of(tracker(untold), truth) > 1000
