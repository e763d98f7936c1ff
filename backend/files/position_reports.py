"""Lines of position reports, each with an instant, a name, latitude, longitude and altitude: true paths, no plots.

What the formats of such lines share. They have no line of names; a line that is none of theirs is rejected and listed,
for files of this kind come from logs and hold all sorts of things.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from algorithms.errors import InputError
from backend.files.cells import Problem
from backend.files.reader import Part, Source
from backend.files.rows import end_at_limit
from backend.files.truth_file import TruthPoints

FOOT_M = 0.3048
# Of a file's first lines so many are looked at (the last may be cut off), and a line longer than this is not read.
_LOOKS = 400
_LONGEST = 131_072


@dataclass(frozen=True)
class PositionReport:
    """One line: the instant in Unix seconds and microseconds within, the name, the place in degrees and m."""

    second: int
    microsecond: int
    name: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float


ParseLine = Callable[[str], PositionReport | Problem]


def share_of_lines(source: Source, pattern: re.Pattern[str]) -> tuple[int, int]:
    """Return how many of a text's first lines fit a pattern, and how many there are."""
    content = source.content
    if not content.is_text:
        return 0, 0
    lines = content.head.decode(content.encoding, "replace").splitlines()
    whole = [line for line in lines[:_LOOKS] if line.strip()]
    return sum(pattern.match(line) is not None for line in whole), len(whole)


def read_reports(source: Source, parse: ParseLine) -> TruthPoints:
    """Read all lines; `row` counts those that are not blank.

    Raises
    ------
    InputError
        There are more rows than the limit, or none can be used.
    """
    rows, seconds = array("q"), array("q")
    micros, codes = array("q"), array("q")
    place = array("d")
    names: dict[str, int] = {}
    row = 0
    with source.content.open_text() as text:
        for number, line in enumerate(text, start=1):
            if not line.strip():
                continue
            row += 1
            if row > source.limits.max_rows:
                end_at_limit(source.content.name, source.limits.max_rows, source.findings)
                break
            found = parse(line) if len(line) <= _LONGEST else _too_long()
            if isinstance(found, PositionReport):
                found = _in_range(found)
            if isinstance(found, Problem):
                source.findings.reject(row, found.code, f"line {number}: {found.detail}")
                continue
            rows.append(row)
            seconds.append(found.second)
            micros.append(found.microsecond)
            codes.append(names.setdefault(found.name, len(names)))
            place.extend((found.latitude_deg, found.longitude_deg, found.altitude_m))
    if not rows:
        raise InputError(
            "The truth file has no usable row.",
            pointer="/truth",
            remedy="Compare the lines with docs/formats.md.",
            code="no_usable_rows",
        )
    whole = np.frombuffer(seconds, np.int64)
    epoch_s = int(whole.min())
    geodetic = np.frombuffer(place, np.float64).reshape(-1, 3).copy()
    geodetic[:, :2] = np.radians(geodetic[:, :2])
    unknown = np.full((len(rows), 3), np.nan)
    return TruthPoints(
        row=np.array(rows, np.int64),
        time_s=(whole - epoch_s) + np.frombuffer(micros, np.int64) * 1e-6,
        epoch_s=epoch_s,
        target=np.array(codes, np.int64),
        targets=tuple(names),
        names_targets=True,
        truth_m=unknown,
        truth_velocity_mps=unknown.copy(),
        truth_geodetic=geodetic,
    )


def refuse_as_measurements(source: Source) -> Part:
    """Say that such a file tells where aircraft were, not what a radar measured."""
    raise InputError(
        f"{source.content.name} holds positions of tracks and no measurements.",
        pointer="/file",
        remedy="Give it as the truth of a recording.",
        code="truth_only",
    )


def unix_time(moment: datetime) -> tuple[int, int]:
    """Seconds of the Unix epoch and microseconds; without a zone the moment is UTC."""
    aware = moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
    return int(aware.replace(microsecond=0).timestamp()), aware.microsecond


def number(cell: str) -> float | None:
    """Return a finite number in ASCII digits, None for anything else."""
    try:
        value = float(cell) if cell.isascii() and "_" not in cell else np.nan
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def _in_range(report: PositionReport) -> PositionReport | Problem:
    for column, value, largest in (
        ("latitude", report.latitude_deg, 90),
        ("longitude", report.longitude_deg, 180),
    ):
        if abs(value) > largest:
            return Problem("out_of_range", f"{column} {value:g} must lie between {-largest} and {largest}")
    return report


def _too_long() -> Problem:
    return Problem("line_too_long", f"the line is longer than {_LONGEST} characters")
