"""An ASTERIX file as plots, marks of the antenna, places of radars and true paths."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import InputError
from algorithms.recording import Floats, PolarPlots
from algorithms.site import Origin, Site
from backend.files.asterix.blocks import Blocks, Carried, Payload, split
from backend.files.asterix.capture import open_capture
from backend.files.asterix.categories import CATEGORIES
from backend.files.asterix.clock import (
    DAY_S,
    Stream,
    carried_on,
    complete,
    look_at_clocks,
    look_at_receipt,
    near_receipt,
    unfold,
)
from backend.files.asterix.edition import Edition, choose_edition, wanted_editions
from backend.files.asterix.final_format import is_final, open_final
from backend.files.asterix.packets import is_capture
from backend.files.asterix.plots import Reports, polar_plots, reports_of, source_name
from backend.files.asterix.records import Records
from backend.files.asterix.reference import as_plots, target_names, truth_points
from backend.files.asterix.service import radar_places, turn_marks
from backend.files.reader import Part, Source
from backend.files.report import Findings, some
from backend.files.rows import end_at_limit
from backend.files.truth_file import TruthPoints
from backend.files.turns import TurnMarks

# Longest read of octets behind an item.
_MARGIN = bytes(16)
# Blocks of a category on which its editions are tried, spread over the file.
_TRIED = 1000
_AT_ONCE = 1 << 16
# A plot takes some 20 to 60 bytes, with the heads of a captured packet some 100.
_BYTES_A_ROW, _LEAST_ROWS = 64, 10_000


@dataclass(frozen=True)
class _Opened:
    """A file that was walked over: its reports in the order of the file, and how many records it has."""

    reports: Reports
    records: int
    times: str
    broken: int


def read_plots(source: Source) -> Part:
    """Read plots; positions of better systems in the same file become its truth."""
    findings = source.findings
    opened = _open(source)
    reports, time_s, epoch_s = _timed(opened, findings)
    use = np.array([CATEGORIES[c].use for c in reports.category.tolist()], object)
    # CAT 010 mixes target reports (message type 1) with those on the state of the system.
    service = (use == "service") | ((reports.category == 10) & (reports.codes["message"] > 1))
    is_reference = use == "reference"
    is_plot = ~service & ~is_reference
    truth: TruthPoints | None = None
    places: dict[str, dict[str, Any]] = radar_places(reports.take(service))
    origin: Origin | None = None
    marks: TurnMarks | None = None
    if is_plot.any():
        keep = _usable(reports, time_s, is_reference, findings, at=("latitude", "longitude"))
        if keep.any():
            truth = truth_points(reports.take(keep), time_s[keep], epoch_s, findings)
        wanted, chosen = is_plot, reports
        marks = _marks(reports, time_s, service, findings)
    else:
        chosen, origin = as_plots(reports, source.origin, findings)
        wanted = is_reference
    keep = _usable(chosen, time_s, wanted, findings, at=("range", "azimuth"))
    plots = polar_plots(chosen.take(keep), time_s[keep], findings)
    if not is_plot.any():
        target, targets = target_names(chosen.take(keep))
        plots = replace(plots, target=target, targets=targets or ("",))
    return Part(
        plots,
        epoch_s,
        opened.records,
        len(plots) + len(findings.rejections),
        site=_site(plots, places, origin),
        truth=truth,
        marks=marks,
    )


def read_truth(source: Source) -> TruthPoints:
    """Read the reference positions of a file that is given as truth."""
    opened = _open(source)
    reports, time_s, epoch_s = _timed(opened, source.findings)
    reference = np.array([CATEGORIES[c].use == "reference" for c in reports.category.tolist()], bool)
    keep = _usable(reports, time_s, reference, source.findings, at=("latitude", "longitude"))
    if not keep.any():
        raise InputError(
            "The truth file has no positions of CAT 020, 021 or 062.",
            pointer="/truth",
            remedy="Give a file with such reports, or a CSV.",
            code="no_usable_rows",
        )
    return truth_points(reports.take(keep), time_s[keep], epoch_s, source.findings)


def decodes(data: bytes) -> bool:
    """Whether most of the data blocks at the beginning of a file decode by some edition."""
    blocks = split(Carried("", data, [Payload(0, len(data))]))
    tried = [(int(s), int(e), int(c)) for s, e, c in zip(blocks.start, blocks.end, blocks.category, strict=True)]
    tried = [b for b in tried if b[2] in CATEGORIES][:16]
    good = 0
    nothing = wanted_editions(None)
    for start, end, category in tried:
        edition, _ = choose_edition(data, category, [(start, end)], nothing, Findings())
        good += edition.walk(data, (start, end), 0)[1] == end
    return bool(tried) and 2 * good > len(tried)


def _open(source: Source) -> _Opened:
    findings = source.findings
    # What is read stays in memory: more than the rows that a recording may have can be left where it is.
    most = _BYTES_A_ROW * max(source.limits.max_rows, _LEAST_ROWS)
    with source.content.open_bytes() as stream:
        data = stream.read(most)
        cut = len(data) == most and bool(stream.read(1))
    if cut:
        findings.warn(
            "rows_beyond_limit",
            f"{source.content.name} is longer than {most} bytes; only the first of them were read, and what they end "
            "within was left out. Raise the setting FILTERROOM_MAX_ROWS, or upload the rest by itself.",
        )
    if is_capture(data[:64]):
        carried = open_capture(data, findings)
        if not carried.payloads:
            raise InputError(
                f"{source.content.name} is a network capture in which nothing carries ASTERIX.",
                pointer="/file",
                remedy="Capture the ports of the radar, or leave the filter out that removed them.",
                code="no_asterix",
            )
    elif is_final(data[: 1 << 16]):
        carried = open_final(data)
    else:
        carried = Carried("raw", data, [Payload(0, len(data))])
    blocks = split(carried)
    # Where reading was ended by the limit the last block is not broken, it only goes on.
    last = -1 if cut and len(blocks.end) and blocks.category[-1] < 0 and blocks.end[-1] == len(data) else None
    blocks = blocks.first(last)
    # No block is without a record, so these are enough to see that there are more.
    return _walk(carried, blocks.first(source.limits.max_rows + 1), source, told=cut)


def _walk(carried: Carried, blocks: Blocks, source: Source, *, told: bool) -> _Opened:
    data, findings = carried.data, source.findings
    editions = _editions(data, blocks, source)
    others: dict[int, int] = {}
    number = 0
    broken = 0
    counts, hashes = array("q"), array("q")
    for start, end, category in _each(blocks):
        before = number
        edition = editions.get(category)
        if edition is not None:
            count, behind = edition.walk(data, (start, end), number + 1)
            number += count
            if behind < end:
                number += 1
                broken += 1
                why = edition.explain(data, behind, end)
                findings.reject(
                    number,
                    "undecodable_record",
                    f"byte {carried.moved.file_position(behind)}: a record of CAT {category:03d} does not decode by "
                    f"edition {edition.text}: {why}; the last {end - behind} bytes of its data block were left out",
                )
            hashes.append(hash(data[start:end]))
        elif category < 0:
            number += 1
            broken += 1
            first, last = carried.moved.file_position(start), carried.moved.file_position(end - 1)
            findings.reject(number, "no_data_block", f"bytes {first} to {last}: {blocks.reasons[start]}")
        else:
            number += 1
            others[category] = others.get(category, 0) + 1
        counts.append(number - before)
        if number >= source.limits.max_rows and len(counts) < len(blocks.start):
            if not told:
                end_at_limit(source.content.name, source.limits.max_rows, findings)
            break
    repeats = len(hashes) - len(np.unique(np.frombuffer(hashes, np.int64))) if hashes else 0
    if repeats:
        findings.warn(
            "blocks_repeated",
            "Data blocks stand in the file more than once, as where two networks were recorded; plots that repeat are "
            "rejected as such.",
            repeats,
        )
    if others:
        words = some(f"CAT {c:03d} ({n})" for c, n in sorted(others.items()))
        findings.warn(
            "categories_unread", f"Data blocks of categories that are not read: {words}.", sum(others.values())
        )
    octets = np.frombuffer(data + _MARGIN, np.uint8)
    tables = [Records(CATEGORIES[c], edition, octets) for c, edition in editions.items()]
    reports = reports_of([t for t in tables if len(t)])
    # Record numbers begin at 1, so the block of record n is the first that ends at n or later.
    block = np.searchsorted(np.cumsum(counts), reports.number)
    reports = replace(reports, received_s=blocks.time_s[block] if len(counts) else np.empty(0))
    if carried.moved.start:
        in_file = np.array([carried.moved.file_position(p) for p in reports.position.tolist()], np.int64)
        reports = replace(reports, position=in_file)
    return _Opened(reports, number, carried.times, broken)


def _each(blocks: Blocks) -> Iterator[tuple[int, int, int]]:
    """Start, end and category of each block; a million of them at once would be as many objects."""
    for first in range(0, len(blocks.start), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        columns = (blocks.start[part], blocks.end[part], blocks.category[part])
        yield from zip(*(column.tolist() for column in columns), strict=True)


def _editions(data: bytes, blocks: Blocks, source: Source) -> dict[int, Edition]:
    wanted = wanted_editions(source.options.edition)
    editions: dict[int, Edition] = {}
    words: list[str] = []
    for category in np.unique(blocks.category).tolist():
        if category in CATEGORIES:
            mine = np.flatnonzero(blocks.category == category)
            mine = mine[:: max(1, len(mine) // _TRIED)]
            pairs = list(zip(blocks.start[mine].tolist(), blocks.end[mine].tolist(), strict=True))
            editions[category], text = choose_edition(data, category, pairs, wanted, source.findings)
            words.append(text)
    if words:
        source.findings.warn(
            "editions_used",
            f"Editions by which the file was read (= others fit as well): {'; '.join(words)}. The option edition names "
            "another.",
            len(words),
        )
    return editions


def _timed(opened: _Opened, findings: Findings) -> tuple[Reports, Floats, int | None]:
    """Reports with their instants: from the epoch where a capture tells the date, else from the first midnight."""
    reports = opened.reports
    full = np.where(reports.is_truncated | ~(reports.time_s < DAY_S), np.nan, reports.time_s)
    received = reports.received_s
    by_date = opened.times == "utc" and bool(np.isfinite(received).any())
    if by_date:
        time_s = near_receipt(full, received)
    else:
        time_s = np.full(len(full), np.nan)
        known = np.flatnonzero(np.isfinite(full))
        time_s[known] = unfold(full[known])
        # The recorder's time of day counts from the same midnight.
        timed = np.flatnonzero(np.isfinite(received))
        received = received.copy()
        received[timed] = unfold(received[timed])
    time_s = _completed(reports, time_s, received, findings)
    untimed = np.isnan(time_s) & np.isnan(reports.time_s) & np.isfinite(received)
    if untimed.any():
        findings.warn(
            "time_of_receipt", "Records without a time got that of their receipt by the recorder.", int(untimed.sum())
        )
        time_s = np.where(untimed, received, time_s)
    _look(reports, time_s, received if by_date else np.full(len(time_s), np.nan), findings)
    if not by_date:
        return reports, time_s, None
    finite = time_s[np.isfinite(time_s)]
    epoch_s = int(np.floor(finite.min())) if finite.size else 0
    return reports, time_s - epoch_s, epoch_s


def _completed(reports: Reports, time_s: Floats, received_s: Floats, findings: Findings) -> Floats:
    truncated = reports.is_truncated
    if not truncated.any():
        return time_s
    out = time_s.copy()
    alone = 0
    for source in np.unique(reports.source[truncated]).tolist():
        mine = np.flatnonzero(reports.source == source)
        full = carried_on(time_s[mine])
        full = np.where(np.isfinite(full), full, carried_on(received_s[mine]))
        short = truncated[mine]
        if np.isfinite(full).all():
            out[mine[short]] = complete(reports.time_s[mine[short]], full[short])
        else:
            alone += int(short.sum())
            out[mine[short]] = unfold(reports.time_s[mine[short]], 512.0)
    if alone:
        findings.warn(
            "time_truncated",
            "Times that are only known within 512 s, with no message of CAT 002 that completes them, count from an "
            "unknown start.",
            alone,
        )
    return out


def _look(reports: Reports, time_s: Floats, received_s: Floats, findings: Findings) -> None:
    timed = np.flatnonzero(np.isfinite(time_s))
    if not timed.size:
        return
    days = np.floor(time_s[timed] / DAY_S)
    if days.max() > days.min():
        findings.warn("midnight_crossed", "The recording goes over midnight; times go on counting.", int(np.ptp(days)))
    look_at_receipt(time_s, received_s, findings)


def _marks(reports: Reports, time_s: Floats, service: NDArray[np.bool_], findings: Findings) -> TurnMarks:
    """Marks of the antenna; those of a radar whose clocks contradict each other are left out."""
    timed = np.flatnonzero(np.isfinite(time_s) & (reports.source >= 0))
    streams: list[Stream] = []
    keys = reports.category[timed] * 65536 + reports.source[timed]
    for key in np.unique(keys).tolist():
        category, source = divmod(key, 65536)
        streams.append(Stream(f"CAT {category:03d} {source_name(source)}", np.flatnonzero(keys == key)))
    apart = look_at_clocks(time_s[timed], reports.number[timed], streams, findings)
    contrary = {
        source
        for source in np.unique(reports.source[service]).tolist()
        if len(
            {
                f"CAT {c:03d} {source_name(source)}" in apart
                for c in np.unique(reports.category[(reports.source == source)])
            }
        )
        > 1
    }
    use = service & ~np.isin(reports.source, list(contrary))
    marks = turn_marks(reports.take(use), time_s[use])
    nothing, none = np.empty(0, np.int64), np.empty(0)
    return marks if marks is not None else TurnMarks((), nothing, none, none, {})


def _usable(
    reports: Reports, time_s: Floats, wanted: NDArray[np.bool_], findings: Findings, at: tuple[str, str]
) -> NDArray[np.bool_]:
    """Which of the wanted reports have a time and a position; the others are rejected."""
    has_time = np.isfinite(time_s)
    numbers = reports.numbers
    in_plane = np.isfinite(numbers["x"]) & np.isfinite(numbers["y"])
    has_place = in_plane | (np.isfinite(numbers[at[0]]) & np.isfinite(numbers[at[1]]))
    bad_time = ~has_time & ~(reports.time_s < DAY_S) & np.isfinite(reports.time_s)
    problems = (
        (bad_time, "out_of_range", "its time of day is later than midnight"),
        (~has_time & ~bad_time, "missing_value", "it has no time"),
        (has_time & ~has_place, "missing_value", "it has no position"),
    )
    for mask, code, words in problems:
        for i in np.flatnonzero(mask & wanted).tolist():
            findings.reject(
                int(reports.number[i]), code, f"byte {reports.position[i]}, CAT {reports.category[i]:03d}: {words}"
            )
    return np.asarray(wanted & has_time & has_place)


def _site(plots: PolarPlots, places: Mapping[str, dict[str, Any]], origin: Origin | None) -> Site | None:
    """The site that the file itself tells; None unless it places every radar."""
    used = [plots.radars[i] for i in np.unique(plots.radar).tolist()]
    if origin is not None:
        radars = [{"name": name or "origin", "east_m": 0.0, "north_m": 0.0} for name in used]
        return Site.model_validate({"origin": origin, "radars": radars[:1]}) if len(used) == 1 else None
    if not used or any(name not in places for name in used):
        return None
    return Site.model_validate({"radars": [places[name] for name in used]})
