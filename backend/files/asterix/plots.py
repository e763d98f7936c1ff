"""Plots of radars from the records of CAT 048, 001 and 010, and positions of CAT 020, 021 and 062 as plots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints, PolarPlots
from backend.files.asterix.fields import identifications, named
from backend.files.asterix.records import Records, constant
from backend.files.report import Findings

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Reports:
    """What target reports of any category have in common, one row a record, in the order of the file.

    Attributes
    ----------
    number, position : number of the record, and position of its first octet
    category : its category
    time_s, received_s : (M,) float, its own time of day and that of its receipt, NaN = none
    is_truncated : the time counts from the last multiple of 512 s
    source : (M,) int, 256 SAC + SIC, or -1
    numbers : role -> (M,) float in SI units and radians
    codes : role -> (M,) int, -1 = none
    """

    number: Ints
    position: Ints
    category: Ints
    time_s: Floats
    received_s: Floats
    is_truncated: Mask
    source: Ints
    numbers: dict[str, Floats]
    codes: dict[str, Ints]

    def __len__(self) -> int:
        return len(self.number)

    def take(self, keep: Ints | Mask) -> Reports:
        """Return only these; a column of one value stays one."""
        return Reports(
            self.number[keep],
            self.position[keep],
            self.category[keep],
            self.time_s[keep],
            self.received_s[keep],
            self.is_truncated[keep],
            self.source[keep],
            {n: _taken(v, keep) for n, v in self.numbers.items()},
            {n: _taken(v, keep) for n, v in self.codes.items()},
        )


def _taken(column: NDArray[Any], keep: Ints | Mask) -> NDArray[Any]:
    if column.strides != (0,) or not column.size:
        return column[keep]
    return constant(column[0], int(keep.sum()) if keep.dtype == bool else keep.size)


def _of_all(columns: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """A column of several categories; what none of them has stays one value."""
    if all(column.strides == (0,) for column in columns):
        return constant(columns[0][0], sum(column.size for column in columns))
    return np.concatenate(columns)


_NUMBERS = (
    *("range", "azimuth", "x", "y", "level", "height", "latitude", "longitude", "velocity_x", "velocity_y"),
    *("sector", "period"),
)
_CODES = (
    *("mode_3a", "mode_3a_unsure", "mode_3a_garbled", "level_unsure", "level_garbled", "address", "identification"),
    *("simulated", "test", "track", "message"),
)


def reports_of(tables: Sequence[Records]) -> Reports:
    """Join the records of several categories in the order of the file."""
    if not tables:
        nothing, none = np.empty(0, np.int64), np.empty(0)
        return Reports(
            *(nothing, nothing, nothing, none, none, nothing == 0, nothing),
            dict.fromkeys(_NUMBERS, none),
            dict.fromkeys(_CODES, nothing),
        )
    full = np.concatenate([t.numbers("time") for t in tables])
    truncated = np.concatenate([t.numbers("truncated_time") for t in tables])
    joined = Reports(
        np.concatenate([t.number for t in tables]),
        np.concatenate([t.position for t in tables]),
        np.concatenate([np.full(len(t), t.category.number) for t in tables]),
        np.where(np.isnan(full), truncated, full),
        np.full(len(full), np.nan),
        np.isnan(full) & np.isfinite(truncated),
        np.concatenate([np.where(t.codes("sac") < 0, -1, 256 * t.codes("sac") + t.codes("sic")) for t in tables]),
        {role: _of_all([t.numbers(role) for t in tables]) for role in _NUMBERS},
        {role: _of_all([t.codes(role) for t in tables]) for role in _CODES},
    )
    return joined if len(tables) == 1 else joined.take(np.argsort(joined.number, kind="stable"))


def source_name(source: int) -> str:
    """SAC/SIC in decimal digits, empty where a record does not tell them."""
    return "" if source < 0 else f"{source >> 8}/{source & 255}"


def codes_of_sources(source: Ints) -> tuple[Ints, tuple[str, ...]]:
    """Index into the names of the sources, in the order of their numbers."""
    found, index = np.unique(source, return_inverse=True)
    return index.astype(np.int64), tuple(source_name(s) for s in found.tolist())


def polar_plots(reports: Reports, time_s: Floats, findings: Findings) -> PolarPlots:
    """Plots; each report has a time and a position relative to its radar."""
    numbers, codes = reports.numbers, reports.codes
    _look_at_flags(codes, findings)
    radar, radars = codes_of_sources(reports.source)
    address, addresses = addresses_of(codes["address"])
    callsign, callsigns = identifications(codes["identification"])
    mode_3a, modes_3a = _modes_3a(codes)
    polar = np.isfinite(numbers["range"]) & np.isfinite(numbers["azimuth"])
    flat = np.full(len(reports), np.nan)
    return PolarPlots(
        time_s=time_s,
        row=reports.number,
        target=np.zeros(len(reports), np.int64),
        range_m=np.where(polar, numbers["range"], np.nan)[:, None],
        azimuth_rad=np.where(polar, numbers["azimuth"], np.nan)[:, None],
        elevation_rad=flat[:, None],
        altitude_m=altitude(reports, findings)[:, None],
        # A tracker computed these from range and azimuth, so they only serve where those are not given.
        east_m=np.where(polar, np.nan, numbers["x"])[:, None],
        north_m=np.where(polar, np.nan, numbers["y"])[:, None],
        radar=radar,
        radars=radars,
        radar_east_m=flat,
        radar_north_m=flat,
        scan=np.full(len(reports), -1, np.int64),
        address=address,
        addresses=addresses,
        callsign=callsign,
        callsigns=callsigns,
        mode_3a=mode_3a,
        modes_3a=modes_3a,
    )


def addresses_of(codes: Ints) -> tuple[Ints, tuple[str, ...]]:
    """24-bit addresses -> index into six hexadecimal digits."""
    return _in_words(codes, "{:06X}")


def _in_words(codes: Ints, form: str) -> tuple[Ints, tuple[str, ...]]:
    found, index = np.unique(codes, return_inverse=True)
    code, names = named(np.array(["" if c < 0 else form.format(c) for c in found.tolist()], object))
    return code[index], names


def _modes_3a(codes: dict[str, Ints]) -> tuple[Ints, tuple[str, ...]]:
    sure = (codes["mode_3a_unsure"] < 1) & (codes["mode_3a_garbled"] < 1)
    return _in_words(np.where(sure, codes["mode_3a"], -1), "{:04o}")


def altitude(reports: Reports, findings: Findings) -> Floats:
    """Altitude from the flight level where it is sure, else the height that the sensor measured."""
    numbers, codes = reports.numbers, reports.codes
    sure = (codes["level_unsure"] < 1) & (codes["level_garbled"] < 1)
    level = np.where(sure, numbers["level"], np.nan)
    has_level = np.isfinite(level)
    if has_level.any():
        findings.warn(
            "flight_level",
            "The altitude is a flight level: the height over sea level in the standard atmosphere, not corrected for "
            "the pressure of the day.",
            int(has_level.sum()),
        )
    return np.asarray(np.where(has_level, level, numbers["height"]))


def _look_at_flags(codes: dict[str, Ints], findings: Findings) -> None:
    unsure = {
        "Mode 3/A": (codes["mode_3a"] >= 0) & ((codes["mode_3a_unsure"] == 1) | (codes["mode_3a_garbled"] == 1)),
        "Mode C": (codes["level_unsure"] == 1) | (codes["level_garbled"] == 1),
    }
    told = [f"{name} ({int(m.sum())})" for name, m in unsure.items() if m.any()]
    if told:
        findings.warn(
            "codes_unsure",
            f"Codes that the radar marks as garbled or not validated were left empty: {', '.join(told)}.",
            int(sum(m.sum() for m in unsure.values())),
        )
    marked = (codes["simulated"] == 1) | (codes["test"] == 1)
    if marked.any():
        findings.warn("test_targets", "Reports of simulated or test targets are among the plots.", int(marked.sum()))
