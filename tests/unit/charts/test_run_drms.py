import numpy as np

from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions
from tests.chart_views import complete_run, errors, marks, run, states

DRAW = charts("run")["drms"].draw


def test_claimed_is_a_line_and_actual_are_points(traces_of) -> None:
    drawn = DRAW(complete_run(marks()), ChartOptions())
    (claimed,) = traces_of(drawn, "series", "claimed")
    (actual,) = traces_of(drawn, "series", "actual")
    assert claimed["mode"] == "lines"
    assert actual["mode"] == "markers"
    np.testing.assert_allclose(claimed["y"], 100)
    np.testing.assert_allclose(actual["y"], 50)
    assert actual["customdata"].tolist() == [1, 2, 3, 4, 5, 6]
    assert claimed["x"].dtype == np.float64


def test_the_axis_is_logarithmic_in_metres() -> None:
    layout = DRAW(complete_run(marks()), ChartOptions())["layout"]
    assert layout["yaxis"]["type"] == "log"
    assert layout["yaxis"]["title"]["text"] == "Horizontal error, m"
    assert layout["xaxis"]["title"]["text"] == "Time, s"


def test_the_start_of_the_recording_stands_at_the_time_axis() -> None:
    recording = marks(start_utc="2023-04-05T10:00:00Z")
    assert DRAW(complete_run(recording), ChartOptions())["layout"]["xaxis"]["title"]["text"] == (
        "Time from 2023-04-05 10:00:00Z, s"
    )


def test_how_often_the_claim_held(note_of) -> None:
    view = complete_run(marks(4), drms_m=np.array([100.0, 40.0, 100.0, 100.0]))
    assert note_of(DRAW(view, ChartOptions()), "claim_held").startswith(
        "The actual error is below the claimed one at 75 % of 4 marks"
    )


def test_errors_are_joined_by_row_whatever_their_order(traces_of) -> None:
    recording = marks(4)
    table = errors(recording)
    turned = {name: column[::-1] for name, column in table.columns.items()}
    turned["error_horizontal_m"] = np.array([4.0, 3.0, 2.0, 1.0])
    view = run(recording, {"states": states(recording), "errors": type(table)(turned)})
    (actual,) = traces_of(DRAW(view, ChartOptions()), "series", "actual")
    assert actual["y"].tolist() == [1, 2, 3, 4]


def test_without_truth_only_the_claim(traces_of, note_of) -> None:
    drawn = DRAW(complete_run(marks(truth=False)), ChartOptions())
    assert len(traces_of(drawn, "series")) == 1
    assert note_of(drawn, "no_truth")


def test_single_fixes_have_a_dash_each(traces_of) -> None:
    drawn = DRAW(complete_run(marks(), velocity_east_mps=np.full(6, np.nan)), ChartOptions())
    (claimed,) = traces_of(drawn, "series", "claimed")
    assert (claimed["mode"], claimed["marker"]["symbol"]) == ("markers", "line-ew-open")


def test_many_tracks_are_summed_up_in_bins(traces_of, note_of) -> None:
    recording = marks(3000, targets=30)
    drms = np.where(recording.time_s < 50, 300.0, 400.0)
    drawn = DRAW(complete_run(recording, drms_m=drms), ChartOptions())
    (claimed,) = traces_of(drawn, "series", "claimed (rms)")
    np.testing.assert_allclose(claimed["y"], [300] + [400] * 59)
    np.testing.assert_allclose(traces_of(drawn, "series", "actual (rms)")[0]["y"], 50)
    assert note_of(drawn, "rms_in_bins")


def test_an_error_of_zero_is_counted(note_of) -> None:
    recording = marks(3)
    table = errors(recording)
    zero = type(table)(dict(table.columns) | {"error_horizontal_m": np.array([0.0, 1.0, 2.0])})
    drawn = DRAW(run(recording, {"states": states(recording), "errors": zero}), ChartOptions())
    assert note_of(drawn, "zero_on_log_axis") == "No place on a logarithmic axis: 1 error of exactly 0 m."


def test_a_missing_claim_breaks_the_line(traces_of) -> None:
    drms = np.array([1.0, 2.0, np.nan, 4.0])
    (claimed,) = traces_of(DRAW(complete_run(marks(4), drms_m=drms), ChartOptions()), "series", "claimed")
    np.testing.assert_array_equal(claimed["y"], [1, 2, np.nan, 4])


def test_no_claim_at_all() -> None:
    drawn = DRAW(complete_run(marks(), drms_m=np.full(6, np.nan)), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_covariance"
