"""Real lines of air-traffic control as truth: every line is a position or is counted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from backend.files.content import inspect
from backend.files.nop_lines import READER
from backend.files.options import ReadLimits, ReadOptions
from backend.files.packing import NamedFile
from backend.files.reader import Source
from backend.files.report import Findings


def source_of(path: Path) -> Source:
    findings = Findings(path.name)
    limits = ReadLimits()
    return Source(inspect(NamedFile(path.name, path), limits, findings), ReadOptions(), limits, findings)


@pytest.mark.parametrize(
    ("name", "lines", "tracks", "without_altitude"),
    [
        ("sample_from_D21.txt.gz", 33_500, None, 1198),
        ("lastPointsHaveZeroAltitude.txt", 665, 1, None),
        ("modeCSwap_1.txt", 552, None, None),
    ],
)
def test_every_line_is_used_or_told(
    shared_data: Path, name: str, lines: int, tracks: int | None, without_altitude: int | None
) -> None:
    source = source_of(shared_data / "tracks_openaria" / name)
    assert READER.detect(source)
    assert READER.read_truth is not None
    points = READER.read_truth(source)
    refused = source.findings.rejections
    assert len(points.row) + len(refused) == lines
    assert {r.code for r in refused} <= {"missing_value"}
    assert without_altitude in (None, len(refused))
    assert tracks in (None, len(points.targets))
    assert points.truth_geodetic is not None
    assert np.isfinite(points.truth_geodetic).all()


def test_a_file_without_a_single_report_is_not_taken_for_one(shared_data: Path) -> None:
    assert not READER.detect(source_of(shared_data / "tracks_openaria" / "flawDataThatCanBreakParser.txt"))
