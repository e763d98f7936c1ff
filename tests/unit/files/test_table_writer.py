from __future__ import annotations

import io

import numpy as np
import pytest

from algorithms.result import Table
from backend.files.formula_guard import guarded, unguarded
from backend.files.table_writer import write_table_csv


def written(table, **options):
    stream = io.StringIO()
    write_table_csv(table, stream, **options)
    return stream.getvalue()


def test_numbers_texts_and_nulls():
    table = Table(
        {
            "time_s": np.array([0.1, 1 / 3]),
            "track": np.array([1, 2]),
            "east_m": np.array([np.nan, np.inf]),
            "reason": ['said "no", left', None],
            "used": np.array([True, False]),
        }
    )
    assert written(table) == (
        'time_s,track,east_m,reason,used\n0.1,1,,"said ""no"", left",true\n0.3333333333333333,2,,,false\n'
    )


def test_a_table_without_rows_has_names():
    assert written(Table({"a": np.empty(0), "b": []})) == "a,b\n"


def test_a_second_table_continues_the_first():
    assert written(Table({"a": np.array([1])}), header=False) == "1\n"


def test_long_tables_are_written_whole():
    text = written(Table({"a": np.arange(50_001)}))
    assert text.splitlines()[1:] == [str(i) for i in range(50_001)]


@pytest.mark.parametrize("text", ["=1+1", "+cmd", "-x", "@SUM(A1)", "'=1", "''-x", "\tx"])
def test_a_formula_stays_a_text(text):
    cell = written(Table({"label": [text]})).splitlines()[1]
    assert cell == f"'{text}"
    assert unguarded(cell) == text


@pytest.mark.parametrize("text", ["-12", "+1.5e3", "=".join("ab"), "it's", "'quoted'"])
def test_other_texts_stay_as_they_are(text):
    assert guarded(text) == text == unguarded(guarded(text))
