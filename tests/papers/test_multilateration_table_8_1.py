"""The deterministic table of specification 8.1 (the paper's figure 3), to the printed digits."""

import numpy as np
import pytest

from algorithms.multilateration.bound import horizontal_bound
from algorithms.multilateration.parameters import FilterWithAltitudeParameters, Start
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.toolbox.bounds.accuracy_map import Altitude, places_at, plan_bound
from algorithms.toolbox.frames import earth as earths

INSTANTS = (0, 50, 200, 300, 400, 520, 620, 720, 1100, 1500, 1899)
TABLE = {
    None: (471.94, 554.33, 317.05, 204.24, 112.37, 36.77, 8.41, 47.78, 154.18, 660.70, 1410.31),
    1000.0: (469.85, 465.41, 291.60, 196.57, 110.89, 36.70, 8.41, 47.75, 154.17, 623.89, 1078.98),
    300.0: (461.44, 345.14, 215.13, 157.76, 99.64, 35.96, 8.40, 47.53, 154.14, 548.34, 1016.40),
    100.0: (455.70, 313.34, 173.22, 115.64, 72.13, 31.50, 8.28, 45.77, 153.94, 523.08, 1009.65),
    30.0: (454.62, 308.91, 165.51, 104.03, 56.73, 21.74, 7.41, 36.33, 153.45, 519.43, 1008.87),
    10.0: (454.52, 308.51, 164.78, 102.80, 54.58, 18.25, 5.82, 27.46, 153.27, 519.10, 1008.80),
}
ONE_MARK = (2231, 1894, 1046, 620, 305, 82.3, 15.6, 122.6, 481, 2693, 6663)
ONE_MARK_KNOWN = (1078, 904, 477, 272, 128, 33.8, 8.0, 57.4, 480, 1994, 4388)
LEGS = {
    "inbound": (50, 400),
    "weave": (400, 520),
    "turn": (560, 680),
    "orbit": (720, 960),
    "out_near": (960, 1200),
    "out_far": (1200, 1900),
}
GAINS = {
    10.0: (1.94, 2.07, 1.63, 1.82, 1.04, 1.29),
    100.0: (1.81, 1.36, 1.02, 1.06, 1.02, 1.29),
    300.0: (1.43, 1.06, 1.00, 1.01, 1.00, 1.24),
}


@pytest.fixture(scope="module")
def circuit():
    return simulate(CircuitParameters(), (0,), 0)


@pytest.fixture(scope="module")
def claimed(circuit):
    """DRMS along the track by altitude error; None = without altitude."""
    out = {}
    for sigma in TABLE:
        parameters = FilterWithAltitudeParameters(
            profile="article", sigma_altitude_m=sigma, start=Start(mode="truth", sd=(500, 50, 1))
        )
        out[sigma] = horizontal_bound(circuit, parameters, altitude=sigma is not None)
    return out


@pytest.mark.parametrize("sigma", list(TABLE))
def test_drms_along_the_track(claimed, sigma) -> None:
    assert claimed[sigma][list(INSTANTS)] == pytest.approx(TABLE[sigma], abs=0.0051)


@pytest.mark.parametrize("sigma", list(GAINS))
def test_median_gain_by_leg(claimed, sigma) -> None:
    gain = claimed[None] / claimed[sigma]
    medians = [float(np.median(gain[a:b])) for a, b in LEGS.values()]
    assert medians == pytest.approx(GAINS[sigma], abs=0.0101)


def test_one_mark_columns(circuit) -> None:
    sphere, sigma = earths.sphere(), np.full(4, 2.99792458)
    stations = circuit.site.station_positions()
    kinds: tuple[tuple[Altitude, tuple[float, ...]], ...] = (("none", ONE_MARK), ("known", ONE_MARK_KNOWN))
    at = circuit.truth_m[list(INSTANTS)]
    places = places_at(at[:, 0], at[:, 1], 10_000.0, sphere)
    np.testing.assert_allclose(places.position_m[2], at[:, 2], atol=1e-6)
    for kind, printed in kinds:
        for found, expected in zip(plan_bound(places, stations, sigma, kind).drms_m, printed, strict=True):
            digits = 0.51 if expected >= 100 and expected == int(expected) else 0.051
            assert found == pytest.approx(expected, abs=digits)
