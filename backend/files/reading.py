"""Read uploaded files into one recording: the only door to the readers.

A pure function of the files, the site, the truth and the options. Steps: find each file's format, read it, put its
rows in order, merge the files, bring in the site and the truth, refuse what repeats, look for wrong units.

Row numbers count data rows from 1 (the line of names and blank lines are not counted). With several files they go on
from file to file in the order of the upload; a rejection also names its file, and its text the line in that file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from algorithms.errors import InputError, UnsupportedFormatError
from algorithms.recording import Kind, PolarPlots, Recording, ToaMarks
from algorithms.site import Origin, Site
from backend.files.content import NamedFile, inspect
from backend.files.equal_instants import one_row_an_instant
from backend.files.geodetic_plots import with_local_plots
from backend.files.merging import (
    FilePart,
    RowFiles,
    merge_parts,
    put_in_order,
    sort_by_time,
    without_duplicates,
    without_empty_marks,
)
from backend.files.mixed_radars import look_at_radars
from backend.files.options import ColumnSource, ReadLimits, ReadOptions
from backend.files.packing import with_members
from backend.files.plausibility import check_time_differences, look_at_altitudes, look_at_azimuths, look_at_times
from backend.files.reader import Part, Reader, Source, readers_by_name
from backend.files.report import Findings, ReadReport, ReadWarning, Rejection, some
from backend.files.rows import without_place
from backend.files.site_source import read_site
from backend.files.stations import fit_site
from backend.files.times import utc_seconds, utc_text
from backend.files.truth_file import TruthPoints, attach_truth, in_local_frame, read_truth_file
from backend.files.turns import with_turns

__all__ = [
    "ColumnSource",
    "NamedFile",
    "ReadLimits",
    "ReadOptions",
    "ReadReport",
    "ReadWarning",
    "Rejection",
    "read_recording",
    "read_truth",
]


def read_recording(
    files: Sequence[NamedFile],
    *,
    site: bytes | None = None,
    truth: NamedFile | None = None,
    options: ReadOptions | None = None,
    limits: ReadLimits | None = None,
) -> tuple[Recording, ReadReport]:
    """Read files of one kind, merged by time, with their site and truth.

    Raises
    ------
    InputError
        Nothing usable can be read, or what the user said contradicts the content; `pointer` names the field
        (`/file`, `/site/stations/0/name`, `/truth`, `/options/kind`).
    """
    options, limits = options or ReadOptions(), limits or ReadLimits()
    if not files:
        raise InputError("There is no file.", pointer="/file", remedy="Upload one.", code="no_file")
    findings = Findings()
    site_source = None if site is None else read_site(site, findings)
    origin = options.origin or (site_source.frame_origin() if isinstance(site_source, Site) else None)
    read = [_read_one(file, options, limits, origin) for file in with_members(files, limits)]
    if options.edition is not None and not any("edition" in readers_by_name()[name].options for name, _ in read):
        findings.warn("option_ignored", "The option edition was not used: it belongs to binary formats.")
    parts = [file for _, file in read]
    row_files = RowFiles.of(parts)
    part = sort_by_time(merge_parts(parts, findings))
    _refuse_nothing(part, findings, options)
    part = fit_site(part, site_source, options.origin, findings)
    part = with_local_plots(part, options.origin, findings)
    part = without_empty_marks(part, row_files, findings)
    part = without_duplicates(part, row_files, findings)
    part = one_row_an_instant(part, row_files, options.equal_times, findings)
    _refuse_nothing(part, findings, options)
    recording = _with_scans(part, options, findings)
    recording = _with_truth(replace(part, recording=recording), truth, options, limits, findings)
    recording = _with_start(recording, part.epoch_s, options.start_utc)
    look_at_times(recording, findings)
    look_at_altitudes(recording, findings)
    look_at_azimuths(recording, findings)
    if isinstance(recording, PolarPlots):
        look_at_radars(recording, findings)
    if isinstance(recording, ToaMarks) and recording.site is not None:
        check_time_differences(recording, recording.site)
    formats = dict.fromkeys(name for name, _ in read)
    return recording, ReadReport(
        kind=recording.kind,
        format="+".join(formats),
        rows_read=part.rows_read,
        rows_accepted=len(recording),
        rejections=tuple(sorted(findings.rejections, key=lambda r: r.row)),
        warnings=tuple(_summed(findings.warnings)),
        time_span_s=(float(recording.time_s[0]), float(recording.time_s[-1])),
    )


def _read_one(file: NamedFile, options: ReadOptions, limits: ReadLimits, origin: Origin | None) -> tuple[str, FilePart]:
    findings = Findings(file.label)
    source = Source(inspect(file, limits, findings), options, limits, findings, origin)
    reader = _reader_for(source)
    # A format that holds no measurements at all says so itself.
    if options.kind is not None and reader.kinds and options.kind not in reader.kinds:
        raise InputError(
            f"The format {reader.name} holds {' or '.join(reader.kinds)}, not {options.kind}.",
            pointer="/options/kind",
            remedy="Leave the kind out.",
            code="kind_unfit",
        )
    return reader.name, put_in_order(FilePart(reader.read(source), findings), options.order)


def _reader_for(source: Source) -> Reader:
    readers = readers_by_name()
    wanted = source.options.format
    if wanted is not None:
        if wanted not in readers:
            raise InputError(
                f"There is no format {wanted!r}.",
                pointer="/options/format",
                remedy=f"Use one of {', '.join(readers)}, or leave it out.",
                code="format_unknown",
            )
        return readers[wanted]
    found = next((r for r in readers.values() if r.detect(source)), None)
    if found is not None:
        return found
    # A text without columns says so itself.
    names = source.rows.names
    raise UnsupportedFormatError(
        f"{source.content.name} has the columns {some(names)}, which no reader knows." + without_place(source.rows),
        pointer="/options/mapping",
        remedy="Give the kind and map its columns to these (docs/formats.md lists them).",
    )


def _refuse_nothing(part: Part, findings: Findings, options: ReadOptions) -> None:
    if len(part.recording):
        return
    if findings.rejections:
        first = findings.rejections[0]
        raise InputError(
            f"None of {part.rows_read} rows can be used; the first: row {first.row}, {first.detail}.",
            pointer="/file",
            remedy="Check delimiter, column names and units.",
            code="no_usable_rows",
        )
    if options.where:
        raise InputError(
            "No row has the values that the filter asks for.",
            pointer="/options/where",
            remedy="Compare the values with the file.",
            code="where_matches_nothing",
        )
    raise InputError(
        "There is a line of names and nothing below it.",
        pointer="/file",
        remedy="Upload a file with measurements.",
        code="no_rows",
    )


def _with_scans(part: Part, options: ReadOptions, findings: Findings) -> Recording:
    """Number the scans of plots where the format asks for it or the user does."""
    plots = part.recording
    if isinstance(plots, PolarPlots):
        if part.marks is not None or options.scan_cut is not None:
            return with_turns(plots, options.scan_cut, options.scan_period_s, part.marks, findings)
    elif options.scan_cut is not None:
        findings.warn("option_ignored", "The option scan_cut was not used: it belongs to plots of radars.")
    return plots


def _with_truth(
    part: Part, truth: NamedFile | None, options: ReadOptions, limits: ReadLimits, findings: Findings
) -> Recording:
    recording = part.recording
    site = recording.site
    origin: Origin | None = options.origin or (site.origin if site is not None else None)
    local = in_local_frame(recording.truth_m, part.truth_geodetic, origin, findings)
    recording = replace(recording, truth_m=local)
    if truth is None:
        if part.truth is None:
            return recording
        return attach_truth(recording, part.epoch_s, part.truth, origin, options.truth_shift_s, findings)
    points = read_truth(truth, options, limits, recording.kind, findings)
    return attach_truth(recording, part.epoch_s, points, origin, options.truth_shift_s, findings)


def read_truth(
    file: NamedFile, options: ReadOptions, limits: ReadLimits, kind: Kind, findings: Findings
) -> TruthPoints:
    """Read a file of true positions: of a format that holds some, or a table.

    Raises
    ------
    InputError
        Nothing of it can serve; the pointer begins with `/truth` or names an option.
    """
    own = Findings(file.label)
    members = with_members([file], limits, pointer="/truth")
    source = Source(inspect(members[0], limits, own, pointer="/truth"), options, limits, own)
    for reader in readers_by_name().values():
        if reader.read_truth is not None and len(members) == 1 and reader.detect(source):
            points = reader.read_truth(source)
            if own.rejections:
                findings.warn(
                    "truth_rows_unusable",
                    f"Rows of the truth file that cannot be read: "
                    f"{some(f'row {r.row}, {r.detail}' for r in own.rejections)}.",
                    len(own.rejections),
                )
            findings.warnings += own.warnings
            return points
    return read_truth_file(file, options, limits, kind, findings)


def _with_start(recording: Recording, epoch_s: int | None, start_utc: str | None) -> Recording:
    """Let `time_s` count from the start that the user gave, or from the first whole second of the data."""
    if epoch_s is None:
        return replace(recording, start_utc=start_utc)
    if start_utc is None:
        return replace(recording, start_utc=utc_text(epoch_s))
    shift_s = epoch_s - utc_seconds(start_utc)
    tracks = recording.truth_tracks
    if tracks is not None:
        tracks = replace(tracks, time_s=tracks.time_s + shift_s)
    return replace(recording, time_s=recording.time_s + shift_s, truth_tracks=tracks, start_utc=start_utc)


def _summed(warnings: Sequence[ReadWarning]) -> list[ReadWarning]:
    """Join warnings that say the same of several files."""
    counts: dict[tuple[str, str], int] = {}
    for w in warnings:
        counts[w.code, w.detail] = counts.get((w.code, w.detail), 0) + w.count
    return [ReadWarning(code, detail, count) for (code, detail), count in counts.items()]
