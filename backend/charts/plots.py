"""Where the plots of a radar lie in the plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import PolarPlots
from backend.charts.columns import Floats


@dataclass(frozen=True)
class PlotPositions:
    """(plot,) east and north in the site's frame, m; how many slant ranges were taken for ground ranges."""

    east_m: Floats
    north_m: Floats
    slant_as_ground: int
    radar_at_origin: bool


def plot_positions(recording: PolarPlots) -> PlotPositions:
    """Convert range and azimuth of the first trial to the plane.

    A slant range is projected by the elevation or, failing that, by the altitude above the radar (over a flat earth:
    the error is below 0.1 % of the range up to 100 km); where neither is known it is taken as it is, and counted.
    """
    radar_east, radar_north, radar_up, is_ground, known = _radars(recording)
    range_m, azimuth = recording.range_m[:, 0], recording.azimuth_rad[:, 0]
    elevation, altitude = recording.elevation_rad[:, 0], recording.altitude_m[:, 0]
    with np.errstate(invalid="ignore"):
        by_altitude = np.sqrt(np.maximum(range_m**2 - (altitude - radar_up) ** 2, 0.0))
        ground = np.where(np.isfinite(elevation), range_m * np.cos(elevation), by_altitude)
    unknown = ~is_ground & ~np.isfinite(ground) & np.isfinite(range_m)
    ground = np.where(is_ground | unknown, range_m, ground)
    east, north = recording.east_m[:, 0], recording.north_m[:, 0]
    cartesian = np.isfinite(east) & np.isfinite(north)
    return PlotPositions(
        radar_east + np.where(cartesian, east, ground * np.sin(azimuth)),
        radar_north + np.where(cartesian, north, ground * np.cos(azimuth)),
        int((unknown & ~cartesian).sum()),
        not known,
    )


def _radars(recording: PolarPlots) -> tuple[Floats, Floats, Floats, NDArray[np.bool_], bool]:
    """Position of each plot's radar, whether its ranges are ground ranges, whether every position is known."""
    site = recording.site
    index = {} if site is None else {radar.name: i for i, radar in enumerate(site.radars)}
    if site is not None and len(site.radars) == 1 and len(recording.radars) == 1:
        index[recording.radars[0]] = 0
    places = np.zeros((len(recording.radars), 3))
    ground = np.zeros(len(recording.radars), bool)
    placed = np.zeros(len(recording.radars), bool)
    for i, name in enumerate(recording.radars):
        if site is not None and name in index:
            places[i] = site.radar_positions()[index[name]]
            ground[i] = site.radars[index[name]].range_kind == "ground"
            placed[i] = True
    here, of = places[recording.radar], placed[recording.radar]
    moving = np.isfinite(recording.radar_east_m) & np.isfinite(recording.radar_north_m)
    return (
        np.where(moving, recording.radar_east_m, here[:, 0]),
        np.where(moving, recording.radar_north_m, here[:, 1]),
        here[:, 2],
        ground[recording.radar],
        bool((of | moving).all()),
    )
