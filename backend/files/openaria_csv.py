"""OpenARIA CSV: `partition, subpartition, timestamp, vehicle_id, latitude, longitude, altitude, ...` without names.

Timestamps are ISO 8601, UTC where they say nothing; the altitude is in feet. Cells after the seventh are anybody's.
"""

from __future__ import annotations

import re
from datetime import datetime

from backend.files.cells import Problem
from backend.files.position_reports import (
    FOOT_M,
    PositionReport,
    number,
    read_reports,
    refuse_as_measurements,
    share_of_lines,
    unix_time,
)
from backend.files.reader import Reader, Source
from backend.files.truth_file import TruthPoints

_CELLS = 7
_LINE = re.compile(r"[^,]*,[^,]*,\s*\d{4}-\d\d-\d\dT[\d:.]+\S*,\s*[^,\s][^,]*,\s*[+-]?\d+\.?\d*,\s*[+-]?\d+\.?\d*,")


def _detect(source: Source) -> bool:
    if source.options.mapping or source.options.truth_mapping:
        return False
    fitting, lines = share_of_lines(source, _LINE)
    return 2 * fitting > lines


def _parse(line: str) -> PositionReport | Problem:
    cells = [cell.strip() for cell in line.split(",", _CELLS)]
    if len(cells) < _CELLS:
        return Problem("wrong_cell_count", f"{len(cells)} cells, and the format has at least {_CELLS}")
    stamp, name, *place = cells[2:_CELLS]
    if not name:
        return Problem("missing_value", "no name of the vehicle")
    try:
        second, microsecond = unix_time(datetime.fromisoformat(stamp))
    except ValueError:
        return Problem("not_a_date", f"{stamp!r} is no date with a time (ISO 8601)")
    values = [number(cell) for cell in place]
    for cell, value in zip(place, values, strict=True):
        if value is None:
            return Problem("not_a_number", f"holds {cell!r}, which is not a number")
    latitude, longitude, feet = (v for v in values if v is not None)
    return PositionReport(second, microsecond, name, latitude, longitude, feet * FOOT_M)


def _read_truth(source: Source) -> TruthPoints:
    return read_reports(source, _parse)


READER = Reader(
    name="openaria_csv",
    title="OpenARIA CSV of positions (truth only)",
    kinds=(),
    detect=_detect,
    read=refuse_as_measurements,
    read_truth=_read_truth,
)
