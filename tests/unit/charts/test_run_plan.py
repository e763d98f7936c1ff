import numpy as np

from backend.charts.catalogue import charts
from backend.charts.figure import figure_json
from backend.charts.view import ChartOptions
from tests import chart_views
from tests.chart_views import complete_run, marks, run, states

DRAW = charts("run")["plan"].draw


def test_a_track_is_drawn_in_kilometres_with_the_rows_and_times_of_its_marks(traces_of) -> None:
    drawn = DRAW(complete_run(marks()), ChartOptions())
    (track,) = traces_of(drawn, "series")
    np.testing.assert_allclose(track["x"], [0.03, 1.03, 2.03, 3.03, 4.03, 5.03], rtol=1e-6)
    np.testing.assert_allclose(track["y"], 20.04, rtol=1e-6)
    assert track["customdata"].tolist() == [1, 2, 3, 4, 5, 6]
    assert track["text"].tolist() == [0, 1, 2, 3, 4, 5]
    assert track["mode"] == "lines+markers"
    assert track["meta"] == {"role": "series", "label": "a", "index": 0}
    assert track["x"].dtype == np.float32
    assert "t1" in track["hovertext"][0]


def test_axes_are_equal_and_say_their_unit() -> None:
    layout = DRAW(complete_run(marks()), ChartOptions())["layout"]
    assert layout["xaxis"]["title"]["text"] == "East, km"
    assert layout["yaxis"]["title"]["text"] == "North, km"
    assert (layout["yaxis"]["scaleanchor"], layout["yaxis"]["scaleratio"]) == ("x", 1)


def test_a_small_site_is_drawn_in_metres(traces_of) -> None:
    recording = marks(site=None, truth_m=np.zeros((6, 3)))
    drawn = DRAW(complete_run(recording), ChartOptions())
    assert drawn["layout"]["xaxis"]["title"]["text"] == "East, m"
    np.testing.assert_allclose(traces_of(drawn, "series")[0]["x"], 30)


def test_tracks_are_separate_lines(traces_of) -> None:
    recording = marks(4)
    drawn = DRAW(complete_run(recording, track=np.array([1.0, 2.0, 1.0, 2.0])), ChartOptions())
    (track,) = traces_of(drawn, "series")
    assert track["customdata"].tolist() == [1, 3, -1, 2, 4]
    assert np.isnan(track["x"][2])


def test_single_fixes_are_not_joined(traces_of) -> None:
    view = complete_run(marks(), velocity_east_mps=np.full(6, np.nan))
    assert traces_of(DRAW(view, ChartOptions()), "series")[0]["mode"] == "markers"


def test_truth_is_dashed_and_broken_between_targets(traces_of) -> None:
    (truth,) = traces_of(DRAW(complete_run(marks(6, targets=2)), ChartOptions()), "truth")
    assert truth["customdata"].tolist() == [1, 3, 5, -1, 2, 4, 6]
    assert truth["line"]["dash"] == "dash"
    assert not traces_of(DRAW(complete_run(marks(truth=False)), ChartOptions()), "truth")


def test_stations_carry_their_names(traces_of) -> None:
    (stations,) = traces_of(DRAW(complete_run(marks()), ChartOptions()), "station")
    assert stations["text"] == ["west", "east", "north", "middle"]
    np.testing.assert_allclose(stations["x"], [-10, 10, 0, 0])


def test_a_mark_that_was_not_used_is_hollow_with_its_reason(traces_of) -> None:
    recording = marks(3)
    status, used = ["updated", "residual_gate", "updated"], ["west", None, "west"]
    decisions = chart_views.Table({"row": np.array([2]), "decision": ["residual_gate"], "reason": ["too far"]})
    view = run(recording, {"states": states(recording, status=status, used=used), "decisions": decisions})
    (hollow,) = traces_of(DRAW(view, ChartOptions()), "rejected")
    assert hollow["customdata"].tolist() == [2]
    assert hollow["marker"]["symbol"] == "circle-open"
    assert hollow["hovertext"] == ["residual_gate, too far, target t1"]


def test_marks_without_an_estimate_are_counted(note_of) -> None:
    recording = marks(3)
    east = np.array([30.0, np.nan, np.nan])
    view = complete_run(recording, east_m=east, used=["west", None, None])
    assert note_of(DRAW(view, ChartOptions()), "not_drawn").startswith("No estimate, so no place in the plan: 2 marks")


def test_ellipses_have_the_size_of_the_covariance(traces_of) -> None:
    (ellipses,) = traces_of(DRAW(complete_run(marks(1)), ChartOptions()), "interval")
    np.testing.assert_allclose(np.nanmax(ellipses["x"]), (30 + 60 * 2.447747) / 1000, rtol=1e-6)
    np.testing.assert_allclose(np.nanmax(ellipses["y"]), (20040 + 80 * 2.447747) / 1000, rtol=1e-3)
    assert ellipses["fill"] == "toself"


def test_ellipses_are_few_and_their_share_is_said(traces_of, note_of) -> None:
    drawn = DRAW(complete_run(marks(500)), ChartOptions())
    (ellipses,) = traces_of(drawn, "interval")
    assert np.isnan(ellipses["x"]).sum() == 60
    assert note_of(drawn, "ellipses") == "95 % error ellipses at 60 of 500 estimates."


def test_a_wild_estimate_does_not_shrink_the_rest(note_of) -> None:
    recording = marks(100)
    east = states(recording).columns["east_m"].copy()
    east[50] = 2e6
    drawn = DRAW(complete_run(recording, east_m=east), ChartOptions())
    assert drawn["layout"]["xaxis"]["range"][1] < 200
    assert note_of(drawn, "outside_view").startswith("Outside the first view: 1 of ")


def test_stations_and_truth_are_always_in_view() -> None:
    recording = marks(100, truth_m=np.tile([[9e5, 0.0, 0.0]], (100, 1)))
    east_range = DRAW(complete_run(recording, east_m=np.full(100, 9e5)), ChartOptions())["layout"]["xaxis"]["range"]
    assert east_range[0] < -10
    assert east_range[1] > 900


def test_a_million_estimates_are_a_small_figure(traces_of) -> None:
    recording = marks(1_000_000)
    walk = np.cumsum(np.resize([1.0, -2.0, 3.0, -1.5], 1_000_000))
    drawn = DRAW(complete_run(recording, north_m=walk), ChartOptions())
    assert len(figure_json(drawn)) < 400_000
    assert traces_of(drawn, "series")[0]["mode"] == "lines"
    assert drawn["layout"]["meta"]["decimated"]["of"] == 2_000_000


def test_nothing_to_draw() -> None:
    view = run(marks(), {})
    assert DRAW(view, ChartOptions())["layout"]["meta"]["not_applicable"] == "no_states"


def test_pieces_of_a_line_carry_the_names_of_their_targets(traces_of) -> None:
    recording = marks(6, targets=2)
    drawn = DRAW(complete_run(recording, track=np.array([1.0, 2.0] * 3)), ChartOptions())
    (track,), (truth,) = traces_of(drawn, "series"), traces_of(drawn, "truth")
    assert track["meta"]["pieces"] == ["t1", "t2"]
    assert truth["meta"]["pieces"] == ["t1", "t2"]
    assert "opacity" not in track


def test_pieces_without_a_target_carry_the_number_of_their_track(traces_of) -> None:
    view = complete_run(marks(4), track=np.array([7.0, 8.0, 7.0, 8.0]), target=[None] * 4)
    (track,) = traces_of(DRAW(view, ChartOptions()), "series")
    assert track["meta"]["pieces"] == [7, 8]


def test_hundreds_of_tracks_are_thin_and_faint(traces_of) -> None:
    recording = marks(300, targets=100)
    view = complete_run(recording, track=np.arange(300) % 100 + 1.0)
    drawn = DRAW(view, ChartOptions())
    for (line,) in (traces_of(drawn, "series"), traces_of(drawn, "truth")):
        assert len(line["meta"]["pieces"]) == 100
        assert line["opacity"] < 1
        assert line["line"]["width"] <= 1
    # One legend for all: an entry each would cover the chart.
    assert len(traces_of(drawn, "series")) == 1
    figure_json(drawn)
