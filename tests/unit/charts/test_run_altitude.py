import numpy as np
import pymap3d
from scipy.stats import norm

from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions
from tests.chart_views import complete_run, marks, site

DRAW = charts("run")["altitude"].draw
ORIGIN = {"latitude_deg": 55.0, "longitude_deg": 83.0, "height_m": 120.0}


def test_heights_become_geodetic_heights(traces_of, note_of) -> None:
    recording = marks(3, site=site(origin=ORIGIN), truth_m=np.tile([[1e5, 0.0, 3000.0]], (3, 1)))
    drawn = DRAW(complete_run(recording), ChartOptions(full=True))
    want = pymap3d.enu2geodetic(1e5, 0.0, 3000.0, 55.0, 83.0, 120.0)[2]
    assert 3890 < want < 3910
    np.testing.assert_allclose(traces_of(drawn, "truth")[0]["y"], want, atol=1e-3)
    estimate = pymap3d.enu2geodetic(1e5 + 30, 40.0, 3005.0, 55.0, 83.0, 120.0)[2]
    np.testing.assert_allclose(traces_of(drawn, "series")[0]["y"], estimate, atol=1e-3)
    assert note_of(drawn, "altitude_of_ellipsoid")


def test_without_an_origin_the_earth_is_the_article_s_sphere(traces_of, note_of) -> None:
    recording = marks(1, truth_m=np.array([[1e5, 0.0, 3000.0]]))
    drawn = DRAW(complete_run(recording), ChartOptions(full=True))
    want = np.hypot(6_371_000 + 3000.0, 1e5) - 6_371_000
    np.testing.assert_allclose(traces_of(drawn, "truth")[0]["y"], want, atol=1e-6)
    assert note_of(drawn, "altitude_of_sphere")


def test_decoded_altitudes_are_grey_points_as_reported(traces_of) -> None:
    (decoded,) = traces_of(DRAW(complete_run(marks()), ChartOptions()), "measurement")
    assert decoded["mode"] == "markers"
    assert decoded["y"].tolist() == [3030] * 6
    assert decoded["customdata"].tolist() == [1, 2, 3, 4, 5, 6]


def test_the_band_holds_ninety_five_per_cent(traces_of) -> None:
    drawn = DRAW(complete_run(marks()), ChartOptions(full=True))
    (band,) = traces_of(drawn, "interval")
    (estimate,) = traces_of(drawn, "series")
    reach = norm.ppf(0.975) * 100
    np.testing.assert_allclose(band["y"][:6], estimate["y"] - reach, atol=1e-3)
    np.testing.assert_allclose(band["y"][6:12], estimate["y"][::-1] + reach, atol=1e-3)
    assert band["fill"] == "toself"


def test_bands_of_two_tracks_are_two_outlines(traces_of) -> None:
    (band,) = traces_of(DRAW(complete_run(marks(6, targets=2)), ChartOptions()), "interval")
    assert np.isnan(band["y"]).sum() == 2
    first, second = np.split(band["x"], [7])
    assert first[:6].tolist() == [0, 2, 4, 4, 2, 0]
    assert second[1:7].tolist() == [1, 3, 5, 5, 3, 1]


def test_single_fixes_have_bars(traces_of) -> None:
    drawn = DRAW(complete_run(marks(2), velocity_east_mps=np.full(2, np.nan)), ChartOptions())
    (bars,) = traces_of(drawn, "interval")
    np.testing.assert_array_equal(bars["x"], [0, 0, np.nan, 1, 1, np.nan])


def test_wild_heights_are_outside_the_first_view(note_of) -> None:
    drawn = DRAW(complete_run(marks(3), up_m=np.array([3000.0, 90000.0, 3000.0])), ChartOptions())
    assert drawn["layout"]["yaxis"]["range"][1] < 5000
    assert note_of(drawn, "outside_view").startswith("Outside the first view: 1 of 3 estimates")


def test_altitudes_that_were_not_decoded_say_where_they_come_from(traces_of, note_of) -> None:
    source = ["decoded", "held", "held", "type", "class", "none"]
    more = {
        "altitude_source": source,
        "altitude_given_m": np.array([3030.0, 3030.0, 3030.0, 20.0, 6000.0, np.nan]),
        "altitude_sigma_m": np.array([50.0, 60.0, 70.0, 15.0, 3500.0, np.nan]),
    }
    drawn = DRAW(complete_run(marks(6), **more), ChartOptions())
    named = {t["name"].split(", ")[-1]: t for t in traces_of(drawn, "measurement")}
    assert named["altitude held"]["y"].tolist() == [3030, 3030]
    assert named["altitude held"]["customdata"].tolist() == [2, 3]
    assert named["altitude of the type"]["y"].tolist() == [20]
    assert named["assumed altitude"]["y"].tolist() == [6000]
    assert note_of(drawn, "altitude_held").endswith("altitude held, standard deviation up to 70 m.")
