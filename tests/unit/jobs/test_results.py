from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from algorithms.result import Metric, Table
from backend.files.store import Store
from backend.jobs import result_file, results
from backend.jobs.outcome import Outcome, block_arrays, outcome_of


def outcome(offset: float = 0.0, **more: Table) -> Outcome:
    return Outcome(
        "done",
        arrays={"state": np.arange(6.0).reshape(2, 3) + offset},
        tables={
            "states": Table({"row": np.array([1, 2]), "status": ["updated", None]}),
            "tracks": Table({"track": np.array([1]), "end_s": np.array([np.nan]), "used": np.array([True])}),
            **more,
        },
        metrics=(Metric("nis", 1.0 + offset, "", 2, 0.9, 1.1), Metric("nis", math.nan, "", 1, target="7")),
        settings={"sigma": {"value": np.float64(2.0), "source": "site"}, "bad": {"value": math.inf, "source": "run"}},
        notes=({"code": "c", "detail": "d", "count": 2},),
        seconds=1.25,
        software={"cpu": "znver4", "numpy": "2.4"},
    )


def test_a_block_survives_the_store(tmp_path: Path) -> None:
    store = Store(tmp_path)
    before = outcome()
    after = outcome_of(store.get_arrays(store.put_arrays(block_arrays(before))))
    np.testing.assert_array_equal(after.arrays["state"], before.arrays["state"])
    assert {n: list(t.rows()) for n, t in after.tables.items()} == {n: list(t.rows()) for n, t in before.tables.items()}
    assert after.metrics[0] == before.metrics[0]
    assert after.metrics[1].value is None
    assert after.settings["sigma"] == {"value": 2.0, "source": "site"}
    assert after.settings["bad"]["value"] is None
    assert (after.notes, after.seconds, after.software) == (before.notes, before.seconds, before.software)


def test_compose_separates_big_and_small_tables() -> None:
    long = Table({"row": np.arange(result_file.BIG_ROWS + 1)})
    composed = results.compose(["rdf", "rdfv"], [outcome(decisions=long), outcome(1.0)])
    assert [t.name for t in composed.tables] == ["metrics", "tracks"]
    assert set(composed.arrays) >= {
        "rdf/state",
        "rdfv/state",
        "tables/states/rdf/row",
        "tables/states/rdfv/status.categories",
        "tables/decisions/rdf/row",
    }
    tracks = composed.tables[1]
    assert tracks.columns == [("label", "text"), ("track", "integer"), ("end_s", "number"), ("used", "boolean")]
    assert tracks.rows == [["rdf", 1, None, True], ["rdfv", 1, None, True]]
    assert composed.summary == {
        "nis": {
            "rdf": {"value": 1.0, "ci95": [0.9, 1.1], "unit": ""},
            "rdfv": {"value": 2.0, "ci95": [0.9, 1.1], "unit": ""},
        }
    }
    assert composed.entries[0]["tables"] == {"states": 2, "tracks": 1, "decisions": result_file.BIG_ROWS + 1}


def test_metrics_without_a_value_are_null_rows() -> None:
    metrics = results.compose(["rdf"], [outcome()]).tables[0]
    assert [c for c, _ in metrics.columns][:5] == ["metric", "label", "segment", "target", "value"]
    assert metrics.rows[1] == ["nis", "rdf", "", "7", None, None, None, "", 1]


def test_a_column_that_one_label_lacks_is_null_there() -> None:
    extra = Table({"track": np.array([5]), "quality": np.array([3]), "why": ["late"]})
    composed = results.compose(["a", "b"], [outcome(), outcome(tracks=extra)])
    rows = composed.tables[1].rows
    assert composed.tables[1].columns[-2:] == [("quality", "number"), ("why", "text")]
    assert rows == [["a", 1, None, True, None, None], ["b", 5, None, None, 3.0, "late"]]


def test_different_processors_are_all_named() -> None:
    other = Outcome("done", software={"cpu": "skylake", "numpy": "2.4"})
    assert results.compose(["a", "b"], [outcome(), other]).software == {"cpu": "skylake, znver4", "numpy": "2.4"}


@pytest.mark.parametrize("label", ["a/b", "tables", "метка 100 м"])
def test_labels_of_any_kind_find_their_own_arrays(label: str) -> None:
    composed = results.compose([label, "other"], [outcome(), outcome(1.0)])
    np.testing.assert_array_equal(composed.arrays[f"{label}/state"], outcome().arrays["state"])
