"""Long tables of states are sorted once for all charts of a run, and never for the wrong entry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.result import Table
from backend.charts import estimates
from backend.charts.estimates import estimates_of
from backend.charts.target import run_view_of
from backend.charts.view import Entry
from tests import chart_views


def entry(count: int, seed: int, key: str) -> Entry:
    random = np.random.default_rng(seed)
    table = Table(
        {
            "track": random.integers(0, 5, count).astype(float),
            "time_s": random.permutation(count).astype(float),
            "row": np.arange(count),
            "velocity_east_mps": np.ones(count),
        }
    )
    return Entry("a", 0, "rdf", lambda _: table, dict, key=key)


@pytest.fixture(autouse=True)
def _nothing_kept() -> None:
    estimates._kept.clear()


def test_the_same_key_is_sorted_once() -> None:
    one = estimates_of(entry(30_000, 1, "result/a"))
    assert estimates_of(entry(30_000, 1, "result/a")).order is one.order
    assert (np.diff(one.time_s)[~one.starts[1:]] > 0).all()
    other = estimates_of(entry(30_000, 2, "result/b"))
    assert (other.order != one.order).any()
    with pytest.raises(ValueError, match="read-only"):
        one.order[0] = 7


def test_entries_without_a_key_and_short_ones_are_not_kept() -> None:
    for count, key in ((30_000, ""), (100, "result/a")):
        assert estimates_of(entry(count, 1, key)).order is not estimates_of(entry(count, 1, key)).order
    assert not estimates._kept


def test_one_target_is_sorted_by_itself() -> None:
    whole = entry(30_000, 1, "result/a")
    view = replace(chart_views.run(chart_views.marks()), entries=(whole,))
    (one,) = run_view_of(view, "A").entries
    assert one.key == ""


def test_old_ones_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(estimates, "_KEPT_ROWS", 70_000)
    for i in (0, 1, 0, 2):
        estimates_of(entry(30_000, i, f"result/{i}"))
    assert list(estimates._kept) == ["result/0", "result/2"]
