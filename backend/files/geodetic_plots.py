"""Plots given as latitude and longitude become east and north of their radar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pymap3d

from algorithms.errors import InputError
from algorithms.recording import Floats, PolarPlots
from algorithms.site import Origin, Radar
from algorithms.toolbox.frames.between import frame_change
from backend.files.reader import Part
from backend.files.report import Findings


def with_local_plots(part: Part, origin: Origin | None, findings: Findings) -> Part:
    """Turn places in WGS-84 into east and north relative to the radar, or to the zero of the frame where none stands.

    A plot's altitude is its height; without one it is taken at the height of the zero. A radar that is placed in
    WGS-84 has its own north, as for every other plot of it.

    Raises
    ------
    InputError
        Neither the site nor the options give an origin.
    """
    plots, places = part.recording, part.plots_geodetic
    if places is None or not isinstance(plots, PolarPlots):
        return part
    given = np.isfinite(places).all(axis=1) & ~np.isfinite(plots.east_m + plots.north_m)[:, 0]
    site_origin = None if plots.site is None else plots.site.frame_origin()
    frame = origin or site_origin
    if frame is None:
        raise InputError(
            "Plots are given as latitude and longitude, and neither the site nor the options give an origin.",
            pointer="/options/origin",
            remedy="Give the `origin` of the local frame, or a site with the radar's place in WGS-84.",
            code="plots_without_origin",
        )
    altitude = plots.altitude_m[:, 0]
    height = np.where(np.isfinite(altitude), altitude, frame.height_m)
    unknown = int((given & ~np.isfinite(altitude)).sum())
    if unknown:
        findings.warn(
            "plots_without_height",
            "Plots in latitude and longitude without an altitude were taken at the height of the zero.",
            unknown,
        )
    east, north = plots.east_m.copy(), plots.north_m.copy()
    for i, name in enumerate(plots.radars):
        mine = np.flatnonzero(given & (plots.radar == i))
        local = _seen_from(plots, name, places[mine], height[mine], frame)
        moving = np.isfinite(plots.radar_east_m[mine])
        # Where the radar moves, the plot says itself where it was; its place is then counted from the frame's zero.
        own = _enu(places[mine], height[mine], frame)
        own -= np.nan_to_num(np.column_stack([plots.radar_east_m[mine], plots.radar_north_m[mine]]))
        east[mine, 0], north[mine, 0] = np.where(moving[:, None], own, local).T
    return replace(part, recording=replace(plots, east_m=east, north_m=north), plots_geodetic=None)


def _seen_from(plots: PolarPlots, name: str, places: Floats, height: Floats, frame: Origin) -> Floats:
    """(M, 2) east and north of the radar called `name`, m; of the frame's zero where the site does not place it."""
    site = plots.site
    radars: tuple[Radar, ...] = () if site is None else site.radars
    only = len(radars) == 1 and len(plots.radars) == 1
    at = next((i for i, radar in enumerate(radars) if only or radar.name == name), None)
    if site is None or at is None:
        return _enu(places, height, frame)
    radar = radars[at]
    if radar.is_geodetic:
        assert radar.latitude_deg is not None
        assert radar.longitude_deg is not None
        own = Origin(latitude_deg=radar.latitude_deg, longitude_deg=radar.longitude_deg, height_m=radar.height_m or 0.0)
        # East and north in the radar's own plane that lie, in the plane of the frame, where the target is: taken
        # straight from the radar they would move with the height, for the two verticals lean apart.
        change = frame_change(own, frame)
        seen = _enu(places, height, frame) - change.shift_m[:2]
        beside: Floats = np.asarray(np.linalg.solve(change.rotation[:2, :2], seen.T).T, np.float64)
        return beside
    found: Floats = _enu(places, height, frame) - site.radar_positions()[at, :2]
    return found


def _enu(places: Floats, height: Floats, origin: Origin) -> Floats:
    latitude, longitude = np.radians(origin.latitude_deg), np.radians(origin.longitude_deg)
    east, north, _ = pymap3d.geodetic2enu(
        places[:, 0], places[:, 1], height, latitude, longitude, origin.height_m, deg=False
    )
    return np.stack([east, north], axis=1)
