import numpy as np
import pytest
from scipy.stats import chi2

from backend.charts.catalogue import charts
from backend.charts.chi_square import chi_square_band
from backend.charts.view import ChartOptions
from tests.chart_views import complete_run, marks

DRAW = charts("run")["nis"].draw


def test_the_band_is_the_chi_square_law_s() -> None:
    dof = np.arange(1.0, 40.0)
    low, high = chi_square_band(dof)
    np.testing.assert_allclose(low, chi2.ppf(0.025, dof), rtol=1e-10)
    np.testing.assert_allclose(high, chi2.ppf(0.975, dof), rtol=1e-10)
    np.testing.assert_allclose(chi_square_band(dof, 0.5)[1], chi2.ppf(0.75, dof), rtol=1e-10)


def limits(drawn, traces_of) -> list[list[float]]:
    bands = traces_of(drawn, "bound", "95 % band")
    return [t["y"][np.isfinite(t["y"])][::2].tolist() for t in bands]


def test_one_number_of_degrees_of_freedom_has_one_band_of_nis(traces_of) -> None:
    drawn = DRAW(complete_run(marks()), ChartOptions())
    low, high = limits(drawn, traces_of)
    assert low == pytest.approx([chi2.ppf(0.025, 3)])
    assert high == pytest.approx([chi2.ppf(0.975, 3)])
    assert drawn["layout"]["yaxis"]["title"]["text"] == "NIS (3 dof)"
    (inside,) = traces_of(drawn, "series", "inside")
    assert inside["y"].tolist() == [3] * 6


def test_changing_degrees_of_freedom_divide_nis_and_its_limits(traces_of, note_of) -> None:
    dof = np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])
    drawn = DRAW(complete_run(marks(), dof=dof), ChartOptions())
    low, high = limits(drawn, traces_of)
    each = np.array([1.0, 2.0, 3.0])
    assert low == pytest.approx((chi2.ppf(0.025, each) / each).tolist())
    assert high == pytest.approx((chi2.ppf(0.975, each) / each).tolist())
    (inside,) = traces_of(drawn, "series", "inside")
    np.testing.assert_allclose(inside["y"], 3 / dof)
    assert drawn["layout"]["yaxis"]["title"]["text"] == "NIS per dof"
    assert note_of(drawn, "nis_over_dof")


def test_each_mark_is_judged_by_its_own_band(traces_of, note_of) -> None:
    # 6 is outside for one degree of freedom (5.02) and inside for two (7.38).
    view = complete_run(marks(2), nis=np.array([6.0, 6.0]), dof=np.array([1.0, 2.0]))
    drawn = DRAW(view, ChartOptions())
    assert traces_of(drawn, "series", "outside")[0]["customdata"].tolist() == [1]
    assert traces_of(drawn, "series", "inside")[0]["customdata"].tolist() == [2]
    assert note_of(drawn, "share_inside") == "50.0 % of 2 marks lie inside their own 95 % band."


def test_limits_are_labelled_at_the_exponent_of_their_value() -> None:
    labels = DRAW(complete_run(marks()), ChartOptions())["layout"]["annotations"]
    assert {a["text"] for a in labels} == {"2.5 %, 3 dof", "97.5 %, 3 dof", "expected"}
    by_text = {a["text"]: a["y"] for a in labels}
    assert by_text["97.5 %, 3 dof"] == pytest.approx(np.log10(chi2.ppf(0.975, 3)))


def test_doubted_marks_are_hollow_and_left_out_of_the_mean(traces_of, note_of) -> None:
    status = ["updated", "downweighted", "updated"]
    drawn = DRAW(complete_run(marks(3), status=status, nis=np.array([2.0, 900.0, 4.0])), ChartOptions())
    (hollow,) = traces_of(drawn, "rejected")
    assert hollow["customdata"].tolist() == [2]
    assert hollow["hovertext"][0].startswith("dof 3, downweighted")
    mean = next(t for t in traces_of(drawn, "series") if t["name"] == "a")
    assert np.nanmax(mean["y"]) == 4
    assert note_of(drawn, "mean_without_doubted").startswith("The mean leaves out 1 mark ")


def test_the_mean_in_bins_is_sum_over_sum(traces_of) -> None:
    count = 1200
    nis = np.where(np.arange(count) % 2, 1.0, 4.0)
    dof = np.where(np.arange(count) % 2, 1.0, 3.0)
    drawn = DRAW(complete_run(marks(count), nis=nis, dof=dof), ChartOptions())
    mean = next(t for t in traces_of(drawn, "series") if t["name"] == "a")
    np.testing.assert_allclose(mean["y"], 5 / 4)
    low, high = chi2.ppf([0.025, 0.975], 100) / 100
    assert mean["hovertext"][0] == f"mean of 50 marks, 95 % band {low:.3g} to {high:.3g}"


def test_values_far_below_the_band_are_out_of_the_first_view_and_counted(note_of) -> None:
    drawn = DRAW(complete_run(marks(3), nis=np.array([1e-9, 3.0, 3.0])), ChartOptions())
    assert drawn["layout"]["yaxis"]["range"][0] == pytest.approx(np.log10(chi2.ppf(0.025, 3) / 10))
    assert note_of(drawn, "outside_view").startswith("Outside the first view: 1 of 3 marks")


def test_thinned_marks_keep_their_proportion(traces_of) -> None:
    count = 40000
    nis = np.where(np.arange(count) % 20 == 0, 100.0, 3.0)
    drawn = DRAW(complete_run(marks(count), nis=nis), ChartOptions(points=1000))
    shown = [len(traces_of(drawn, "series", part)[0]["x"]) for part in ("inside", "outside")]
    assert sum(shown) == 2858
    assert drawn["layout"]["meta"]["decimated"] == {"shown": 2858, "of": 40000}


def test_no_innovations() -> None:
    drawn = DRAW(complete_run(marks(), nis=np.full(6, np.nan)), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_nis"
