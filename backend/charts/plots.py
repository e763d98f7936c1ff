"""Where the plots of a radar lie in the plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymap3d
from numpy.typing import NDArray

from algorithms.recording import AntennaPlots, PolarPlots
from algorithms.toolbox.frames.bicone import antenna_axes, position_from_bicone
from algorithms.toolbox.frames.slant import ground_from_slant
from backend.charts.columns import Floats


@dataclass(frozen=True)
class PlotPositions:
    """(plot,) east and north in the site's frame, m; how many slant ranges were taken for ground ranges."""

    east_m: Floats
    north_m: Floats
    slant_as_ground: int
    radar_at_origin: bool


def antenna_positions(recording: AntennaPlots) -> Floats:
    """(plot, 3) m in the site's frame, of the first trial; NaN outside the domain and where the antenna is unknown."""
    radars = () if recording.site is None else recording.site.radars
    if recording.site is None or not radars or radars[0].azimuth_deg is None or radars[0].elevation_deg is None:
        return np.full((len(recording), 3), np.nan)
    axes = antenna_axes(np.radians(radars[0].azimuth_deg), np.radians(radars[0].elevation_deg))
    measured = (recording.range_m, recording.bicone_elevation_rad, recording.bicone_azimuth_rad)
    range_m, elevation, azimuth = (values[:, 0] for values in measured)
    return position_from_bicone(range_m, elevation, azimuth, axes, recording.site.radar_positions()[0])


def plot_positions(recording: PolarPlots | AntennaPlots) -> PlotPositions:
    """Convert range and azimuth, or an antenna's range and angles, of the first trial to the plane.

    A slant range is projected by the elevation or, failing that, by the altitude over a sphere; where neither is
    known, or no point at that range has that altitude, it is taken as it is, and counted. East and north at a radar
    that is placed in WGS-84 are turned into those of the site: a degree of longitude away north differs by most of
    a degree.
    """
    if isinstance(recording, AntennaPlots):
        east, north, _ = antenna_positions(recording).T
        return PlotPositions(east, north, 0, False)
    radar_east, radar_north, altitude_of_radar, is_ground, known = _radars(recording)
    range_m, azimuth = recording.range_m[:, 0], recording.azimuth_rad[:, 0]
    elevation, altitude = recording.elevation_rad[:, 0], recording.altitude_m[:, 0]
    by_altitude, height = ground_from_slant(range_m, altitude, altitude_of_radar)
    has_elevation = np.isfinite(elevation)
    ground = np.where(has_elevation, range_m * np.cos(elevation), by_altitude)
    up = np.where(has_elevation, range_m * np.sin(elevation), np.where(np.isfinite(by_altitude), height, 0.0))
    unknown = ~is_ground & ~np.isfinite(ground) & np.isfinite(range_m)
    ground = np.where(is_ground | unknown, range_m, ground)
    east, north = recording.east_m[:, 0], recording.north_m[:, 0]
    cartesian = np.isfinite(east) & np.isfinite(north)
    east = np.where(cartesian, east, ground * np.sin(azimuth))
    north = np.where(cartesian, north, ground * np.cos(azimuth))
    east, north, turned = _in_site_frame(recording, east, north, np.where(cartesian, 0.0, up))
    return PlotPositions(
        np.where(turned, east, radar_east + east),
        np.where(turned, north, radar_north + north),
        int((unknown & ~cartesian).sum()),
        not known,
    )


def radar_place(recording: PolarPlots) -> tuple[float, float]:
    """East and north of the first radar at the recording's first plot, m."""
    east, north, *_ = _radars(recording)
    return float(np.ravel(east)[0]), float(np.ravel(north)[0])


def _in_site_frame(
    recording: PolarPlots, east: Floats, north: Floats, up: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """East and north of the site for the plots of radars that are placed in WGS-84, and which those are."""
    site = recording.site
    turned = np.zeros(len(recording), bool)
    origin = None if site is None else site.frame_origin()
    if site is None or origin is None:
        return east, north, turned
    east, north = east.copy(), north.copy()
    for i, name in enumerate(recording.radars):
        radar = site.radars[index] if (index := _index(recording).get(name)) is not None else None
        if radar is None or not radar.is_geodetic:
            continue
        mine = np.flatnonzero((recording.radar == i) & np.isnan(recording.radar_east_m))
        ecef = pymap3d.enu2ecef(
            east[mine], north[mine], up[mine], radar.latitude_deg, radar.longitude_deg, radar.height_m or 0.0
        )
        enu = pymap3d.ecef2enu(*ecef, origin.latitude_deg, origin.longitude_deg, origin.height_m)
        east[mine], north[mine], turned[mine] = enu[0], enu[1], True
    return east, north, turned


def _index(recording: PolarPlots) -> dict[str, int]:
    """Name of a radar in the recording -> its place in the site; a single one needs no name."""
    site = recording.site
    index = {} if site is None else {radar.name: i for i, radar in enumerate(site.radars)}
    if site is not None and len(site.radars) == 1 and len(recording.radars) == 1:
        index[recording.radars[0]] = 0
    return index


def _radars(recording: PolarPlots) -> tuple[Floats, Floats, Floats, NDArray[np.bool_], bool]:
    """Position and altitude of each plot's radar, whether its ranges are ground ranges, whether all are placed."""
    site = recording.site
    index = _index(recording)
    origin = None if site is None else site.frame_origin()
    altitudes = np.zeros(len(recording.radars))
    places = np.zeros((len(recording.radars), 3))
    ground = np.zeros(len(recording.radars), bool)
    placed = np.zeros(len(recording.radars), bool)
    for i, name in enumerate(recording.radars):
        if site is not None and name in index:
            places[i] = site.radar_positions()[index[name]]
            radar = site.radars[index[name]]
            # Up counts from the origin, an altitude from the sea.
            above = places[i, 2] + (0.0 if origin is None else origin.height_m)
            altitudes[i] = (radar.height_m or 0.0) if radar.is_geodetic else above
            ground[i] = site.radars[index[name]].range_kind == "ground"
            placed[i] = True
    here, of = places[recording.radar], placed[recording.radar]
    moving = np.isfinite(recording.radar_east_m) & np.isfinite(recording.radar_north_m)
    return (
        np.where(moving, recording.radar_east_m, here[:, 0]),
        np.where(moving, recording.radar_north_m, here[:, 1]),
        altitudes[recording.radar],
        ground[recording.radar],
        bool((of | moving).all()),
    )
