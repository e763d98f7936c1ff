from __future__ import annotations

import datetime as dt
from typing import Any

import pytest

from backend.api.compare_tables import best_places, compared_entries, parameters
from backend.db.runs import Entry, Run


def run(run_id: str, label: str, *entries: str, settings: dict[str, Any] | None = None) -> Run:
    used = [{"label": e, "settings": settings or {}} for e in entries]
    return Run(
        id=run_id,
        state="succeeded",
        label=label,
        tags=(),
        created_at=dt.datetime(2026, 1, 1, tzinfo=dt.UTC),
        started_at=None,
        finished_at=None,
        source={"recording_id": "r", "name": "marks.csv"},
        algorithms=tuple(Entry("rdf", e, {}) for e in entries),
        seed=0,
        trials=1,
        progress_done=1,
        progress_total=1,
        error=None,
        summary=None,
        entries=used,
        software=None,
        result_sha256=None,
    )


def test_labels_are_unique_whatever_runs_are_called() -> None:
    unnamed = compared_entries([run("1" * 16, "", "a"), run("2" * 16, "", "a")])
    assert [e.label for e in unnamed] == ["marks.csv 111111 / a", "marks.csv 222222 / a"]
    misleading = compared_entries([run("1" * 16, "a", "b / c"), run("2" * 16, "a / b", "c")])
    assert len({e.label for e in misleading}) == 2


@pytest.mark.parametrize(
    ("metric", "values", "best"),
    [
        ("rms_horizontal_m", [3.0, 2.0, None, 2.0], [1, 3]),
        ("answered_share", [0.9, 0.99], [1]),
        ("over_5km_share", [0.1, 0.2], [0]),
        ("nis", [1.0, 2.0], []),
        ("claimed_horizontal_m", [1.0, 2.0], []),
        ("rms_horizontal_m", [2.0, 2.0], []),
        ("rms_horizontal_m", [None, 2.0], []),
    ],
)
def test_best_value(metric: str, values: list[float | None], best: list[int]) -> None:
    assert best_places(metric, values) == best


def test_a_parameter_that_only_one_algorithm_has_is_no_difference() -> None:
    one = run("1" * 16, "one", "a", settings={"sigma_m": {"value": 1, "source": "run"}})
    two = run("2" * 16, "two", "a", settings={"sigma_m": {"value": 1, "source": "default"}})
    three = run("3" * 16, "three", "a")
    (row,) = parameters(compared_entries([one, two, three]))
    assert (row.name, row.values[2], row.differs) == ("sigma_m", None, False)
