"""Lines across the date line, names with any characters, tracks of one point."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np

from algorithms.recording import DopplerPairs
from algorithms.registry import scenarios_by_name
from algorithms.result import Table
from algorithms.site import Origin
from backend.files.geo_tracks import GeoPlace, GeoTrack, estimated_tracks, true_tracks, utc_texts
from backend.files.geojson import write_geojson
from backend.files.kml import write_kml

NAME = 'a <b> & "c"\x01'


def track(position, time_s=None, **more):
    position = np.array(position, float)
    time_s = np.arange(float(len(position))) if time_s is None else np.array(time_s)
    return GeoTrack(
        **{"role": "estimate", "label": "x", "target": "t", "track": "1", **more}, time_s=time_s, position=position
    )


def geojson(*tracks, start_utc=None):
    out = io.StringIO()
    write_geojson(tracks, [GeoPlace(NAME, (37.6, 55.7, 150.0))], out, start_utc=start_utc)
    return json.loads(out.getvalue())["features"]


def test_a_line_is_cut_at_the_date_line():
    _, feature = geojson(track([[179, 10, 0], [-179, 12, 100], [-178, 12, 100], [179.5, 12, 100]]))
    assert feature["geometry"]["type"] == "MultiLineString"
    assert feature["geometry"]["coordinates"] == [
        [[179, 10, 0], [180, 11, 50]],
        [[-180, 11, 50], [-179, 12, 100], [-178, 12, 100], [-180, 12, 100]],
        [[180, 12, 100], [179.5, 12, 100]],
    ]
    assert feature["properties"]["time_s"] == [[0, 0.5], [0.5, 1, 2, 2.8], [2.8, 3]]


def test_a_track_of_one_point_is_a_point():
    _, feature = geojson(track([[1, 2, 3]], [4.5]), start_utc="2026-03-01T12:00:00Z")
    assert feature["geometry"] == {"type": "Point", "coordinates": [1, 2, 3]}
    assert feature["properties"]["coordTimes"] == ["2026-03-01T12:00:04.500Z"]


def test_instants_have_milliseconds():
    texts = utc_texts(np.array([-0.0004, 0.0996, 86400.0]), "2026-03-01T12:00:00.25Z")
    assert texts == ["2026-03-01T12:00:00.250Z", "2026-03-01T12:00:00.350Z", "2026-03-02T12:00:00.250Z"]


def test_rows_without_an_estimate_are_no_part_of_a_track():
    states = Table(
        {
            "label": ["b", "b", "a", "b"],
            "trial": np.full(4, np.nan),
            "track": np.array([1, 1, np.nan, 2.0]),
            "time_s": np.array([2.0, 1.0, 0.0, 3.0]),
            "east_m": np.array([10, 0, np.nan, 20.0]),
            "north_m": np.array([0, 0, 0, 0.0]),
            "up_m": np.array([np.nan, 5, 0, 0.0]),
            "target": [None, None, "q", "q"],
        }
    )
    found = list(estimated_tracks(states, Origin(latitude_deg=0, longitude_deg=180)))
    assert [(t.label, t.target, t.track, t.time_s.tolist()) for t in found] == [
        ("b", "", "1", [1.0, 2.0]),
        ("b", "q", "2", [3.0]),
    ]
    # Ten metres east of the date line.
    np.testing.assert_allclose(found[0].position[:, 0], [-180, -180 + np.degrees(10 / 6378137)], atol=1e-9)
    np.testing.assert_allclose(found[0].position[:, 2], [5, 0], atol=1e-4)


def test_names_of_any_characters_are_xml():
    out = io.StringIO()
    write_kml(
        [track([[1, 2, 3]], target=NAME, label=NAME)],
        [GeoPlace(NAME, (37.6, 55.7, 150.0))],
        out,
        name=NAME,
        labels=[NAME],
        start_utc="2026-03-01T12:00:00Z",
    )
    names = [e.text for e in ElementTree.fromstring(out.getvalue()).iter("{http://www.opengis.net/kml/2.2}name")]
    assert names.count(NAME.replace("\x01", "\ufffd")) == 4
    assert "not known" not in out.getvalue()


def _passes(**more):
    scenario = scenarios_by_name()["forward_scatter_pass"]
    recording = scenario.simulate(scenario.parameters(targets=3, target_interval_s=60.0), (0,), 1)
    assert isinstance(recording, DopplerPairs)
    return replace(recording, **more)


def test_true_paths_of_targets_without_names_are_paths_of_their_own():
    found = _passes()
    nobody = replace(found, target=np.zeros(len(found), np.int64), targets=("",))
    origin = Origin(latitude_deg=55, longitude_deg=37, height_m=0)
    named = list(true_tracks(found, origin))
    unnamed = list(true_tracks(nobody, origin))
    assert len(named) == len(unnamed) == 3
    for one, other in zip(named, unnamed, strict=True):
        np.testing.assert_array_equal(one.position, other.position)
    still = replace(nobody, truth_velocity_mps=np.full((len(found), 3), np.nan))
    assert len(list(true_tracks(still, origin))) == 3, "without velocities by the step before"


def test_a_named_target_that_leaps_stays_one_path():
    found = _passes()
    one = replace(found, target=np.zeros(len(found), np.int64), targets=("A",))
    assert len(list(true_tracks(one, Origin(latitude_deg=55, longitude_deg=37, height_m=0)))) == 1
