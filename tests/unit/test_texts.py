"""Columns of texts as codes, and tables that are read column by column."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.result import StoredColumns, Table
from algorithms.texts import Texts


def test_texts_read_like_the_list_they_were_made_of() -> None:
    values = ["b", None, "a", "b"]
    texts = Texts.of(values)
    assert list(texts) == values
    assert texts == values
    assert texts != ["b", None, "a", "a"]
    assert texts[1] is None
    assert texts[-1] == "b"
    assert list(texts[np.array([2, 0])]) == ["a", "b"]
    assert list(texts[1:3]) == [None, "a"]
    assert list(texts[texts.are("b")]) == ["b", "b"]
    assert texts.are(None).tolist() == [False, True, False, False]
    assert texts.words().tolist() == ["b", "", "a", "b"]


def test_the_empty_text_is_none() -> None:
    assert list(Texts.coded(np.array([1, 0]), ("", "x"))) == ["x", None]
    assert Texts.of(["", "x"]).are(None).tolist() == [True, False]


def test_parts_with_other_codes_are_joined_by_their_texts() -> None:
    joined = Texts.joined([Texts.of(["a", "b"]), Texts.of([]), Texts.of(["b", None]), Texts.repeated("c", 2)])
    assert list(joined) == ["a", "b", "b", None, "c", "c"]
    assert len(set(joined.categories)) == len(joined.categories)


def test_a_stored_table_reads_only_what_is_asked_for() -> None:
    table = Table({"time_s": np.arange(3.0), "status": ["on", None, "on"], "n": np.array([1, 2, 3])})
    arrays = table.to_arrays("t")
    asked: list[str] = []

    class Watched(dict[str, np.ndarray]):
        def __getitem__(self, key: str) -> np.ndarray:
            asked.append(key)
            return super().__getitem__(key)

    found = Table.from_arrays(Watched(arrays), "t")
    assert isinstance(found.columns, StoredColumns)
    assert found.names == table.names
    assert list(found.columns["status"]) == ["on", None, "on"]
    assert "t/time_s" not in asked
    assert "t/n" not in asked
    assert len(found) == 3
    assert list(found.rows()) == [(0.0, "on", 1), (1.0, None, 2), (2.0, "on", 3)]
    assert list(found.take(np.array([2])).without("n").rows()) == [(2.0, "on")]
    with pytest.raises(KeyError):
        found.columns["nothing"]


def test_a_table_without_rows_or_columns() -> None:
    assert len(Table({})) == 0
    none = Table({"a": np.empty(0), "b": []})
    assert list(Table.from_arrays(none.to_arrays("t"), "t").rows()) == []
