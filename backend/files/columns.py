"""Named columns of a delimited file in SI units, with one rejection for each row that cannot serve."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints
from backend.files.cells import Names, Numbers, NumberStyle, Problem, is_instant, read_instants, read_numbers
from backend.files.options import ColumnSource
from backend.files.report import Findings
from backend.files.rows import Chunk, taken
from backend.files.selection import NameColumn, Quantity, Selection
from backend.files.times import resolve_times, utc_seconds
from backend.files.units import UNITS, native_unit

Mask = NDArray[np.bool_]


@dataclass
class Faults:
    """The first thing that is wrong with each bad row of a chunk, by position."""

    found: dict[int, tuple[str, Problem]] = field(default_factory=dict)

    def note(self, column: str, problems: Mapping[int, Problem]) -> None:
        """Add problems of one column."""
        for i, problem in problems.items():
            self.found.setdefault(i, (column, problem))

    def note_all(self, column: str, bad: Mask, problem: Problem) -> None:
        """Add the same problem for every row of `bad`."""
        for i in np.flatnonzero(bad):
            self.found.setdefault(int(i), (column, problem))

    def note_numbers(self, column: str, numbers: Numbers, *, required: bool) -> None:
        """Add the problems of a converted column, and where a needed cell is empty."""
        self.note(column, numbers.problems)
        if required:
            self.note_all(column, np.isnan(numbers.values), Problem("missing_value", "is empty"))

    def keep(self, chunk: Chunk, findings: Findings) -> Mask:
        """List the bad rows as rejected and tell which are good."""
        keep = np.ones(len(chunk), bool)
        for i in sorted(self.found):
            keep[i] = False
            column, problem = self.found[i]
            findings.reject(
                int(chunk.row[i]), problem.code, f"{_place(chunk.line[i])}column {column!r} {problem.detail}"
            )
        return keep


@dataclass(frozen=True)
class Columns:
    """What was read: numbers in SI (NaN = empty), names as codes. Absent columns are absent here."""

    row: Ints
    line: Ints
    numbers: Mapping[str, Floats]
    codes: Mapping[str, Ints]
    names: Mapping[str, tuple[str, ...]]
    rows_in_file: int
    rows_read: int
    """Rows that the user's filter kept, accepted and rejected ones."""

    def __len__(self) -> int:
        return len(self.row)

    def number(self, name: str) -> Floats:
        """Column `name`, all NaN where it is absent."""
        return self.numbers[name] if name in self.numbers else np.full(len(self), math.nan)

    def code(self, name: str, absent: int) -> Ints:
        """Codes of column `name`, all `absent` where it is absent."""
        return self.codes[name] if name in self.codes else np.full(len(self), absent, np.int64)

    def take(self, keep: Mask) -> Columns:
        """Return only these rows."""
        return replace(
            self,
            row=self.row[keep],
            line=self.line[keep],
            numbers={n: v[keep] for n, v in self.numbers.items()},
            codes={n: v[keep] for n, v in self.codes.items()},
        )

    def reject(self, bad: Mask, code: str, detail: str, findings: Findings) -> Columns:
        """List the rows of `bad` as rejected and return the others."""
        for i in np.flatnonzero(bad):
            findings.reject(int(self.row[i]), code, f"{_place(self.line[i])}{detail}")
        return self.take(~bad) if bad.any() else self


class ColumnCollector:
    """Converts chunk after chunk and joins the good rows."""

    def __init__(
        self, selection: Selection, quantities: Sequence[Quantity], names: Sequence[NameColumn], findings: Findings
    ) -> None:
        self.style = NumberStyle()
        self._selection = selection
        self._findings = findings
        # Units are settled before the file is read: a wrong one must not wait for the last row.
        self._plans = [(q, selection.source(q.name), selection.unit(q), _si_limits(q)) for q in quantities]
        self._names = names
        self._books = {n.name: Names() for n in names}
        self._rows_in_file = 0
        self._left_out = 0
        self._rows: list[Ints] = []
        self._lines: list[Ints] = []
        self._numbers: dict[str, list[Floats]] = {q.name: [] for q in quantities}
        self._codes: dict[str, list[Ints]] = {n.name: [] for n in names}

    def chunks(self, max_rows: int) -> Iterator[Chunk]:
        """Chunks of the file with the rows that the user's filter keeps."""
        for whole in self._selection.rows.chunks(self._findings, max_rows, self._numbers_alone()):
            self._rows_in_file = int(whole.row[-1])
            chunk = self._selection.matching(whole)
            self._left_out += len(whole) - len(chunk)
            if len(chunk):
                yield chunk

    def _numbers_alone(self) -> frozenset[str]:
        """Columns of the file that are read as numbers and as nothing else."""
        sources = [source for _, source, _, _ in self._plans]
        if self._selection.time_unit() != "date":
            sources.append(self._selection.source("time_s"))
        found = {s.column for s in sources} | {s.minus for s in sources if s.minus is not None}
        return frozenset(
            found - {self._selection.source(n.name).column for n in self._names} - set(self._selection.where)
        )

    def add(self, chunk: Chunk, faults: Faults) -> Mask:
        """Convert the columns of one chunk; rows with a fault (given, or found here) are rejected.

        Returns which rows of the chunk were good.
        """
        values: dict[str, Floats] = {}
        for quantity, source, unit, (low, high) in self._plans:
            numbers = self._read(chunk, source, faults)
            faults.note_numbers(source.column, numbers, required=quantity.required)
            si = unit.to_si(numbers.values)
            with np.errstate(invalid="ignore"):
                outside = (si < low) | (si > high)
            limits = f"must lie between {quantity.low:g} and {quantity.high:g}"
            limits += "" if quantity.whole else f" {native_unit(quantity.name)}"
            faults.note_all(source.column, outside, Problem("out_of_range", limits))
            if quantity.whole:
                broken = si != np.floor(si)
                broken &= np.isfinite(si)
                faults.note_all(source.column, broken, Problem("not_whole", "must be a whole number"))
            values[quantity.name] = si
        keep = faults.keep(chunk, self._findings)
        self._rows.append(chunk.row[keep])
        self._lines.append(chunk.line[keep])
        for name, column in values.items():
            self._numbers[name].append(column[keep])
        for n in self._names:
            good = taken(chunk.texts(self._selection.source(n.name).column), keep)
            assert not isinstance(good, np.ndarray)
            self._codes[n.name].append(self._books[n.name].read(good, empty=None if n.unnamed else -1))
        return keep

    def _read(self, chunk: Chunk, source: ColumnSource, faults: Faults) -> Numbers:
        numbers = read_numbers(chunk.cells[source.column], self.style)
        if source.minus is None:
            return numbers
        other = read_numbers(chunk.cells[source.minus], self.style)
        faults.note(source.minus, other.problems)
        absent = np.isnan(other.values) & np.isfinite(numbers.values)
        faults.note_all(source.minus, absent, Problem("missing_value", "is empty"))
        return Numbers(numbers.values - other.values, numbers.problems)

    def finish(self) -> Columns:
        """Join the chunks; warn about rows left out and about the way in which numbers are written."""
        rows_in_file = max([self._rows_in_file, *(r.row for r in self._findings.rejections)])
        if self._left_out:
            self._findings.warn("rows_filtered", "Rows that the `where` filter leaves out.", self._left_out)
        if self.style.decimal_commas and self.style.has_points:
            self._findings.warn(
                "mixed_decimal_marks",
                "Some numbers have a decimal comma and others a decimal point; both were read as decimal marks. "
                "If the commas separate thousands, write the file again without them.",
                self.style.decimal_commas,
            )
        if self.style.empty_words:
            self._findings.warn(
                "word_for_empty", "Cells such as NaN or null were read as empty.", self.style.empty_words
            )
        # Each column's chunks are let go before the next column is joined.
        return Columns(
            row=joined(self._rows, np.int64),
            line=joined(self._lines, np.int64),
            numbers={n: joined(self._numbers.pop(n), np.float64) for n in tuple(self._numbers)},
            codes={n: joined(self._codes.pop(n), np.int64) for n in tuple(self._codes)},
            names={n: b.names for n, b in self._books.items()},
            rows_in_file=rows_in_file,
            rows_read=rows_in_file - self._left_out,
        )


@dataclass(frozen=True)
class TimedColumns:
    """Columns with the time of each row, from `epoch_s` or from an unknown start."""

    columns: Columns
    time_s: Floats
    epoch_s: int | None


def read_timed_columns(
    selection: Selection,
    quantities: Sequence[Quantity],
    names: Sequence[NameColumn],
    findings: Findings,
    max_rows: int,
) -> TimedColumns:
    """Read `time_s` with these quantities and names; each must exist in the selection."""
    collector = ColumnCollector(selection, quantities, names, findings)
    source, unit = selection.source("time_s"), selection.time_unit()
    stamps: list[Floats] = []
    for chunk in collector.chunks(max_rows):
        cells = chunk.cells[source.column]
        if unit is None and not isinstance(cells, np.ndarray) and is_instant(next((c for c in cells if c.strip()), "")):
            unit = "date"
        numbers = read_instants(chunk.texts(source.column)) if unit == "date" else read_numbers(cells, collector.style)
        faults = Faults()
        faults.note_numbers(source.column, numbers, required=True)
        stamps.append(numbers.values[collector.add(chunk, faults)])
    columns = collector.finish()
    raw = joined(stamps, np.float64)
    if unit in UNITS:
        raw, unit = UNITS[unit].to_si(raw), "s"
    times = resolve_times(raw, unit, findings)
    detail = f"column {source.column!r} is far outside the times of the other rows"
    columns = columns.reject(~times.usable, "out_of_range", detail, findings)
    time_s, epoch_s = times.time_s[times.usable], times.epoch_s
    if epoch_s is None and selection.rows.start_utc is not None:
        start_s = utc_seconds(selection.rows.start_utc)
        epoch_s = math.floor(start_s)
        time_s = time_s + (start_s - epoch_s)
    return TimedColumns(columns, time_s, epoch_s)


def joined(parts: Sequence[NDArray[Any]], dtype: type) -> NDArray[Any]:
    """Join chunks of one column."""
    return np.concatenate(parts) if parts else np.empty(0, dtype)


def _place(line: int) -> str:
    """Line of a text; other tables have none, and the rejection tells the row."""
    return f"line {line}: " if line else ""


def _si_limits(quantity: Quantity) -> tuple[float, float]:
    if quantity.whole:
        return quantity.low, quantity.high
    low, high = UNITS[native_unit(quantity.name)].to_si(np.array([quantity.low, quantity.high]))
    # Conversion may round a value that stands exactly on a limit.
    margin = 1e-12 * max(abs(low), abs(high))
    return float(low - margin), float(high + margin)
