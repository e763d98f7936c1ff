import numpy as np

from backend.charts.catalogue import charts
from backend.charts.figure import not_applicable
from backend.charts.html import chart_page
from backend.charts.table import chart_table
from backend.charts.view import ChartOptions, RecordingView
from tests.chart_views import complete_run, marks

FULL = ChartOptions(full=True)


def rows(table) -> list[dict[str, object]]:
    return [dict(zip(table.names, row, strict=True)) for row in table.rows()]


def test_every_point_of_the_figure_is_a_row_in_double_precision() -> None:
    recording = marks(4, targets=2)
    east = np.array([0.1, 1 / 3, 2 / 3, 0.7]) * 1e5
    table = chart_table(charts("run")["plan"].draw(complete_run(recording, east_m=east), FULL))
    track = [r for r in rows(table) if r["role"] == "series"]
    assert [r["x"] for r in track] == (east[[0, 2, 1, 3]] * 1e-3).tolist()
    assert [r["row"] for r in track] == [1, 3, 2, 4]
    assert [r["time_s"] for r in track] == [0, 2, 1, 3]
    assert {r["label"] for r in track} == {"a"}
    assert {(r["x_axis"], r["y_axis"]) for r in track} == {("East, km", "North, km")}


def test_breaks_are_no_rows_and_traces_without_marks_have_no_row_number() -> None:
    table = chart_table(charts("run")["plan"].draw(complete_run(marks(4, targets=2)), FULL))
    assert np.isfinite(table.columns["x"]).all()
    assert {r["row"] for r in rows(table) if r["role"] == "station"} == {None}


def test_cells_of_a_map_are_rows_with_the_station_s_name() -> None:
    table = chart_table(charts("recording")["receptions"].draw(RecordingView(marks(1200)), FULL))
    cells = [r for r in rows(table) if r["trace"] == "receptions by station"]
    assert len(cells) == 4 * 24
    assert cells[48]["y_text"] == "north"
    assert (cells[48]["x"], cells[48]["z"]) == (25, 98)
    shares = [r for r in rows(table) if r["trace"] == "3 receptions"]
    assert shares[0]["y_axis"] == "Marks, %"
    assert shares[0]["y"] == 2


def test_an_empty_chart_is_an_empty_table_with_the_same_columns() -> None:
    empty = chart_table(not_applicable("T", "no_marks"))
    assert len(empty) == 0
    assert empty.names == chart_table(charts("run")["plan"].draw(complete_run(marks()), FULL)).names


def test_a_page_cannot_be_ended_by_a_label() -> None:
    drawn = charts("run")["plan"].draw(complete_run(marks(targets=1, start_utc=None)), ChartOptions())
    drawn["data"][0]["name"] = "</script><script>alert(1)</script>"
    page = chart_page(drawn, "run").decode()
    assert "alert(1)" in page
    assert "</script><script>alert" not in page
