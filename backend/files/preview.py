"""Look into files before they are read for good: columns, first rows, what they may mean, what reading would give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.array_rows import ArrayRows
from backend.files.column_guess import Suggestion, suggest
from backend.files.containers import open_rows
from backend.files.content import inspect
from backend.files.options import ReadLimits, ReadOptions
from backend.files.packing import with_members
from backend.files.reader import Source, readers_by_name
from backend.files.reading import NamedFile, read_recording
from backend.files.report import Findings, ReadReport
from backend.files.rows import first_rows

ROWS_SHOWN = 20
# Options that belong to a kind of measurement, whatever the format.
KIND_OPTIONS = {"polar_plots": ("scan_cut", "scan_period_s"), "doppler_pairs": ("equal_times",)}


@dataclass(frozen=True)
class Preview:
    """What is in the first file, and what reading all of them with these options would give.

    Attributes
    ----------
    format : name of the reader that recognises it without a mapping, or None
    columns, rows : the line of names and the first rows, as text; empty where the file is no delimited text
    suggestion : what the columns may mean; nothing of it was applied
    report : counts, warnings and rejections of a trial reading, or None
    error : why it gives nothing
    options : names of the reading options, beside mapping and filter, that mean something for this file
    """

    format: str | None
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    suggestion: Suggestion
    report: ReadReport | None
    error: InputError | None
    options: tuple[str, ...] = ()


def preview(
    files: Sequence[NamedFile],
    *,
    site: bytes | None = None,
    truth: NamedFile | None = None,
    options: ReadOptions | None = None,
    limits: ReadLimits | None = None,
) -> Preview:
    """Read on trial. Only a file that cannot be opened as what it says raises; all else is told in the preview."""
    options, limits = options or ReadOptions(), limits or ReadLimits()
    content = inspect(with_members(files, limits)[0], limits, Findings(files[0].label))
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    source = Source(content, ReadOptions(), limits, Findings())
    try:
        table = open_rows(content, limits, wanted=options.columns())
        # A mapping to a column of another table of the file chooses that table.
        elsewhere = table.elsewhere if isinstance(table, ArrayRows) else ()
        columns = (*table.names, *elsewhere)
        rows = tuple((*row, *[""] * len(elsewhere)) for row in first_rows(table, ROWS_SHOWN))
    except UnsupportedFormatError:
        pass  # no table: a reader of another format may still know it
    found = next((r for r in readers_by_name().values() if r.detect(source)), None)
    report, error = None, None
    try:
        _, report = read_recording(files, site=site, truth=truth, options=options, limits=limits)
    except InputError as problem:
        error = problem
    suggestion = suggest(columns, rows, options.kind)
    kind = suggestion.kind if report is None else report.kind
    offered = dict.fromkeys((*(found.options if found else ()), *KIND_OPTIONS.get(kind or "", ())))
    return Preview(found.name if found else None, columns, rows, suggestion, report, error, tuple(offered))
