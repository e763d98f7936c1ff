"""Columns of a million records: what no record has takes no room, whatever is cut from it or joined to it."""

from __future__ import annotations

import numpy as np
import pytest

from backend.files.asterix.categories import CATEGORIES
from backend.files.asterix.edition import choose_edition, wanted_editions
from backend.files.asterix.plots import Reports, reports_of
from backend.files.asterix.records import Records, constant
from backend.files.report import Findings
from tests.asterix_files import cat048, north, plot


def records(blocks: list[bytes]) -> Records:
    category = blocks[0][0]
    data = b"".join(blocks)
    ends = np.cumsum([len(block) for block in blocks]).tolist()
    pairs = list(zip([0, *ends[:-1]], ends, strict=True))
    edition, _ = choose_edition(data, category, pairs, wanted_editions(None), Findings())
    for number, pair in enumerate(pairs):
        edition.walk(data, pair, number + 1)
    return Records(CATEGORIES[category], edition, np.frombuffer(data + bytes(16), np.uint8))


@pytest.fixture(scope="module")
def reports() -> Reports:
    plots = records([cat048(plot(t, 20.0 + t, 10.0, level=100)) for t in (1.0, 2.0, 3.0)])
    return reports_of([plots, records([north(4.0), north(8.0)])])


def test_what_no_record_has_takes_no_room(reports: Reports) -> None:
    assert reports.numbers["latitude"].strides == (0,)
    assert np.isnan(reports.numbers["latitude"]).tolist() == [True] * 5
    assert reports.codes["track"].tolist() == [-1] * 5
    assert reports.codes["track"].strides == (0,)
    some = reports.take(np.array([True, False, True, True, False]))
    assert (some.codes["track"].tolist(), some.codes["track"].strides) == ([-1] * 3, (0,))
    assert reports.take(np.array([4, 0])).numbers["latitude"].shape == (2,)


def test_what_one_of_them_has_is_kept(reports: Reports) -> None:
    assert np.isfinite(reports.numbers["range"]).sum() == 3
    assert (reports.codes["message"] == 1).sum() == 2
    kept = reports.take(np.isfinite(reports.numbers["range"]))
    np.testing.assert_allclose(kept.numbers["level"], 100 * 30.48)


def test_one_value_many_times() -> None:
    column = constant(-1, 1_000_000)
    assert (column.shape, column.dtype, column.strides) == ((1_000_000,), np.int64, (0,))
