"""Several recordings as one: the same targets seen by radars in frames of their own must lie on each other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pymap3d
import pytest

from algorithms.errors import InputError
from algorithms.recording import PolarPlots, ToaMarks, TruthTracks
from algorithms.site import Origin, Site
from algorithms.toolbox.frames.between import frame_change
from backend.charts.plots import plot_positions
from backend.files.joining import join_recordings

A = Origin(latitude_deg=55.0, longitude_deg=37.0, height_m=150.0)
B = Origin(latitude_deg=55.6, longitude_deg=39.0, height_m=90.0)
# Targets as latitude, longitude, height.
TARGETS = np.array([[55.4, 38.1, 9000.0], [55.9, 38.4, 4000.0], [54.9, 37.6, 11000.0]])


def site(origin: Origin | None = None, **radar: Any) -> Site:
    place = {"name": "radar", "east_m": 0.0, "north_m": 0.0, "up_m": 0.0} | radar
    return Site.model_validate({"origin": None if origin is None else origin.model_dump(), "radars": [place]})


def seen_from(where: Site, start_utc: str | None = None, *, own_north: bool = False) -> PolarPlots:
    """Plots of the targets, one a second, by the site's radar, azimuths from the north of its frame or its own."""
    origin = where.frame_origin()
    assert origin is not None
    of_frame = np.column_stack(
        pymap3d.geodetic2enu(*TARGETS.T, origin.latitude_deg, origin.longitude_deg, origin.height_m)
    )
    if own_north:
        radar = where.radars[0]
        local = np.column_stack(
            pymap3d.geodetic2enu(*TARGETS.T, radar.latitude_deg, radar.longitude_deg, radar.height_m)
        )
    else:
        local = of_frame - where.radar_positions()[0]
    return plots(local, where, start_utc, truth_m=of_frame)


def plots(local_m: np.ndarray, where: Site | None, start_utc: str | None = None, **more: Any) -> PolarPlots:
    m = len(local_m)
    nothing = np.full((m, 1), np.nan)
    east, north, up = local_m.T
    fields = {
        "range_m": np.linalg.norm(local_m, axis=1)[:, None],
        "azimuth_rad": np.mod(np.arctan2(east, north), 2 * np.pi)[:, None],
        "elevation_rad": np.arctan2(up, np.hypot(east, north))[:, None],
        "altitude_m": nothing,
        "east_m": nothing,
        "north_m": nothing,
        "radar_east_m": np.full(m, np.nan),
        "radar_north_m": np.full(m, np.nan),
        "target": np.arange(m),
        "targets": tuple(str(1 + i) for i in range(m)),
    }
    return PolarPlots(
        **{
            "time_s": np.arange(m, dtype=float),
            "row": np.arange(1, m + 1),
            "radar": np.zeros(m, np.int64),
            "scan": np.full(m, -1),
            "address": np.full(m, -1),
            "callsign": np.full(m, -1),
            "site": where,
            "start_utc": start_utc,
            **fields,
            **more,
        }
    )


def test_a_point_goes_from_frame_to_frame_as_by_the_ellipsoid() -> None:
    p = np.array([[1000.0, -2000.0, 300.0], [np.nan, 0.0, 0.0]])
    ecef = pymap3d.enu2ecef(*p[0], B.latitude_deg, B.longitude_deg, B.height_m)
    expected = pymap3d.ecef2enu(*ecef, A.latitude_deg, A.longitude_deg, A.height_m)
    moved = frame_change(B, A).points(p)
    np.testing.assert_allclose(moved[0], expected, atol=1e-6)
    assert np.isnan(moved[1]).all()
    # Two degrees of longitude farther east, the meridian leans to the west: 2 sin 55.6 degrees.
    np.testing.assert_allclose(np.degrees(frame_change(B, A).turn_rad), -1.650, atol=0.01)
    np.testing.assert_allclose(frame_change(A, B).points(moved)[0], p[0], atol=1e-6)


@pytest.mark.parametrize("away_m", [0.0, 40_000.0])
def test_plots_of_two_frames_lie_on_each_other(away_m: float) -> None:
    # The second radar stands away from the zero of its frame, and its azimuths count from that frame's north.
    first, second = seen_from(site(A)), seen_from(site(B, east_m=away_m, north_m=-away_m / 2, up_m=20.0))
    joined = join_recordings([("one", first), ("other", second)]).recording
    where = plot_positions(joined)
    for target in range(len(TARGETS)):
        east, north = where.east_m[joined.target == target], where.north_m[joined.target == target]
        assert len(east) == 2
        # The vertical of a radar placed in WGS-84 leans by away_m / R from its frame's: metres, not hundreds of them.
        np.testing.assert_allclose(east[1], east[0], atol=0.01 + away_m * 2.5e-3)
        np.testing.assert_allclose(north[1], north[0], atol=0.01 + away_m * 2.5e-3)
    np.testing.assert_allclose(joined.truth_m[joined.row <= 3], joined.truth_m[joined.row > 3], atol=1e-6)


def test_a_radar_in_wgs84_keeps_its_north() -> None:
    place = {"east_m": None, "north_m": None, "up_m": None}
    geodetic = site(
        None, name="B", latitude_deg=B.latitude_deg, longitude_deg=B.longitude_deg, height_m=B.height_m, **place
    )
    second = seen_from(geodetic, own_north=True)
    joined = join_recordings([("one", seen_from(site(A))), ("other", second)]).recording
    np.testing.assert_array_equal(joined.azimuth_rad[joined.row > 3], second.azimuth_rad)
    where = plot_positions(joined)
    np.testing.assert_allclose(where.east_m[joined.row > 3], where.east_m[joined.row <= 3], atol=0.01)
    np.testing.assert_allclose(where.north_m[joined.row > 3], where.north_m[joined.row <= 3], atol=0.01)


def test_a_moving_radar_moves_with_its_frame() -> None:
    truth = np.column_stack(pymap3d.geodetic2enu(*TARGETS.T, B.latitude_deg, B.longitude_deg, B.height_m))
    own = np.array([[0.0, 0.0, 0.0], [100.0, 50.0, 0.0], [200.0, 100.0, 0.0]])
    local = truth - own
    cartesian = plots(
        local,
        Site(origin=B),
        radar_east_m=own[:, 0],
        radar_north_m=own[:, 1],
        east_m=local[:, :1],
        north_m=local[:, 1:2],
        radars=("ship",),
        truth_m=truth,
    )
    joined = join_recordings([("one", seen_from(site(A))), ("other", cartesian)]).recording
    mine = joined.row > 3
    change = frame_change(B, A)
    np.testing.assert_allclose(
        np.column_stack([joined.radar_east_m, joined.radar_north_m])[mine], change.points(own)[:, :2], atol=1e-6
    )
    turned = np.column_stack([joined.east_m, joined.north_m])[mine]
    # What the height adds by the tilt of the vertical is left out on both sides.
    flat = change.vectors(np.column_stack([local[:, :2], np.zeros(3)]))[:, :2]
    np.testing.assert_allclose(turned, flat, rtol=2e-3, atol=1.0)
    assert joined.radars == ("radar", "ship")


def test_names_rows_and_times_are_told_apart() -> None:
    first = seen_from(site(A), "2026-01-01T00:00:10Z")
    second = seen_from(site(B), "2026-01-01T00:00:09Z")
    joined = join_recordings([("one", first), ("other", second)])
    one = joined.recording
    assert one.site is not None
    assert [r.name for r in one.site.radars] == ["radar", "radar (2)"]
    assert one.radars == ("radar", "radar (2)")
    assert one.start_utc == "2026-01-01T00:00:09Z"
    assert one.time_s.tolist() == [0.0, 1.0, 1.0, 2.0, 2.0, 3.0]
    assert one.row.tolist() == [4, 1, 5, 2, 6, 3]
    assert joined.first_rows == (1, 4)
    assert [n.code for n in joined.notes] == ["radar_renamed", "rows_numbered_on"]
    assert joined.notes[0].detail == "Radar 'radar' of 'other' is called 'radar (2)'."


def test_recordings_of_one_site_share_its_radars() -> None:
    two = Site.model_validate(
        {
            "radars": [
                {"name": n, "east_m": e, "north_m": 0.0, "sigma_range_m": 30.0} for n, e in (("R1", 0.0), ("R2", 2e4))
            ]
        }
    )
    local = np.array([[1e4, 1e4, 0.0]])
    parts = [(n, plots(local, two, radars=(n,))) for n in ("R1", "R2")]
    joined = join_recordings(parts)
    assert joined.recording.site == two
    assert joined.recording.radars == ("R1", "R2")
    assert joined.recording.radar.tolist() == [0, 1]
    assert [n.code for n in joined.notes] == ["same_site", "one_clock", "rows_numbered_on"]


def test_local_frames_without_an_origin_are_one_where_the_radars_stand_apart() -> None:
    local = np.array([[1e4, 1e4, 0.0]])
    apart = [("a", plots(local, site(name="R1"))), ("b", plots(local, site(name="R2", east_m=3e4)))]
    joined = join_recordings(apart)
    assert joined.recording.site is not None
    assert joined.recording.site.origin is None
    np.testing.assert_allclose(plot_positions(joined.recording).east_m, [1e4, 4e4])
    assert "one_local_frame" in [n.code for n in joined.notes]


LOCAL = np.array([[1e4, 1e4, 0.0]])


@pytest.mark.parametrize(
    ("second", "code", "pointer"),
    [
        (plots(LOCAL, None), "site_missing", "/1/site"),
        (plots(LOCAL, site(name="other")), "origin_missing", "/1/site/origin"),
        (plots(LOCAL, site(B), "2026-01-01T00:00:00Z"), "origin_missing", "/0/site/origin"),
        (
            ToaMarks(
                time_s=np.zeros(1),
                row=np.ones(1, np.int64),
                target=np.zeros(1, np.int64),
                toa_s=np.zeros((1, 1, 1)),
                altitude_m=np.zeros((1, 1)),
                stations=("s",),
            ),
            "mixed_kinds",
            "/1",
        ),
        (
            plots(
                LOCAL,
                Site.model_validate(
                    {"radars": [{"name": n, "east_m": e, "north_m": 1.0} for n, e in (("x", 1), ("y", 5))]}
                ),
            ),
            "radar_without_place",
            "/1/site/radars",
        ),
    ],
)
def test_what_cannot_be_joined_names_the_recording_and_its_field(second: Any, code: str, pointer: str) -> None:
    with pytest.raises(InputError) as e:
        join_recordings([("one", plots(LOCAL, site())), ("other", second)])
    assert (e.value.code, e.value.pointer) == (code, pointer)


def test_an_unknown_start_beside_a_known_one_is_refused() -> None:
    with pytest.raises(InputError) as e:
        join_recordings([("one", seen_from(site(A), "2026-01-01T00:00:00Z")), ("other", seen_from(site(B)))])
    assert (e.value.code, e.value.pointer) == ("mixed_time_bases", "/1/start_utc")


def path(times: list[float], height: float, name: str) -> TruthTracks:
    m = len(times)
    position = np.column_stack([np.array(times), np.zeros(m), np.full(m, height)])
    return TruthTracks(
        time_s=np.array(times), target=np.zeros(m, np.int64), position_m=position,
        velocity_mps=np.full((m, 3), np.nan), targets=(name,),
    )  # fmt: skip


def test_a_path_that_two_recordings_tell_is_taken_once() -> None:
    first = replace(seen_from(site(A)), truth_tracks=path([0.0, 1.0, 2.0], 0.0, "1"))
    second = replace(seen_from(site(A, name="B", east_m=5.0)), truth_tracks=path([1.0, 2.0, 3.0], 7.0, "1"))
    joined = join_recordings([("one", first), ("other", second)])
    tracks = joined.recording.truth_tracks
    assert tracks is not None
    assert tracks.targets == ("1",)
    assert tracks.time_s.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert tracks.position_m[:, 2].tolist() == [0.0, 0.0, 0.0, 7.0]
    assert [(n.code, n.count) for n in joined.notes if n.code == "truth_told_twice"] == [("truth_told_twice", 2)]
