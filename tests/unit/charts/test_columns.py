import numpy as np

from algorithms.result import Table
from backend.charts.columns import codes, numbers, row_numbers, used_marks, words
from backend.charts.view import rows_of_label

TABLE = Table(
    {
        "label": ["a", "b", "a"],
        "track": np.array([2.0, np.nan, 1.0]),
        "target": ["x", None, "y"],
        "row": np.array([7.0, np.nan, 9.0]),
        "count": [1, None, 3],
    }
)


def test_numbers_of_arrays_lists_and_missing_columns() -> None:
    np.testing.assert_array_equal(numbers(TABLE, "track"), [2, np.nan, 1])
    np.testing.assert_array_equal(numbers(TABLE, "count"), [1, np.nan, 3])
    np.testing.assert_array_equal(numbers(TABLE, "nothing"), [np.nan] * 3)
    assert numbers(Table({}), "nothing").size == 0


def test_words_of_missing_values_and_columns_are_empty() -> None:
    assert words(TABLE, "target").tolist() == ["x", "", "y"]
    assert words(TABLE, "nothing").tolist() == ["", "", ""]


def test_codes_follow_the_values_and_combine_columns() -> None:
    assert codes(TABLE, "target").tolist() == [1, 0, 2]
    assert codes(TABLE, "track", "target").tolist() == [1, 2, 0]
    assert codes(TABLE, "nothing").tolist() == [0, 0, 0]


def test_unknown_rows_are_minus_one() -> None:
    assert row_numbers(TABLE).tolist() == [7, -1, 9]


def test_used_marks_by_what_was_used_by_number_or_unknown() -> None:
    assert used_marks(Table({"used": ["s1 s2", None, ""]})).tolist() == [True, False, False]
    assert used_marks(Table({"used": np.array([2, 0])})).tolist() == [True, False]
    assert used_marks(TABLE).tolist() == [True, True, True]


def test_rows_of_one_label() -> None:
    cut = rows_of_label(TABLE, "a")
    assert cut.names == ("track", "target", "row", "count")
    assert list(cut.rows()) == [(2.0, "x", 7.0, 1), (1.0, "y", 9.0, 3)]
    assert len(rows_of_label(TABLE, "c")) == 0
