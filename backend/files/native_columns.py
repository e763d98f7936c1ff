"""The columns of native CSV: what each kind needs, what it may have, and how the kind is told from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import get_close_matches

from algorithms.errors import InputError
from algorithms.recording import Kind
from backend.files.report import some
from backend.files.selection import NameColumn, Quantity

# A reception further from its gate than this is no offset from it: probably a time of day or of the epoch.
LARGEST_OFFSET_NS = 1e10
TOA_COLUMN = re.compile(r"toa_(.+)_ns", re.DOTALL)
CHANNEL_SETS = (("1",), ("1", "2"), ("11", "12", "21", "22"))

_ALTITUDE = Quantity("altitude_m", -2_000, 1e8)
_RANGE = Quantity("range_m", 0, 1e9)
QUANTITIES: dict[Kind, tuple[Quantity, ...]] = {
    "toa_marks": (_ALTITUDE,),
    "polar_plots": (
        _RANGE,
        Quantity("azimuth_deg", -360, 360),
        Quantity("elevation_deg", -90, 90),
        Quantity("east_m"),
        Quantity("north_m"),
        Quantity("latitude_deg", -90, 90),
        Quantity("longitude_deg", -180, 360),
        _ALTITUDE,
        Quantity("radar_east_m"),
        Quantity("radar_north_m"),
        Quantity("scan", 0, 1e15, whole=True),
    ),
    "antenna_plots": (
        Quantity("range_m", 0, 1e9, required=True),
        Quantity("bicone_elevation_deg", -180, 180, required=True),
        Quantity("bicone_azimuth_deg", -180, 180, required=True),
    ),
    "doppler_pairs": (
        *(Quantity(f"doppler_{c}_hz", -1e12, 1e12) for c in ("1", "2", "11", "12", "21", "22")),
        Quantity("azimuth_deg", -360, 360),
        Quantity("elevation_deg", -90, 90),
        Quantity("doppler_rate_1_hz_s", -1e12, 1e12),
        Quantity("doppler_rate_2_hz_s", -1e12, 1e12),
    ),
}
# What tells where a plot is.
PLACES = (("range_m", "azimuth_deg"), ("east_m", "north_m"), ("latitude_deg", "longitude_deg"))
NAMES: dict[Kind, tuple[NameColumn, ...]] = {
    "toa_marks": (NameColumn("target", unnamed=True), NameColumn("emitter_type")),
    "polar_plots": (
        NameColumn("target", unnamed=True),
        NameColumn("radar", unnamed=True),
        NameColumn("address"),
        NameColumn("callsign"),
        NameColumn("mode_3a"),
    ),
    "antenna_plots": (NameColumn("target", unnamed=True),),
    "doppler_pairs": (NameColumn("target", unnamed=True),),
}


def kinds_of(names: Sequence[str]) -> list[Kind]:
    """Kinds whose own columns are among the names."""
    found: list[Kind] = []
    if any(TOA_COLUMN.fullmatch(n) for n in names):
        found.append("toa_marks")
    if "bicone_elevation_deg" in names or "bicone_azimuth_deg" in names:
        found.append("antenna_plots")
    elif any(set(pair) <= set(names) for pair in PLACES):
        found.append("polar_plots")
    if any(n in names for n in ("doppler_1_hz", "doppler_11_hz")):
        found.append("doppler_pairs")
    return found


def check_columns(kind: Kind, names: Sequence[str], known: Sequence[str]) -> None:
    """Raise InputError where `names` lack a column that the kind needs."""
    offered = set(names)
    lacking: list[str] = [] if "time_s" in offered else ["time_s"]
    if kind == "toa_marks" and not any(TOA_COLUMN.fullmatch(n) for n in names):
        lacking.append("toa_<station>_ns")
    if kind == "polar_plots" and not any(set(pair) <= offered for pair in PLACES[1:]):
        lacking += [n for n in ("range_m", "azimuth_deg") if n not in offered]
    if kind == "antenna_plots":
        lacking += [q.name for q in QUANTITIES[kind] if q.required and q.name not in offered]
    if kind == "doppler_pairs":
        channels = tuple(c for c in ("1", "2", "11", "12", "21", "22") if f"doppler_{c}_hz" in offered)
        if channels not in CHANNEL_SETS:
            raise InputError(
                f"doppler_pairs with the channels {some(channels) or 'none'}: the columns must be doppler_1_hz, "
                "with doppler_2_hz or without, or all of doppler_11_hz, doppler_12_hz, doppler_21_hz, doppler_22_hz.",
                pointer="/file",
                remedy="Add or rename the columns, or map them.",
                code="doppler_channels",
            )
    if not lacking:
        return
    near = [f"{n!r} looks like {c[0]!r}" for n in names if n not in known and (c := get_close_matches(n, lacking, 1))]
    raise InputError(
        f"{kind} needs the column {some(lacking)}; the file has {some(names)}.",
        pointer="/options/mapping",
        remedy=f"{some(near)}: rename or map it." if near else "Rename a column, or map one to this name.",
        code="missing_column",
    )
