"""The native CSV of all four kinds, and any other CSV through a column mapping.

The columns are those of docs/formats.md. A mapping renames: what it does not mention keeps its own name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from algorithms.errors import InputError, UnsupportedFormatError
from algorithms.recording import AntennaPlots, DopplerPairs, Floats, Kind, PolarPlots, Recording, ToaMarks
from backend.files.columns import Columns, TimedColumns, read_timed_columns
from backend.files.reader import Part, Reader, Source
from backend.files.report import Findings, some
from backend.files.selection import NameColumn, Quantity, Selection
from backend.files.truth_columns import TRUTH_QUANTITIES, TruthColumns, truth_layout

# A reception further from its gate than this is no offset from it: probably a time of day or of the epoch.
_LARGEST_OFFSET_NS = 1e10
_TOA = re.compile(r"toa_(.+)_ns", re.DOTALL)
_CHANNEL_SETS = (("1",), ("1", "2"), ("11", "12", "21", "22"))

_ALTITUDE = Quantity("altitude_m", -2_000, 1e8)
_RANGE = Quantity("range_m", 0, 1e9)
_QUANTITIES: dict[Kind, tuple[Quantity, ...]] = {
    "toa_marks": (_ALTITUDE,),
    "polar_plots": (
        _RANGE,
        Quantity("azimuth_deg", -360, 360),
        Quantity("elevation_deg", -90, 90),
        Quantity("east_m"),
        Quantity("north_m"),
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
_NAMES: dict[Kind, tuple[NameColumn, ...]] = {
    "toa_marks": (NameColumn("target", unnamed=True), NameColumn("emitter_type")),
    "polar_plots": (
        NameColumn("target", unnamed=True),
        NameColumn("radar", unnamed=True),
        NameColumn("address"),
        NameColumn("callsign"),
    ),
    "antenna_plots": (NameColumn("target", unnamed=True),),
    "doppler_pairs": (NameColumn("target", unnamed=True),),
}


def _kinds_of(names: Sequence[str]) -> list[Kind]:
    """Kinds whose own columns are among the names."""
    found: list[Kind] = []
    if any(_TOA.fullmatch(n) for n in names):
        found.append("toa_marks")
    if "bicone_elevation_deg" in names or "bicone_azimuth_deg" in names:
        found.append("antenna_plots")
    elif {"range_m", "azimuth_deg"} <= set(names) or {"east_m", "north_m"} <= set(names):
        found.append("polar_plots")
    if any(n in names for n in ("doppler_1_hz", "doppler_11_hz")):
        found.append("doppler_pairs")
    return found


def _detect(source: Source) -> bool:
    try:
        names = source.header.names
    except UnsupportedFormatError:
        return False
    return bool(source.options.mapping or _kinds_of(names))


def _read(source: Source) -> Part:
    selection = Selection(source.header, source.options.mapping, source.options.where)
    selection.check_where()
    names = selection.names
    kind = _choose_kind(names, source)
    stations = tuple(m[1] for n in names if (m := _TOA.fullmatch(n))) if kind == "toa_marks" else ()
    offsets = tuple(Quantity(f"toa_{s}_ns", -_LARGEST_OFFSET_NS, _LARGEST_OFFSET_NS) for s in stations)
    quantities = (*_QUANTITIES[kind], *TRUTH_QUANTITIES)
    known = ("time_s", *(q.name for q in (*quantities, *offsets)), *(n.name for n in _NAMES[kind]))
    selection.check_mapping(known, kind)
    _check_columns(kind, names, known)
    truth = truth_layout(names, kind, source.findings)
    _warn_about_ignored(selection, known, source.findings)
    offered = tuple(q for q in (*_QUANTITIES[kind], *truth.quantities) if q.name in names)
    timed = read_timed_columns(
        source.content,
        selection,
        (*offered, *offsets),
        tuple(n for n in _NAMES[kind] if n.name in names),
        source.findings,
        source.limits.max_rows,
    )
    return _Builder(timed, kind, stations, truth, source.findings).part(
        {s: selection.source(f"toa_{s}_ns").column for s in stations}
    )


def _choose_kind(names: Sequence[str], source: Source) -> Kind:
    if source.options.kind is not None:
        return source.options.kind
    kinds = _kinds_of(names)
    if len(kinds) == 1:
        return kinds[0]
    if not kinds:
        raise InputError(
            f"The columns {some(names)} do not tell what was measured.",
            pointer="/options/kind",
            remedy="Name the kind, or map the columns that it needs.",
            code="kind_unknown",
        )
    raise InputError(
        f"The columns fit {' and '.join(kinds)}.",
        pointer="/options/kind",
        remedy="Name the kind.",
        code="kind_ambiguous",
    )


def _check_columns(kind: Kind, names: Sequence[str], known: Sequence[str]) -> None:
    offered = set(names)
    lacking: list[str] = [] if "time_s" in offered else ["time_s"]
    if kind == "toa_marks" and not any(_TOA.fullmatch(n) for n in names):
        lacking.append("toa_<station>_ns")
    if kind == "polar_plots" and not {"east_m", "north_m"} <= offered:
        lacking += [n for n in ("range_m", "azimuth_deg") if n not in offered]
    if kind == "antenna_plots":
        lacking += [q.name for q in _QUANTITIES[kind] if q.required and q.name not in offered]
    if kind == "doppler_pairs":
        channels = tuple(c for c in ("1", "2", "11", "12", "21", "22") if f"doppler_{c}_hz" in offered)
        if channels not in _CHANNEL_SETS:
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


def _warn_about_ignored(selection: Selection, known: Sequence[str], findings: Findings) -> None:
    used = set(known) | {s.column for s in selection.mapping.values()} | set(selection.where)
    used |= {s.minus for s in selection.mapping.values() if s.minus is not None}
    ignored = [n for n in selection.header.names if n not in used]
    if ignored:
        findings.warn(
            "columns_ignored",
            f"Columns that nothing reads: {some(n or '(without a name)' for n in ignored)}.",
            len(ignored),
        )


@dataclass(frozen=True)
class _Builder:
    """Makes the recording of one kind from its columns."""

    timed: TimedColumns
    kind: Kind
    stations: tuple[str, ...]
    truth: TruthColumns
    findings: Findings

    def part(self, station_columns: dict[str, str]) -> Part:
        """Reject rows without a measurement and build the recording."""
        columns, time_s = self.timed.columns, self.timed.time_s
        empty = ~_has_measurement(self.kind, columns, self.stations)
        incomplete = self.kind == "polar_plots"
        columns = columns.reject(
            empty,
            "missing_value" if incomplete else "empty_row",
            "neither range and azimuth nor east and north are there" if incomplete else "nothing was measured",
            self.findings,
        )
        enu, velocity, geodetic = self.truth.read(columns, self.findings)
        build: dict[Kind, Callable[..., Recording]] = {
            "toa_marks": self._toa_marks,
            "polar_plots": self._polar_plots,
            "antenna_plots": self._antenna_plots,
            "doppler_pairs": self._doppler_pairs,
        }
        common = {
            "time_s": time_s[~empty],
            "row": columns.row,
            "target": columns.code("target", 0),
            "targets": columns.names.get("target") or ("",),
            "truth_m": enu,
            "truth_velocity_mps": velocity,
        }
        recording = build[self.kind](columns, common)
        return Part(
            recording,
            self.timed.epoch_s,
            columns.rows_in_file,
            columns.rows_read,
            truth_geodetic=geodetic,
            station_columns=station_columns,
        )

    def _toa_marks(self, columns: Columns, common: dict[str, object]) -> Recording:
        toa = np.stack([columns.number(f"toa_{s}_ns") for s in self.stations], axis=1)
        return ToaMarks(
            **common,  # type: ignore[arg-type]
            toa_s=toa[:, :, None],
            altitude_m=_trial(columns, "altitude_m"),
            stations=self.stations,
            emitter_type=columns.code("emitter_type", -1),
            emitter_types=columns.names.get("emitter_type", ()),
        )

    def _polar_plots(self, columns: Columns, common: dict[str, object]) -> Recording:
        scan = columns.number("scan")
        return PolarPlots(
            **common,  # type: ignore[arg-type]
            range_m=_trial(columns, "range_m"),
            azimuth_rad=_trial(columns, "azimuth_deg"),
            elevation_rad=_trial(columns, "elevation_deg"),
            altitude_m=_trial(columns, "altitude_m"),
            east_m=_trial(columns, "east_m"),
            north_m=_trial(columns, "north_m"),
            radar=columns.code("radar", 0),
            radars=columns.names.get("radar") or ("",),
            radar_east_m=columns.number("radar_east_m"),
            radar_north_m=columns.number("radar_north_m"),
            scan=np.where(np.isnan(scan), -1, scan).astype(np.int64),
            address=columns.code("address", -1),
            addresses=columns.names.get("address", ()),
            callsign=columns.code("callsign", -1),
            callsigns=columns.names.get("callsign", ()),
        )

    def _antenna_plots(self, columns: Columns, common: dict[str, object]) -> Recording:
        return AntennaPlots(
            **common,  # type: ignore[arg-type]
            range_m=_trial(columns, "range_m"),
            bicone_elevation_rad=_trial(columns, "bicone_elevation_deg"),
            bicone_azimuth_rad=_trial(columns, "bicone_azimuth_deg"),
        )

    def _doppler_pairs(self, columns: Columns, common: dict[str, object]) -> Recording:
        channels = next(s for s in reversed(_CHANNEL_SETS) if all(f"doppler_{c}_hz" in columns.numbers for c in s))
        doppler = np.stack([columns.number(f"doppler_{c}_hz") for c in channels], axis=1)
        rate = np.stack([columns.number(f"doppler_rate_{i}_hz_s") for i in (1, 2)], axis=1)
        return DopplerPairs(
            **common,  # type: ignore[arg-type]
            doppler_hz=doppler[:, :, None],
            doppler_rate_hz_s=rate[:, :, None],
            azimuth_rad=_trial(columns, "azimuth_deg"),
            elevation_rad=_trial(columns, "elevation_deg"),
            channels=channels,
        )


def _trial(columns: Columns, name: str) -> Floats:
    """A column as a block of one trial, (M, 1)."""
    return columns.number(name)[:, None]


def _has_measurement(kind: Kind, columns: Columns, stations: tuple[str, ...]) -> np.ndarray:
    def there(name: str) -> np.ndarray:
        return np.isfinite(columns.number(name))

    has = np.ones(len(columns), bool)
    if kind == "toa_marks":
        has = there("altitude_m")
        for station in stations:
            has |= there(f"toa_{station}_ns")
    elif kind == "polar_plots":
        has = (there("range_m") & there("azimuth_deg")) | (there("east_m") & there("north_m"))
    elif kind == "doppler_pairs":
        has = np.zeros(len(columns), bool)
        for name in columns.numbers:
            if name.startswith("doppler_") and name.endswith("_hz"):
                has |= there(name)
    return has


READER = Reader(
    name="native_csv",
    title="CSV with the columns of docs/formats.md, or with a column mapping",
    kinds=("toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"),
    detect=_detect,
    read=_read,
)
