"""Plots in latitude and longitude: where they lie must be where the same plots in metres lie."""

from __future__ import annotations

import json
import math

import numpy as np
import pymap3d
import pytest

from algorithms.errors import InputError
from algorithms.recording import PolarPlots
from backend.charts.plots import plot_positions
from backend.files.column_guess import suggest

ORIGIN = {"latitude_deg": 55.0, "longitude_deg": 37.0, "height_m": 150.0}
PLACES = ((55.3, 37.4, 9144.0), (54.8, 36.5, 3048.0))
LOCAL = np.array([pymap3d.geodetic2enu(*p, 55.0, 37.0, 150.0)[:2] for p in PLACES])
TEXT = "time_s,latitude_deg,longitude_deg,altitude_m\n" + "".join(
    f"{i},{lat},{lon},{h}\n" for i, (lat, lon, h) in enumerate(PLACES)
)


def site(**radar: object) -> str:
    return json.dumps({"origin": ORIGIN, "radars": [{"name": "R", **radar}]})


@pytest.mark.parametrize(
    "radar",
    [
        {"east_m": 0, "north_m": 0},
        {"east_m": 20_000, "north_m": -5_000, "up_m": 30},
        {"latitude_deg": 55.2, "longitude_deg": 37.6, "height_m": 200},
    ],
    ids=["at the zero", "elsewhere in the frame", "in WGS-84"],
)
def test_they_lie_where_they_are(read, radar):
    recording, report = read(TEXT, site=site(**radar))
    assert isinstance(recording, PolarPlots)
    where = plot_positions(recording)
    np.testing.assert_allclose(np.column_stack([where.east_m, where.north_m]), LOCAL, atol=1e-6)
    assert report.warnings == ()
    own = recording.site.radar_positions()[0]
    if "east_m" in radar:
        np.testing.assert_allclose(recording.east_m[:, 0], LOCAL[:, 0] - own[0], atol=1e-6)


def test_a_moving_radar_is_taken_off(read):
    head = TEXT.splitlines()
    text = "\n".join(
        line + extra for line, extra in zip(head, (",radar_east_m,radar_north_m", ",100,50", ",200,80"), strict=True)
    )
    recording, _ = read(text, origin=ORIGIN)
    np.testing.assert_allclose(recording.east_m[:, 0], LOCAL[:, 0] - [100, 200], atol=1e-6)
    np.testing.assert_allclose(recording.north_m[:, 0], LOCAL[:, 1] - [50, 80], atol=1e-6)


def test_a_mapping_with_feet_flight_levels_and_radians(read):
    fl = "".join(
        f"{10 * i},{math.radians(lat)!r},{math.radians(lon)!r},{h / 30.48}\n" for i, (lat, lon, h) in enumerate(PLACES)
    )
    mapping = {
        "time_s": "t",
        "latitude_deg": {"column": "phi", "unit": "rad"},
        "longitude_deg": {"column": "lam", "unit": "rad"},
        "altitude_m": {"column": "fl", "unit": "FL"},
    }
    recording, _ = read("t,phi,lam,fl\n" + fl, mapping=mapping, kind="polar_plots", origin=ORIGIN)
    np.testing.assert_allclose(np.column_stack([recording.east_m, recording.north_m]), LOCAL, atol=1e-3)
    np.testing.assert_allclose(recording.altitude_m[:, 0], [9144, 3048])


def test_without_an_altitude_the_height_of_the_origin_is_taken(read, warning):
    text = "time_s,latitude_deg,longitude_deg\n0,55.1,37.1\n1,,\n"
    recording, report = read(text, origin=ORIGIN)
    expected = pymap3d.geodetic2enu(55.1, 37.1, 150.0, 55.0, 37.0, 150.0)
    assert recording.east_m[0, 0] == pytest.approx(expected[0], abs=1e-6)
    assert warning(report, "plots_without_height").count == 1
    assert [(r.row, r.code) for r in report.rejections] == [(2, "missing_value")]


def test_without_an_origin_it_is_asked_for(read):
    with pytest.raises(InputError) as e:
        read(TEXT)
    assert (e.value.code, e.value.pointer) == ("plots_without_origin", "/options/origin")


def test_files_in_either_form_are_one_recording(read):
    local = "time_s,east_m,north_m,altitude_m\n5,100,200,1000\n"
    recording, _ = read(TEXT, local, origin=ORIGIN)
    np.testing.assert_allclose(recording.east_m[:, 0], [*LOCAL[:, 0], 100], atol=1e-6)


def test_places_alone_are_suggested_as_plots_and_beside_ranges_as_truth():
    alone = suggest(("Time", "Lat", "Lon", "FL"), (), None)
    assert alone.kind == "polar_plots"
    assert {"latitude_deg", "longitude_deg"} <= set(alone.mapping)
    beside = suggest(("Time", "Rho", "Theta", "Lat", "Lon"), (), None)
    assert {"true_latitude_deg", "true_longitude_deg"} <= set(beside.mapping)
