"""Worked examples 9.1-9.4 of the multilateration specification, to the digits given."""

import numpy as np
import pytest

from algorithms.multilateration import lanes
from algorithms.multilateration.conditions import conditions_of
from algorithms.multilateration.filter_kernel import filter_marks
from algorithms.multilateration.fix import solve_mark
from algorithms.multilateration.parameters import FilterWithAltitudeParameters
from algorithms.multilateration.scenario import four_stations
from algorithms.multilateration.tracker import setup_of
from algorithms.recording import ToaMarks
from algorithms.toolbox.bounds.accuracy_map import Altitude, places_at, plan_bound
from algorithms.toolbox.frames import earth as earths
from algorithms.toolbox.kernels.symmetric import pack, unpack
from algorithms.toolbox.motion.jerk import predict_jerk

C = 299_792_458.0
SPHERE = earths.sphere()
STATIONS = four_stations().station_positions()
POINT = np.array([30_000.0, -12_000.0, float(earths.z_from_altitude(30_000.0, -12_000.0, 9_000.0, SPHERE))])


def drms(stations: np.ndarray, kind: Altitude = "none", sigma_altitude_m: float = 1.0) -> float:
    """Bound of one mark at the point of 9.1 with 10 ns."""
    places = places_at(POINT[:1], POINT[1:2], 9_000.0, SPHERE)
    return float(plan_bound(places, stations, np.full(len(stations), C * 10e-9), kind, sigma_altitude_m).drms_m[0])


def test_altitude_and_geometry_9_1() -> None:
    assert earths.z_from_altitude(30_000.0, -12_000.0, 9_000.0, SPHERE) == pytest.approx(8918.181294, abs=1e-6)
    assert earths.up_from_position(POINT, SPHERE) == pytest.approx([0.00470219, -0.00188088, 0.99998718], abs=5e-9)
    assert np.linalg.norm(POINT - STATIONS, axis=1) == pytest.approx(
        [33632.0194763, 26747.3464149, 42699.7264294, 33515.1702539], abs=1e-6
    )


def test_one_mark_bounds_9_1() -> None:
    assert drms(STATIONS) == pytest.approx(127.24541, abs=5e-6)
    assert drms(STATIONS, "measured", 100.0) == pytest.approx(105.35504, abs=5e-6)
    assert drms(STATIONS, "known") == pytest.approx(57.02693, abs=5e-6)
    assert drms(STATIONS[[0, 2, 3]], "known") == pytest.approx(1597.5903, abs=5e-5)
    assert np.isnan(drms(STATIONS[:3])), "three receptions in space: unobservable"
    _, covariance = solved(np.linalg.norm(POINT - STATIONS, axis=1), [0, 1, 2, 3], np.nan)
    assert np.sqrt(covariance[0, 0] + covariance[0, 2]) == pytest.approx(127.24541, abs=5e-5)
    assert np.sqrt(covariance[0, 5]) == pytest.approx(79.97658, abs=5e-5), "vertical, as the solution itself says"


NOISE_NS = np.array([5.0, -8.0, 0.0, 10.0])
PRIOR = np.kron(np.eye(3), np.diag([400.0**2, 30.0**2, 1.0]))
STATE = np.array([30_000.0, -180, 0, -12_000, 60, 0, 8_900, 0, 0])


def one_update(receptions: list[int], altitude_m: float | None) -> lanes.Report:
    """Run the production kernel for the one mark of 9.2 and give its report."""
    toa_s = np.full((1, 4, 1), np.nan)
    everything = np.linalg.norm(POINT - STATIONS, axis=1) / C + NOISE_NS * 1e-9
    toa_s[0, receptions, 0] = everything[receptions] - everything.min()
    site = four_stations(sigma_toa_ns=10.0, sigma_altitude_m=50.0)
    recording = ToaMarks(
        time_s=np.zeros(1),
        row=np.ones(1, np.int64),
        target=np.zeros(1, np.int64),
        site=site,
        toa_s=toa_s,
        altitude_m=np.full((1, 1), np.nan if altitude_m is None else altitude_m),
        stations=("1", "2", "3", "4"),
    )
    conditions = conditions_of(
        recording, FilterWithAltitudeParameters(profile="article"), profile="article", with_altitude=True
    )
    setup = setup_of(
        conditions, sigma_jerk_mps3=0.1, process_noise="paper", altitude=altitude_m is not None, robust=False
    )
    track = lanes.new_track()
    track.x[0, :, 0] = STATE
    track.p[0, :, 0] = pack(PRIOR)
    track.live[0] = track.number[0] = 1
    report = lanes.new_report(1, 4, 1)
    marks = lanes.decoded_marks(recording.time_s[:, None], recording.toa_s, recording.altitude_m)
    filter_marks(marks, setup, track, lanes.new_now(4), lanes.new_rows(4), report, 0, 1)
    return report


@pytest.mark.parametrize(
    ("receptions", "altitude", "position", "nis", "claimed"),
    [
        ([0, 2, 3], 9012.0, (30035.879747, -12019.966801, 8940.868447), 0.229187981, 390.697634),
        ([0, 2, 3], None, (30006.136327, -11998.445905, 8974.382283), 0.036483255, 399.548326),
        ([0, 1, 2, 3], None, (30091.538962, -12049.986966, 8962.631975), 0.104947721, 119.610487),
    ],
)
def test_one_update_9_2(
    receptions: list[int], altitude: float | None, position: tuple[float, ...], nis: float, claimed: float
) -> None:
    report = one_update(receptions, altitude)
    state, cov = report.state[0, :, 0], unpack(report.covariance[0, :, 0])
    assert state[[0, 3, 6]] == pytest.approx(position, abs=1e-6)
    assert state[[1, 4, 7]] == pytest.approx([-180, 60, 0], abs=1e-12), "velocities unchanged"
    assert report.nis[0, 0] == pytest.approx(nis, abs=1e-9)
    assert np.sqrt(cov[0, 0] + cov[3, 3]) == pytest.approx(claimed, abs=1e-6)
    if altitude is not None:
        assert np.sqrt(np.diag(cov)[[0, 3, 6]]) == pytest.approx([336.991355, 197.690333, 43.686379], abs=1e-6)


def test_prediction_9_2() -> None:
    x, p = np.repeat(STATE[:, None], 16, axis=1), np.repeat(pack(PRIOR)[:, None], 16, axis=1)
    predict_jerk(x, p, np.full(16, 2.0), 0.1, 2)
    assert np.sqrt(np.diag(unpack(p[:, 0])))[:3] == pytest.approx([404.479933, 30.067036, 1.009950], abs=1e-6)
    nothing, noise = np.zeros((9, 16)), np.zeros((45, 16))
    predict_jerk(nothing, noise, np.full(16, 2.0), 0.1, 2)
    assert unpack(noise[:, 0])[:3, :3] == pytest.approx(
        np.array([[0.016, 0.02, 0.0133333], [0.02, 0.0266667, 0.02], [0.0133333, 0.02, 0.02]]), abs=5e-8
    )


def solve(toa_m: np.ndarray, receptions: list[int], altitude: float) -> np.ndarray:
    position, _ = solved(toa_m, receptions, altitude)
    return position[np.argsort(-position[:, 0])]


def solved(toa_m: np.ndarray, receptions: list[int], altitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and packed covariances of one mark, from the production kernel."""
    used = np.zeros(4)
    used[receptions] = 1
    position, covariance, cost = np.zeros((2, 3)), np.zeros((2, 6)), np.zeros(2)
    n = solve_mark(
        toa_m, used, STATIONS, np.full(4, (C * 10e-9) ** 2), altitude, 100.0**2,
        SPHERE, np.array([0.0, 0.0, -SPHERE[1]]), SPHERE[1], position, covariance, cost,
    )  # fmt: skip
    return position[:n], covariance[:n]


def test_closed_forms_9_3() -> None:
    toa_m = np.linalg.norm(POINT - STATIONS, axis=1)
    four = solve(toa_m, [0, 1, 2, 3], np.nan)
    assert four.shape == (1, 3)
    assert four[0] == pytest.approx(POINT, abs=1e-5)
    assert np.linalg.norm(four[0] - STATIONS[3]) == pytest.approx(33515.17025, abs=1e-5)

    two = solve(toa_m, [0, 2, 3], 9000.0)
    assert two == pytest.approx(np.array([[30000, -12000, 8918.18], [23113.814, -7923.097, 8953.211]]), abs=2e-3)

    z = float(earths.z_from_altitude(5000.0, 22000.0, 6000.0, SPHERE))
    behind = np.linalg.norm(np.array([5000.0, 22000.0, z]) - STATIONS, axis=1)
    roots = solve(behind, [1, 2, 3], 6000.0)
    assert roots == pytest.approx(np.array([[5000, 22000, 5960.09], [-1436.249, 3425.489, 5998.918]]), abs=5e-3)


@pytest.mark.parametrize(("ratio", "probability"), [(1.0, 0.6321), (0.5, 0.6630), (0.2, 0.6823), (0.0, 0.6827)])
def test_probability_in_the_drms_circle_9_4(ratio: float, probability: float) -> None:
    """Errors with standard deviations 1 and `ratio` lie within DRMS = sqrt(1 + ratio^2) by quadrature."""
    from scipy.integrate import quad
    from scipy.stats import norm

    radius2 = 1 + ratio**2

    def inside(x: float) -> float:
        rest = np.sqrt(max(radius2 - x * x, 0.0))
        return float(norm.pdf(x) * (1.0 if ratio == 0 else 2 * norm.cdf(rest / ratio) - 1))

    edge = float(np.sqrt(radius2))
    assert quad(inside, -edge, edge, epsabs=1e-10)[0] == pytest.approx(probability, abs=5e-5)
