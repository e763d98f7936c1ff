import base64
import json
from typing import Any

import numpy as np
import pytest

from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, counted, figure, figure_json, log_axis, not_applicable, trace
from backend.charts.theme import SERIES, faint, series_color, series_dash, series_symbol
from backend.charts.view import ChartOptions
from tests import chart_views


def sent(value: Any) -> Any:
    return json.loads(figure_json({"data": [{"x": value}], "layout": {}}))["data"][0]["x"]


def decoded(spec: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(spec["bdata"]), np.dtype("<" + spec["dtype"]))


def test_numbers_travel_as_typed_arrays_with_their_gaps() -> None:
    spec = sent(np.array([1.5, np.nan]))
    assert spec["dtype"] == "f8"
    np.testing.assert_array_equal(decoded(spec), [1.5, np.nan])
    assert sent(np.array([1.5], np.float32))["dtype"] == "f4"
    np.testing.assert_array_equal(decoded(sent(np.array([1, 2]).astype(">f8"))), [1, 2])


def test_integers_travel_in_four_bytes_where_they_fit() -> None:
    spec = sent(np.array([1, -1]))
    assert spec["dtype"] == "i4"
    np.testing.assert_array_equal(decoded(spec), [1, -1])
    assert sent(np.array([2**40]))["dtype"] == "f8"


def test_a_matrix_says_its_shape() -> None:
    assert sent(np.zeros((2, 3)))["shape"] == "2, 3"


def test_a_stray_nan_or_an_unknown_object_is_refused() -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        figure_json({"x": float("nan")})
    with pytest.raises(TypeError, match="no place in a figure"):
        figure_json({"x": object()})


def test_only_full_options_keep_double_precision() -> None:
    assert ChartOptions().number(np.array([1.0])).dtype == np.float32
    assert ChartOptions(full=True).number(np.array([1.0])).dtype == np.float64
    assert ChartOptions(full=True).marks is ChartOptions(full=True).curve_points is None


def test_decimation_is_said_in_the_figure_and_in_its_meta() -> None:
    drawn = figure("T", [], recording=chart_views.marks(), picked=[Picked(np.arange(2), 2, 1500)])
    assert drawn["layout"]["meta"]["decimated"] == {"shown": 2, "of": 1500}
    assert drawn["layout"]["title"]["subtitle"]["text"] == "2 of 1\u2009500 points drawn"
    whole = figure("T", [], recording=chart_views.marks(), picked=[Picked(np.arange(2), 2, 2)])
    assert "decimated" not in whole["layout"]["meta"]
    assert "subtitle" not in whole["layout"]["title"]


def test_a_crowd_goes_to_webgl_and_summaries_stay_above_it() -> None:
    many, few = np.zeros(6000), np.zeros(10)
    crowd = trace("series", many, many, mode="markers", name="a")
    line = trace("series", many, many, mode="lines", name="b")
    summary = trace("series", few, few, mode="lines+markers", name="c")
    figure("T", [crowd, line, summary], recording=chart_views.marks())
    assert [t["type"] for t in (crowd, line, summary)] == ["scattergl", "scatter", "scatter"]


def test_notes_and_the_start_reach_the_page() -> None:
    recording = chart_views.marks(start_utc="2023-04-05T10:00:00Z")
    about = figure("T", [], recording=recording, notes=[ChartNote("c", "Text.", "a")])["layout"]["meta"]
    assert about == {"notes": [{"code": "c", "text": "Text.", "label": "a"}], "start_utc": "2023-04-05T10:00:00Z"}


def test_a_chart_that_does_not_apply_says_why() -> None:
    drawn = not_applicable("T", "no_marks")
    assert drawn["data"] == []
    assert drawn["layout"]["meta"]["not_applicable"] == "no_marks"
    assert drawn["layout"]["annotations"][0]["text"] == drawn["layout"]["meta"]["detail"]


def test_counts_with_their_nouns() -> None:
    assert counted(1, "mark") == "1 mark"
    assert counted(1200, "mark") == "1\u2009200 marks"


def test_a_log_axis_names_digits_only_within_few_decades() -> None:
    """Less than one decade may hold no power of ten, and then a digit says nothing: Plotly names whole numbers."""

    def axis(values: list[float]) -> Any:
        return log_axis("E, m", [trace("series", np.zeros(2), np.array(values), name="a")]).get("dtick")

    assert axis([320.0, 950.0]) is None

    assert axis([1.0, 500.0]) == "D2"
    assert axis([1.0, 1e6]) == 1
    assert axis([np.nan, 0.0]) == "D2"


def test_twelve_entries_differ_by_more_than_colour() -> None:
    looks = [(series_color(i), series_dash(i), series_symbol(i)) for i in range(12)]
    assert len(set(looks)) == 12
    assert [series_color(i) for i in range(6)] == list(SERIES)
    assert len({series_dash(i) for i in range(6)}) == 6
    assert faint("#0072B2", 0.18) == "rgba(0,114,178,0.18)"
