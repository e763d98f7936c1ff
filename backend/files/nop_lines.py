"""NOP lines of air-traffic control, `[RH],STARS,D21,03/24/2018,14:47:52.471,EDV4062,...`: positions of tracks.

STARS, AGW, Center and MEARTS lines begin alike: cell 9 is the altitude in hundreds of feet, 12 and 13 are latitude and
longitude, 14 is the number of the track, which names the target. Times are UTC; in dates of Center and MEARTS dashes
stand in place of slashes. A track that has no altitude says 000,
so such a row has no position; lines of other systems, whose cells mean other things, are rejected.
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

_SYSTEMS = ("STARS", "AGW", "CENTER", "MEARTS")
_LINE = re.compile(r"\[RH\],")
_HUNDRED_FEET_M = 100 * FOOT_M
_CELLS = 15


def _detect(source: Source) -> bool:
    named = source.options.mapping or source.options.truth_mapping
    return not named and share_of_lines(source, _LINE)[0] > 0


def _parse(line: str) -> PositionReport | Problem:
    cells = line.split(",", _CELLS)
    if cells[0] != "[RH]":
        return Problem("not_a_report", "the line does not begin with [RH]")
    if len(cells) <= _CELLS:
        return Problem("wrong_cell_count", f"{len(cells)} cells, and the format has at least {_CELLS + 1}")
    if cells[1].upper() not in _SYSTEMS:
        known = "STARS, AGW, Center and MEARTS"
        return Problem("not_a_report", f"lines of {cells[1]} are not known, only those of {known}")
    facility, date, time, altitude, track = cells[2], cells[3], cells[4], cells[9], cells[14]
    try:
        second, microsecond = unix_time(datetime.strptime(f"{date.replace('-', '/')} {time}", "%m/%d/%Y %H:%M:%S.%f"))
    except ValueError:
        return Problem("not_a_date", f"{date} {time} is no date with a time such as 03/24/2018 14:47:52.471")
    values = [number(cell) for cell in (altitude, cells[12], cells[13])]
    if values[0] is None or values[0] == 0:
        return Problem("missing_value", f"no altitude ({altitude or 'empty'})")
    for cell, value in zip((altitude, cells[12], cells[13]), values, strict=True):
        if value is None:
            return Problem("not_a_number", f"holds {cell!r}, which is not a number")
    if not track:
        return Problem("missing_value", "no number of a track")
    flight_level, latitude, longitude = (v for v in values if v is not None)
    name = f"{facility}/{track}"
    return PositionReport(second, microsecond, name, latitude, longitude, flight_level * _HUNDRED_FEET_M)


def _read_truth(source: Source) -> TruthPoints:
    points = read_reports(source, _parse)
    source.findings.warn(
        "truth_pressure_altitude",
        "The altitudes of the truth are barometric, to 100 feet; they were taken as heights over the ellipsoid.",
        len(points.row),
    )
    return points


READER = Reader(
    name="nop_lines",
    title="NOP lines of air-traffic control, STARS, AGW, Center and MEARTS (truth only)",
    kinds=(),
    detect=_detect,
    read=refuse_as_measurements,
    read_truth=_read_truth,
)
