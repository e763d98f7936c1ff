"""Positions of CAT 020, 021 and 062: true paths beside the plots of a radar, or plots themselves where there are none.

WGS-84 positions stay such until the origin of the local frame is known. Where a record gives only coordinates in the
plane of the system, they are taken for local ones, and the report says so.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pymap3d
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints
from algorithms.site import Origin
from backend.files.asterix.fields import named
from backend.files.asterix.plots import Reports, source_name
from backend.files.report import Findings
from backend.files.truth_file import TruthPoints


def truth_points(reports: Reports, time_s: Floats, epoch_s: int | None, findings: Findings) -> TruthPoints:
    """Reference positions as rows of a truth file."""
    numbers = reports.numbers
    target, targets = named(_names(reports))
    height = np.where(np.isfinite(numbers["height"]), numbers["height"], numbers["level"])
    flat = ~np.isfinite(height)
    if flat.any():
        findings.warn(
            "truth_up_zero", "Reference positions without a height or flight level; 0 was used.", int(flat.sum())
        )
    height = np.where(flat, 0.0, height)
    geodetic = np.stack([numbers["latitude"], numbers["longitude"], height], axis=1)
    local = np.stack([numbers["x"], numbers["y"], height], axis=1)
    in_plane = ~np.isfinite(geodetic).all(axis=1)
    local[~in_plane] = np.nan
    if in_plane.any():
        _say_plane(findings, int(in_plane.sum()))
    velocity = np.stack([numbers["velocity_x"], numbers["velocity_y"], np.full(len(reports), np.nan)], axis=1)
    return TruthPoints(
        row=reports.number,
        time_s=time_s,
        epoch_s=epoch_s,
        target=target,
        targets=targets,
        names_targets=True,
        truth_m=local,
        truth_velocity_mps=velocity,
        truth_geodetic=geodetic,
    )


def as_plots(reports: Reports, origin: Origin | None, findings: Findings) -> tuple[Reports, Origin | None]:
    """Give reference positions a place in the plane: east and north of the origin.

    Without an origin the middle of the positions is taken, in whole minutes, so that parts of a recording agree.
    """
    numbers = dict(reports.numbers)
    latitude, longitude = numbers["latitude"], numbers["longitude"]
    geodetic = np.isfinite(latitude) & np.isfinite(longitude)
    if (~geodetic).any():
        _say_plane(findings, int((~geodetic).sum()))
    if not geodetic.any():
        return reports, origin
    if origin is None:
        origin = Origin(
            latitude_deg=round(float(np.degrees(np.median(latitude[geodetic]))), 1),
            longitude_deg=round(float(np.degrees(np.median(longitude[geodetic]))), 1),
        )
        findings.warn(
            "origin_chosen",
            f"Positions in WGS-84 and no origin: {origin.latitude_deg:g}, {origin.longitude_deg:g} degrees near their "
            "middle was taken. The option origin gives another.",
            int(geodetic.sum()),
        )
    height = np.where(np.isfinite(numbers["height"]), numbers["height"], numbers["level"])
    east, north, _ = pymap3d.geodetic2enu(
        latitude,
        longitude,
        np.nan_to_num(height),
        np.radians(origin.latitude_deg),
        np.radians(origin.longitude_deg),
        origin.height_m,
        deg=False,
    )
    numbers["x"] = np.where(geodetic, east, numbers["x"])
    numbers["y"] = np.where(geodetic, north, numbers["y"])
    return replace(reports, numbers=numbers), origin


def target_names(reports: Reports) -> tuple[Ints, tuple[str, ...]]:
    """Index into the names of the targets, by address or else by track number."""
    return named(_names(reports))


def _names(reports: Reports) -> NDArray[np.object_]:
    """The address, else the source with the track number, else nothing."""
    address, track = reports.codes["address"], reports.codes["track"]
    keys = np.where(address >= 0, address, np.where(track >= 0, (1 << 32) + (reports.source + 1) * 65536 + track, -1))
    found, index = np.unique(keys, return_inverse=True)
    words: list[str] = []
    for key in found.tolist():
        if key < 0:
            words.append("unnamed")
        elif key < 1 << 32:
            words.append(f"{key:06X}")
        else:
            source, number = divmod(key - (1 << 32), 65536)
            words.append(f"{source_name(source - 1)} track {number}".strip())
    return np.array(words, object)[index]


def _say_plane(findings: Findings, count: int) -> None:
    findings.warn(
        "reference_plane",
        "Positions in the plane of their system were taken for local coordinates: its reference point is not told, and "
        "the origin should lie there.",
        count,
    )
