import numpy as np
import pytest

from algorithms.result import Table
from backend.charts.columns import by_key_and_time, codes, numbers, row_numbers, used_marks, words
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


@pytest.mark.parametrize(
    "values",
    [
        [3.0, 1.0, np.nan, 1.0, 7.0],
        [np.nan, np.nan],
        [5.0, 5.0, 5.0],
        [0.25, -1.0, 0.25, np.nan],
        [1e300, 0.0, np.inf, -np.inf, np.nan],
        [2e9, 0.0, 1.0],
        [],
    ],
)
def test_codes_are_places_among_the_distinct_values(values: list[float]) -> None:
    column = np.array(values)
    expected = np.unique(column, return_inverse=True)[1]
    np.testing.assert_array_equal(codes(Table({"track": column}), "track"), expected)


def test_combined_codes_are_ordered_by_the_first_column() -> None:
    random = np.random.default_rng(1)
    trial = random.choice([0.0, 3.0, np.nan], 200)
    track = random.integers(0, 5, 200)
    target = random.choice(["b", "a", ""], 200).tolist()
    found = codes(Table({"trial": trial, "track": track, "target": target}), "trial", "track", "target")
    rows = list(zip(np.nan_to_num(trial, nan=9.0).tolist(), track.tolist(), target, strict=True))
    places = {row: place for place, row in enumerate(sorted(set(rows)))}
    assert found.tolist() == [places[row] for row in rows]


@pytest.mark.parametrize("case", ["rising", "not rising", "with gaps", "many keys", "a negative key", "nothing"])
def test_the_quick_order_is_that_of_lexsort(case: str) -> None:
    random = np.random.default_rng(2)
    key, time = random.integers(0, 9, 500), np.sort(random.integers(0, 100, 500)).astype(float)
    if case == "not rising":
        time = random.permutation(time)
    elif case == "with gaps":
        time[::7] = np.nan
    elif case == "many keys":
        key = key * 100_000
    elif case == "a negative key":
        key = key - 1
    elif case == "nothing":
        key, time = key[:0], time[:0]
    np.testing.assert_array_equal(by_key_and_time(key, time), np.lexsort((time, key)))


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
