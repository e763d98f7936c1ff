"""Several files become one recording: a common start, common stations and names, one order in time, no row twice."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import InputError
from algorithms.recording import DopplerPairs, Floats, Ints, Recording, ToaMarks
from backend.files.companions import joined_marks, joined_sites, joined_truth
from backend.files.reader import Part
from backend.files.report import Findings

_Recording = TypeVar("_Recording", bound=Recording)

# Any odd number with as many ones as zeros: products spread what differs over all digits.
_ODD = np.uint64(0x9E3779B97F4A7C15)
# Fields that are indices, and the field that holds the names.
_NAMED = {
    "target": "targets",
    "emitter_type": "emitter_types",
    "radar": "radars",
    "address": "addresses",
    "callsign": "callsigns",
    "mode_3a": "modes_3a",
}


@dataclass(frozen=True)
class FilePart:
    """A part with what was found while it was read."""

    part: Part
    findings: Findings


@dataclass(frozen=True)
class RowFiles:
    """Which file a row of the merged numbering comes from."""

    names: tuple[str, ...]
    first_rows: tuple[int, ...]

    @classmethod
    def of(cls, files: Sequence[FilePart]) -> RowFiles:
        """Number the rows of a file on from those of the files before it."""
        counts = [f.part.rows_in_file for f in files]
        return cls(tuple(f.findings.file for f in files), tuple(1 + sum(counts[:i]) for i in range(len(files))))

    def name(self, row: int) -> str:
        """Name of the file."""
        return self.names[bisect_right(self.first_rows, row) - 1]


def merge_parts(files: Sequence[FilePart], findings: Findings) -> Part:
    """Join the parts; the rows of a file are numbered on from those of the files before it."""
    parts = [f.part for f in files]
    kinds = {p.recording.kind for p in parts}
    if len(kinds) > 1:
        raise InputError(
            f"The files hold different kinds of measurements: {' and '.join(sorted(kinds))}.",
            pointer="/file",
            remedy="Upload each kind as a recording of its own.",
            code="mixed_kinds",
        )
    epochs = {p.epoch_s is None for p in parts}
    if len(epochs) > 1:
        raise InputError(
            "Some files give times of the epoch and others times from an unknown start.",
            pointer="/file",
            remedy="Upload them separately, or give all of them the same times.",
            code="mixed_time_bases",
        )
    offset = 0
    numbered: list[Part] = []
    known = [p.epoch_s for p in parts if p.epoch_s is not None]
    epoch_s = min(known) if known else None
    for file in files:
        part, recording = file.part, file.part.recording
        shift = 0 if epoch_s is None or part.epoch_s is None else part.epoch_s - epoch_s
        moved = replace(recording, row=recording.row + offset, time_s=recording.time_s + shift)
        marks = joined_marks([(part.marks, shift)])
        numbered.append(replace(part, recording=moved, marks=marks, truth=joined_truth([part.truth], epoch_s)))
        findings.absorb(file.findings, offset)
        offset += part.rows_in_file
    if len(numbered) == 1:
        return replace(numbered[0], epoch_s=epoch_s)
    return Part(
        joined_rows([p.recording for p in numbered]),
        epoch_s,
        offset,
        sum(p.rows_read for p in numbered),
        truth_geodetic=_join_geodetic([(p.recording, p.truth_geodetic) for p in numbered], 3),
        plots_geodetic=_join_geodetic([(p.recording, p.plots_geodetic) for p in numbered], 2),
        station_columns={k: v for p in numbered for k, v in p.station_columns.items()},
        site_defaults={k: v for p in numbered for k, v in p.site_defaults.items()},
        site=joined_sites([p.site for p in numbered]),
        truth=joined_truth([p.truth for p in numbered], epoch_s),
        marks=joined_marks([(p.marks, 0.0) for p in numbered]),
    )


def joined_rows(recordings: Sequence[_Recording]) -> _Recording:
    """Rows of all recordings under each other, names joined; what is no array stays that of the first.

    Raises
    ------
    InputError
        The recordings have different Doppler channels.
    """
    first = recordings[0]
    merged: dict[str, Any] = {}
    if isinstance(first, DopplerPairs) and len({r.channels for r in recordings if isinstance(r, DopplerPairs)}) > 1:
        raise InputError(
            "The files have different Doppler channels.",
            pointer="/file",
            remedy="Upload them as recordings of their own.",
            code="mixed_channels",
        )
    for name, names in _NAMED.items():
        if hasattr(first, name):
            book = list(dict.fromkeys(n for r in recordings for n in getattr(r, names)))
            merged[names] = tuple(book)
            merged[name] = np.concatenate([_recode(getattr(r, name), getattr(r, names), book) for r in recordings])
    if isinstance(first, ToaMarks):
        marks = [r for r in recordings if isinstance(r, ToaMarks)]
        stations = tuple(dict.fromkeys(s for r in marks for s in r.stations))
        merged["stations"] = stations
        merged["toa_s"] = np.concatenate([spread_stations(r, stations) for r in marks])
    for f in fields(first):
        if f.name not in merged and isinstance(getattr(first, f.name), np.ndarray):
            merged[f.name] = np.concatenate([getattr(r, f.name) for r in recordings])
    return replace(first, **merged)


def _recode(codes: NDArray[np.int64], names: Sequence[str], book: Sequence[str]) -> NDArray[np.int64]:
    table = np.array([*(book.index(n) for n in names), -1], np.int64)
    return table[codes]


def spread_stations(recording: ToaMarks, stations: Sequence[str]) -> Floats:
    """`toa_s` with the columns of `stations`; a station that the recording lacks has received nothing."""
    out = np.full((len(recording), len(stations), recording.toa_s.shape[2]), np.nan)
    where = {name: i for i, name in enumerate(stations)}
    for i, name in enumerate(recording.stations):
        if name in where:
            out[:, where[name]] = recording.toa_s[:, i]
    return out


def _join_geodetic(parts: Sequence[tuple[Recording, Floats | None]], width: int) -> Floats | None:
    if all(places is None for _, places in parts):
        return None
    return np.concatenate([np.full((len(r), width), np.nan) if places is None else places for r, places in parts])


def put_in_order(file: FilePart, order: Literal["sort", "reject"]) -> FilePart:
    """Look for rows of one file that are earlier than a row before them; count them, or reject them."""
    recording, findings = file.part.recording, file.findings
    if not len(recording):
        return file
    latest = np.maximum.accumulate(recording.time_s)
    late = recording.time_s < latest
    if not late.any():
        return file
    step_s = float((latest - recording.time_s).max())
    if order == "sort":
        findings.warn(
            "rows_out_of_order",
            f"Rows of {findings.file} that are earlier than a row before them were sorted; the largest step back "
            f"is {step_s:.6g} s.",
            int(late.sum()),
        )
        return file
    for row, step in zip(recording.row[late], (latest - recording.time_s)[late], strict=True):
        findings.reject(int(row), "out_of_order", f"the time is {step:.6g} s before that of an earlier row")
    return FilePart(kept_rows(file.part, ~late), findings)


def sort_by_time(part: Part) -> Part:
    """Put the rows in order of time; rows of equal time keep their order."""
    time_s = part.recording.time_s
    return part if (time_s[1:] >= time_s[:-1]).all() else _taken(part, np.argsort(time_s, kind="stable"))


def kept_rows(part: Part, keep: NDArray[np.bool_]) -> Part:
    """Return only these rows."""
    return _taken(part, np.flatnonzero(keep))


def _taken(part: Part, positions: NDArray[np.int64]) -> Part:
    truth, plots = (None if v is None else v[positions] for v in (part.truth_geodetic, part.plots_geodetic))
    return replace(part, recording=part.recording.take(positions), truth_geodetic=truth, plots_geodetic=plots)


def without_empty_marks(part: Part, files: RowFiles, findings: Findings) -> Part:
    """Reject marks that lost all their receptions with the stations, and have no altitude either."""
    marks = part.recording
    if not isinstance(marks, ToaMarks):
        return part
    keep = np.logical_or(np.isfinite(marks.toa_s).any(axis=(1, 2)), np.isfinite(marks.altitude_m).any(axis=1))
    for row in marks.row[~keep].tolist():
        findings.reject(row, "empty_row", "no station that received it can be used", file=files.name(row))
    return part if keep.all() else kept_rows(part, keep)


def without_duplicates(part: Part, files: RowFiles, findings: Findings) -> Part:
    """Reject rows (sorted by time) that repeat an earlier one in everything that was read."""
    recording = part.recording
    same = np.diff(recording.time_s, prepend=-np.inf, append=np.inf) == 0
    positions = np.flatnonzero(same[:-1] | same[1:])
    if not positions.size:
        return part
    columns = [getattr(recording, f.name) for f in fields(recording) if f.name != "row"]
    columns = [c for c in columns if isinstance(c, np.ndarray)]
    columns += [places for places in (part.truth_geodetic, part.plots_geodetic) if places is not None]
    columns = [c.reshape(len(recording), -1) for c in columns]
    positions = _alike(columns, positions)
    # Adding zero makes -0.0 and 0.0 the same bytes.
    table = np.concatenate([c[positions] + 0.0 for c in columns], axis=1)
    seen: dict[bytes, int] = {}
    keep = np.ones(len(recording), bool)
    for position, line in zip(positions.tolist(), table, strict=True):
        row = int(recording.row[position])
        first = seen.setdefault(line.tobytes(), row)
        if first != row:
            keep[position] = False
            findings.reject(row, "duplicate_row", f"repeats row {first}", file=files.name(row))
    return part if keep.all() else kept_rows(part, keep)


def _alike(columns: Sequence[NDArray[Any]], positions: Ints) -> Ints:
    """Return the positions of rows that may repeat another one, by a number made of all their values.

    Rows of equal values have equal numbers, other rows hardly ever: what remains is looked at one by one.
    """
    mixed = np.zeros(positions.size, np.uint64)
    for column in columns:
        for k in range(column.shape[1]):
            values = column[positions, k] + 0.0
            mixed = (mixed ^ values.view(np.uint64)) * _ODD
            mixed ^= mixed >> np.uint64(29)
    order = np.argsort(mixed, kind="stable")
    same = mixed[order[1:]] == mixed[order[:-1]]
    alike: Ints = positions[np.sort(order[np.append(False, same) | np.append(same, False)])]
    return alike
