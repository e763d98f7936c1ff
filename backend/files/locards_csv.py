"""LocaRDS / OpenSky CSV: one Mode S message per row with its receptions as JSON `[[serial, timestamp_ns, rssi], ...]`.

The gate of a mark starts at the whole millisecond that is at least 1 ms before its median reception; offsets from
it are taken in integers before anything becomes a float (a float64 second of a day resolves 15 ps, but one of the
epoch 238 ns, which is 71 m). Differences from the data set's description: none.

References
----------
schaefer2021, section 3.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from algorithms.errors import InputError
from algorithms.recording import Floats, Ints, ToaMarks
from backend.files.cells import Problem
from backend.files.columns import ColumnCollector, Faults, Mask, joined
from backend.files.options import ColumnSource
from backend.files.reader import Part, Reader, Source
from backend.files.report import Findings, some
from backend.files.rows import require_column
from backend.files.selection import NameColumn, Quantity, Selection
from backend.files.times import epoch_unit
from backend.files.truth_columns import TruthColumns, truth_layout

_MS = 1_000_000
# Receptions of one message differ by the light time between the stations, milliseconds at most; a station whose
# clock is further off than this is not synchronised at all.
_LARGEST_OFFSET_NS = 10_000_000_000
_COLUMNS = {
    "altitude_m": ColumnSource(column="baroAltitude"),
    "true_latitude_deg": ColumnSource(column="latitude"),
    "true_longitude_deg": ColumnSource(column="longitude"),
    "true_height_m": ColumnSource(column="geoAltitude"),
    "target": ColumnSource(column="aircraft"),
}
_ALTITUDE = Quantity("altitude_m", -2_000, 1e8)
# Measured on the published sets: residuals against ADS-B positions have a robust standard deviation of 90 ns; the
# barometric altitude lies 104 m above the GNSS height on average, with a standard deviation of 64 m.
_SITE_DEFAULTS = {"sigma_toa_ns": 90.0, "sigma_altitude_m": 125.0}


@dataclass
class _Receptions:
    """All receptions of a file, in a row; `mark` is the position of the accepted mark."""

    mark: list[Ints] = field(default_factory=list)
    serial: list[Ints] = field(default_factory=list)
    stamp_ns: list[Ints] = field(default_factory=list)
    marks: int = 0

    def add(self, measured: Sequence[list[tuple[int, int]]], keep: Mask) -> None:
        """Add the receptions of the kept rows of a chunk."""
        kept = [m for m, ok in zip(measured, keep.tolist(), strict=True) if ok]
        counts = np.array([len(m) for m in kept], np.int64)
        flat = np.array([pair for m in kept for pair in m], np.int64).reshape(-1, 2)
        self.mark.append(np.repeat(np.arange(self.marks, self.marks + len(kept)), counts))
        self.serial.append(flat[:, 0])
        self.stamp_ns.append(flat[:, 1])
        self.marks += len(kept)


def _detect(source: Source) -> bool:
    return source.has_columns("measurements") and not source.options.mapping


def _read(source: Source) -> Part:
    findings, names = source.findings, source.rows.names
    require_column(source.rows, "measurements", "/file")
    mapping = {n: s for n, s in _COLUMNS.items() if s.column in names}
    selection = Selection(source.rows, mapping, source.options.where)
    selection.check_where()
    truth = _truth_columns(mapping, findings)
    quantities = [*([_ALTITUDE] if _ALTITUDE.name in mapping else []), *truth.quantities]
    target = [NameColumn("target", unnamed=True)] if "target" in mapping else []
    collector = ColumnCollector(selection, quantities, target, findings)
    receptions = _Receptions()
    for chunk in collector.chunks(source.limits.max_rows):
        faults = Faults()
        measured, problems = _parse(chunk.texts("measurements"))
        faults.note("measurements", problems)
        receptions.add(measured, collector.add(chunk, faults))
    columns = collector.finish()
    time_s, epoch_s, toa_s, stations = _gates_and_offsets(receptions, columns.row, findings)
    altitude_m = columns.number("altitude_m")
    if np.isfinite(altitude_m).any():
        findings.warn(
            "pressure_altitude",
            "The altitude is barometric. On recordings of this kind it lies about 104 m above the height over the "
            "ellipsoid, with a spread of 64 m, so the standard deviation of the altitude is taken as 125 m unless "
            "the site or the run gives another.",
            int(np.isfinite(altitude_m).sum()),
        )
    recording = ToaMarks(
        time_s=time_s,
        row=columns.row,
        target=columns.code("target", 0),
        targets=columns.names.get("target") or ("",),
        toa_s=toa_s[:, :, None],
        altitude_m=altitude_m[:, None],
        stations=stations,
    )
    return Part(
        recording,
        epoch_s,
        columns.rows_in_file,
        columns.rows_read,
        truth_geodetic=truth.read(columns, findings)[2],
        site_defaults=_SITE_DEFAULTS,
    )


def _truth_columns(mapping: Mapping[str, ColumnSource], findings: Findings) -> TruthColumns:
    try:
        return truth_layout(tuple(mapping), "toa_marks", findings)
    except InputError as e:
        # The format's own columns: what is wrong with them must not keep the receptions from being read.
        findings.warn("truth_unusable", f"{e.message} The recording has no truth.")
        return TruthColumns("", ())


def _parse(cells: Sequence[str]) -> tuple[list[list[tuple[int, int]]], dict[int, Problem]]:
    """(serial, timestamp in ns) of every reception of every row."""
    out: list[list[tuple[int, int]]] = []
    problems: dict[int, Problem] = {}
    for i, cell in enumerate(cells):
        try:
            received = [(m[0], m[1]) for m in json.loads(cell)]
        except (ValueError, TypeError, LookupError, RecursionError):
            received = []
            problems[i] = Problem("bad_measurements", "is no list of [serial, timestamp in ns, rssi]")
        else:
            # `type` and not isinstance: true is an int, and 8.6e9 is a timestamp that lost its nanoseconds.
            if not all(type(s) is int and type(t) is int and abs(t) < 2**62 and abs(s) < 2**62 for s, t in received):
                received = []
                problems[i] = Problem("bad_measurements", "holds a serial or a timestamp that is no whole number")
            elif not received:
                problems[i] = Problem("empty_row", "holds no reception")
        out.append(received)
    return out, problems


def _gates_and_offsets(
    receptions: _Receptions, row: Ints, findings: Findings
) -> tuple[Floats, int | None, Floats, tuple[str, ...]]:
    """Start of each mark's gate, its epoch, offsets (M, S) and the stations in the order of their serials."""
    mark, serial = joined(receptions.mark, np.int64), joined(receptions.serial, np.int64)
    stamp = joined(receptions.stamp_ns, np.int64)
    order = np.lexsort((stamp, mark))
    mark, serial, stamp = mark[order], serial[order], stamp[order]
    count = np.bincount(mark, minlength=receptions.marks)
    first = np.cumsum(count) - count
    median = stamp[first + (count - 1) // 2] if receptions.marks else np.empty(0, np.int64)
    gate_ns = (median - _MS) // _MS * _MS
    offset = stamp - gate_ns[mark]
    far = np.abs(offset) > _LARGEST_OFFSET_NS
    if far.any():
        findings.warn(
            "clock_far_off",
            f"Receptions more than 10 s from the others of their mark were left out; stations "
            f"{some(np.unique(serial[far]))}.",
            int(far.sum()),
        )
        mark, serial, offset = mark[~far], serial[~far], offset[~far]
    serials, column = np.unique(serial, return_inverse=True)
    # Sorted by time within the mark, so the first of equal (mark, station) pairs is the earliest reception.
    _, unique = np.unique(mark * max(len(serials), 1) + column, return_index=True)
    if len(unique) < len(mark):
        again = np.ones(len(mark), bool)
        again[unique] = False
        findings.warn(
            "repeated_station",
            f"A station stands more than once in one mark; the earliest reception was kept. "
            f"Rows {some(np.unique(row[mark[again]]))}.",
            int(again.sum()),
        )
    toa_s = np.full((receptions.marks, len(serials)), np.nan)
    toa_s[mark[unique], column[unique]] = offset[unique] / 1e9
    epoch_s: int | None = None
    if receptions.marks and epoch_unit(float(np.median(gate_ns))) == "ns":
        epoch_s = int(gate_ns.min() // 1_000_000_000)
        gate_ns = gate_ns - epoch_s * 1_000_000_000
    return gate_ns // _MS / 1e3, epoch_s, toa_s, tuple(str(s) for s in serials)


READER = Reader(
    name="locards_csv",
    title="LocaRDS / OpenSky CSV with receptions as JSON",
    kinds=("toa_marks",),
    detect=_detect,
    read=_read,
)
