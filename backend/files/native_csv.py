"""The native CSV of all four kinds, and any other CSV through a column mapping.

The columns are those of docs/formats.md. A mapping renames: what it does not mention keeps its own name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from algorithms.errors import InputError, UnsupportedFormatError
from algorithms.recording import AntennaPlots, DopplerPairs, Floats, Kind, PolarPlots, Recording, ToaMarks
from backend.files.column_guess import in_other_unit
from backend.files.columns import Columns, TimedColumns, read_timed_columns
from backend.files.native_columns import (
    CHANNEL_SETS,
    LARGEST_OFFSET_NS,
    NAMES,
    PLACES,
    QUANTITIES,
    TOA_COLUMN,
    check_columns,
    kinds_of,
)
from backend.files.reader import Part, Reader, Source
from backend.files.report import Findings, some
from backend.files.selection import Quantity, Selection
from backend.files.truth_columns import TRUTH_QUANTITIES, TruthColumns, truth_layout


def detect_native(source: Source) -> bool:
    """Whether the columns are native ones, or the user maps some to them."""
    try:
        names = source.rows.names
    except UnsupportedFormatError:
        return False
    return bool(source.options.mapping or kinds_of(names))


def read_native(source: Source) -> Part:
    """Read the rows of any container of a table.

    Raises InputError where the columns do not make a recording.
    """
    selection = Selection(source.rows, source.options.mapping, source.options.where)
    selection.check_where()
    names = selection.names
    kind = _choose_kind(names, source)
    stations = tuple(m[1] for n in names if (m := TOA_COLUMN.fullmatch(n))) if kind == "toa_marks" else ()
    offsets = tuple(Quantity(f"toa_{s}_ns", -LARGEST_OFFSET_NS, LARGEST_OFFSET_NS) for s in stations)
    quantities = (*QUANTITIES[kind], *TRUTH_QUANTITIES)
    known = ("time_s", *(q.name for q in (*quantities, *offsets)), *(n.name for n in NAMES[kind]))
    selection.check_mapping(known, kind)
    check_columns(kind, names, known)
    truth = truth_layout(names, kind, source.findings)
    _warn_about_ignored(selection, known, source.findings)
    offered = tuple(q for q in (*QUANTITIES[kind], *truth.quantities) if q.name in names)
    timed = read_timed_columns(
        selection,
        (*offered, *offsets),
        tuple(n for n in NAMES[kind] if n.name in names),
        source.findings,
        source.limits.max_rows,
    )
    return _Builder(timed, kind, stations, truth, source.findings).part(
        {s: selection.source(f"toa_{s}_ns").column for s in stations}
    )


def _choose_kind(names: Sequence[str], source: Source) -> Kind:
    if source.options.kind is not None:
        return source.options.kind
    kinds = kinds_of(names)
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


def _warn_about_ignored(selection: Selection, known: Sequence[str], findings: Findings) -> None:
    used = set(known) | {s.column for s in selection.mapping.values()} | set(selection.where)
    used |= {s.minus for s in selection.mapping.values() if s.minus is not None}
    ignored = [n for n in selection.rows.names if n not in used]
    if ignored:
        findings.warn(
            "columns_ignored",
            f"Columns that nothing reads: {some(n or '(without a name)' for n in ignored)}.",
            len(ignored),
        )
    offered = {n for n in selection.rows.names if n} | set(selection.mapping)
    meant = [(name, native) for name, native in in_other_unit(ignored, known) if native not in offered]
    if meant:
        findings.warn(
            "column_in_other_unit",
            f"{some(f'{n!r} looks like {native!r} in another unit' for n, native in meant)}: it is not read. "
            "Read the recording again with a mapping that names the column and its unit.",
            len(meant),
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
            "neither range and azimuth nor east and north nor latitude and longitude are there"
            if incomplete
            else "nothing was measured",
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
            plots_geodetic=_places(columns) if self.kind == "polar_plots" else None,
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
            mode_3a=columns.code("mode_3a", -1),
            modes_3a=columns.names.get("mode_3a", ()),
        )

    def _antenna_plots(self, columns: Columns, common: dict[str, object]) -> Recording:
        return AntennaPlots(
            **common,  # type: ignore[arg-type]
            range_m=_trial(columns, "range_m"),
            bicone_elevation_rad=_trial(columns, "bicone_elevation_deg"),
            bicone_azimuth_rad=_trial(columns, "bicone_azimuth_deg"),
        )

    def _doppler_pairs(self, columns: Columns, common: dict[str, object]) -> Recording:
        channels = next(s for s in reversed(CHANNEL_SETS) if all(f"doppler_{c}_hz" in columns.numbers for c in s))
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


def _places(columns: Columns) -> Floats | None:
    """Latitude and longitude of each plot, rad, (M, 2); None where no plot has both."""
    places = np.stack([columns.number("latitude_deg"), columns.number("longitude_deg")], axis=1)
    return places if np.isfinite(places).all(axis=1).any() else None


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
        has = np.any([there(a) & there(b) for a, b in PLACES], axis=0)
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
    detect=lambda source: source.content.is_text and detect_native(source),
    read=read_native,
)
