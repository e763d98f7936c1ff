import numpy as np
import pymap3d
import pytest

from algorithms.recording import TruthTracks
from algorithms.site import Site
from backend.charts.catalogue import charts
from backend.charts.plots import plot_positions
from backend.charts.view import ChartOptions, RecordingView
from tests.chart_views import antenna, doppler, marks, plots

PLAN = charts("recording")["plan"].draw
MEASUREMENTS = charts("recording")["measurements"].draw


def radar(**more: object) -> Site:
    return Site.model_validate({"radars": [{"name": "R", "east_m": 500.0, "north_m": -200.0, "up_m": 50.0} | more]})


def test_a_station_s_area_stands_for_its_receptions(traces_of) -> None:
    recording = marks(16)
    recording.toa_s[4:, 0] = np.nan
    (stations,) = traces_of(PLAN(RecordingView(recording), ChartOptions()), "station")
    sizes = stations["marker"]["size"]
    assert (sizes[0] - 5) / (sizes[1] - 5) == pytest.approx(np.sqrt(4 / 16), rel=1e-6)
    assert stations["hovertext"][0] == "station west<br>4 receptions"


def test_plots_lie_around_their_radar(traces_of) -> None:
    drawn = PLAN(RecordingView(plots(site=radar(range_kind="ground"))), ChartOptions())
    (points,) = traces_of(drawn, "measurement")
    np.testing.assert_allclose(points["x"], 10.5, rtol=1e-6)
    np.testing.assert_allclose(points["y"], -0.2, rtol=1e-5)
    assert points["customdata"].tolist() == [1, 2, 3, 4]
    assert not drawn["layout"]["meta"]["notes"]


def test_slant_ranges_are_projected_by_elevation_else_by_altitude_else_counted(note_of) -> None:
    elevation = np.array([[np.pi / 3], [np.nan], [np.nan], [np.nan]])
    altitude = np.array([[np.nan], [6050.0], [np.nan], [np.nan]])
    recording = plots(site=radar(), elevation_rad=elevation, altitude_m=altitude)
    # Over a flat earth the second would lie at 8500 m; see test_slant for the sphere.
    np.testing.assert_allclose(plot_positions(recording).east_m, [5500, 8503.77, 10500, 10500], atol=0.01)
    assert plot_positions(recording).slant_as_ground == 2
    assert note_of(PLAN(RecordingView(recording), ChartOptions()), "slant_as_ground").endswith("2 slant ranges.")


def test_whole_true_paths_are_drawn_within_the_time_of_the_recording(traces_of) -> None:
    time = np.array([-50.0, 0.0, 1.0, 2.0, 900.0])
    path = np.stack([100.0 * time, np.zeros(5), np.zeros(5)], axis=1)
    tracks = TruthTracks.of(time, np.zeros(5, np.int64), path, np.full((5, 3), np.nan), ("boat",))
    (truth,) = traces_of(PLAN(RecordingView(plots(truth_tracks=tracks)), ChartOptions()), "truth")
    np.testing.assert_allclose(truth["x"], [0, 0.1, 0.2], atol=1e-7)
    assert truth["customdata"].tolist() == [-1, -1, -1]
    assert truth["hovertext"][0] == "target boat"


def test_plots_of_two_radars_in_wgs84_of_one_aircraft_lie_together() -> None:
    """Their norths differ by more than a degree, which is kilometres at that range."""
    aircraft = (50.6, 15.2, 9000.0)
    places = [(50.0, 14.0, 300.0), (50.1, 16.0, 500.0)]
    seen = [pymap3d.geodetic2aer(*aircraft, *place) for place in places]
    names = ["a", "b"]
    radars = [
        {"name": n, "latitude_deg": p[0], "longitude_deg": p[1], "height_m": p[2]}
        for n, p in zip(names, places, strict=True)
    ]
    recording = plots(
        2,
        site=Site.model_validate({"radars": radars}),
        radars=tuple(names),
        radar=np.array([0, 1]),
        range_m=np.array([[one[2]] for one in seen]),
        azimuth_rad=np.radians([[one[0]] for one in seen]),
        altitude_m=np.full((2, 1), 9000.0),
    )
    where = plot_positions(recording)
    assert np.hypot(np.diff(where.east_m), np.diff(where.north_m))[0] < 50
    origin = recording.site.frame_origin()
    truth = pymap3d.geodetic2enu(*aircraft, origin.latitude_deg, origin.longitude_deg, origin.height_m)
    assert np.hypot(where.east_m[0] - truth[0], where.north_m[0] - truth[1]) < 50


def test_cartesian_plots_and_a_moving_radar() -> None:
    recording = plots(
        1,
        east_m=np.array([[100.0]]),
        north_m=np.array([[200.0]]),
        radar_east_m=np.array([1000.0]),
        radar_north_m=np.array([2000.0]),
    )
    where = plot_positions(recording)
    assert (where.east_m[0], where.north_m[0]) == (1100, 2200)
    assert not where.radar_at_origin


def test_two_radars_by_name_and_an_unknown_one(note_of) -> None:
    recording = plots(2, site=radar(), radars=("R", "other"), radar=np.array([0, 1]))
    where = plot_positions(recording)
    np.testing.assert_allclose(where.east_m, [10500, 10000])
    assert where.radar_at_origin
    assert note_of(PLAN(RecordingView(recording), ChartOptions()), "radar_at_origin")


def test_a_plan_without_any_place() -> None:
    assert PLAN(RecordingView(antenna()), ChartOptions())["layout"]["meta"]["not_applicable"] == "no_position"


def test_terminals_of_a_forward_scatter_site(traces_of) -> None:
    site = Site.model_validate(
        {
            "transmitters": [{"name": "T", "east_m": 0.0, "north_m": 0.0}],
            "receivers": [{"name": "R", "east_m": 40000.0, "north_m": 0.0}],
        }
    )
    recording = doppler()
    recording = type(recording)(**{**vars(recording), "site": site})
    (terminals,) = traces_of(PLAN(RecordingView(recording), ChartOptions()), "station")
    assert terminals["text"] == ["T", "R"]
    np.testing.assert_allclose(terminals["x"], [0, 40])


@pytest.mark.parametrize(
    ("recording", "titles"),
    [
        (plots(), ["Range, m", "Azimuth, deg"]),
        (antenna(), ["Range, m", "Bicone elevation, deg", "Bicone azimuth, deg"]),
        (doppler(), ["Doppler, Hz", "Azimuth, deg"]),
        (marks(), ["Delay, µs", "Altitude, m"]),
        (marks(altitude=False), ["Delay, µs"]),
    ],
    ids=["plots", "antenna", "doppler", "marks", "marks without altitude"],
)
def test_one_panel_for_each_quantity_that_was_measured(recording, titles) -> None:
    layout = MEASUREMENTS(RecordingView(recording), ChartOptions())["layout"]
    axes = sorted((a for name, a in layout.items() if name.startswith("yaxis")), key=lambda a: -a["domain"][1])
    assert [a["title"]["text"] for a in axes] == titles


def test_angles_are_in_degrees_and_delays_count_from_the_first_reception(traces_of) -> None:
    drawn = MEASUREMENTS(RecordingView(antenna()), ChartOptions())
    np.testing.assert_allclose(traces_of(drawn, "measurement", "elevation")[0]["y"], 30, rtol=1e-6)
    recording = marks(1)
    recording.toa_s[0, :, 0] = [1e-4, 1.2e-4, np.nan, 1.1e-4]
    drawn = MEASUREMENTS(RecordingView(recording), ChartOptions())
    delays = {t["name"]: t["y"].tolist() for t in traces_of(drawn, "measurement", "station")}
    assert delays["station west"] == [0]
    assert delays["station east"] == pytest.approx([20], rel=1e-5)
    assert "station north" not in delays


def test_channels_share_a_panel(traces_of) -> None:
    drawn = MEASUREMENTS(RecordingView(doppler()), ChartOptions())
    assert [t["yaxis"] for t in traces_of(drawn, "measurement", "channel")] == ["y", "y"]
    assert traces_of(drawn, "measurement", "azimuth")[0]["yaxis"] == "y2"
