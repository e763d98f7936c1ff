"""Angles, several transmitters, false values, calibration and scaling (forward-scatter specification 8.5 to 8.8).

Bands as in test_forward_scatter.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.registry import algorithms_by_name
from algorithms.spec import LocalContext
from tests.monte_carlo.scatter import (
    ANGLE,
    BOUND_3,
    BOUND_4,
    FAR,
    LINES,
    MEAN,
    MEDIAN,
    ML,
    RMS,
    S15,
    S30,
    SD,
    Found,
)

pytestmark = pytest.mark.slow

# 8.5: rms error at 9, 16, 30 s of slope, (20), regression, and the bound. (20) at 16 s is printed for its use inside
# the zone in which section 7 forbids it; what holding gives there was found by a simulation of its own.
TABLE_8_5 = {
    (15_000.0, 0.1): ((325, 277, 459), (217, 239, 160), 200, (92, 82, 74), (87, 74, 51)),
    (15_000.0, 0.5): ((1392, 1374, 1500), (431, 1101, 401), 733, (371, 359, 257), (370, 355, 250)),
    (15_000.0, 1.0): ((2831, 2809, 3009), (787, 2228, 764), 1445, (737, 718, 506), (734, 702, 493)),
    (30_000.0, 0.1): ((532, 440, 441), (168, 354, 135), 246, (130, 124, 103), (118, 114, 81)),
    (30_000.0, 0.5): ((2156, 2151, 2164), (601, 1726, 594), 1122, (575, 564, 401), (557, 486, 330)),
    (30_000.0, 1.0): ((4098, 4110, 4120), (1179, 3348, 1178), 2197, (1141, 1123, 795), (1040, 721, 463)),
}
WHERE = ("t=9", "t=16", "t=30")


@pytest.mark.parametrize("case", TABLE_8_5)
def test_table_8_5_one_receiver(case: tuple[float, float]) -> None:
    distance, sigma = case
    slope, ends, held, regression, bound = TABLE_8_5[case]
    scenario = {"crossing_distance_m": distance, "one_receiver": True, "sigma_azimuth_deg": sigma}

    def found(**parameters: Any) -> Found:
        return Found(ANGLE, scenario, sigma_azimuth_deg=sigma, **parameters)

    assert found(omega="slope").at(RMS, WHERE) == pytest.approx(slope, rel=0.12)
    assert found(omega="ends", zone_windows=0.0).at(RMS, WHERE) == pytest.approx(ends, rel=0.1)
    assert found(omega="ends").at(RMS, WHERE) == pytest.approx((ends[0], held, ends[2]), rel=0.1)
    assert found(omega="regression").at(RMS, WHERE) == pytest.approx(regression, rel=0.1)
    assert found(omega="regression").at(BOUND_3, WHERE) == pytest.approx(bound, abs=0.6)


def test_section_7_formula_20_by_another_route() -> None:
    """Plain NumPy, nothing of the project: 1101 m belongs to (20) used 3.5 s from the crossing, 733 m to holding."""
    rng = np.random.default_rng(1)
    t, trials = np.arange(17.0), 20_000
    y, s, a = 200 * (t - 15), 15_000.0, 40_000.0
    f = -(y * 200 / np.hypot(s - a, y) + y * 200 / np.hypot(s, y))[:, None] + 0.2 * rng.standard_normal((17, trials))
    phi = np.arctan2(y, s)[:, None] + np.radians(0.5) * rng.standard_normal((17, trials))

    def line(values: np.ndarray, k: int) -> tuple[float, np.ndarray, np.ndarray]:
        own = slice(k - 9, k + 1)
        centre = t[own].mean()
        d = t[own] - centre
        return centre, values[own].mean(axis=0), (d[:, None] * values[own]).sum(axis=0) / (d * d).sum()

    # At 16 s the crossing at 15 s is kept in every run; the last windows further than 5 s from it end at 14 s.
    tau, gamma = np.full(trials, np.nan), np.full(trials, np.nan)
    for k in (14, 15, 16):
        centre, value, slope = line(f, k)
        new = np.isnan(tau) & (centre - value / slope <= t[k]) | np.isnan(tau) & (k == 16)
        tau[new], gamma[new] = (centre - value / slope)[new], slope[new]
    for k, printed in ((16, 1101), (14, 733)):
        centre, angle, _ = line(phi, k)
        omega = angle / (centre - tau)
        error = a * gamma / (gamma - a * omega**2) - s
        assert np.sqrt(np.mean(error**2)) == pytest.approx(printed, rel=0.06)


def test_table_8_5_height() -> None:
    """Elevations of 1 degree, azimuths of 0.5, after the whole pass: sd(H) 47 to 71 m at 15 km, 94 to 106 m at 30."""
    algorithm = algorithms_by_name()[ANGLE]
    for scenario, printed in ((S15, (47, 71)), (S30, (94, 106))):
        for height, sd in ((0.0, printed[0]), (3000.0, printed[1])):
            conditions = PassParameters(one_receiver=True, sigma_elevation_deg=1.0, altitude_m=height, **scenario)
            recording = simulate(conditions, tuple(range(1024)), 77)
            found = algorithm.run(recording, algorithm.parameters(), LocalContext()).arrays["height_m"][30]
            assert found.std() == pytest.approx(sd, rel=0.1)
            assert found.mean() == pytest.approx(height, abs=45)


def test_table_8_5_height_in_the_distance() -> None:
    """The planar (19) is wrong by -138 m at 15 km and -248 m at 30 km for 3 km of height; the corrected one is not."""
    algorithm = algorithms_by_name()[ANGLE]
    for scenario, bias in ((S15, -138), (S30, -248)):
        mean = []
        for height, corrected in ((0.0, False), (3000.0, False), (3000.0, True)):
            conditions = PassParameters(
                one_receiver=True, sigma_doppler_hz=0.002, sigma_azimuth_deg=0.01, sigma_elevation_deg=0.01,
                altitude_m=height, **scenario,
            )  # fmt: skip
            recording = simulate(conditions, tuple(range(8)), 77)
            given = algorithm.parameters(height_corrected=corrected)
            mean.append(algorithm.run(recording, given, LocalContext()).arrays["theta"][16, 1].mean())
        assert mean[1] - mean[0] == pytest.approx(bias, abs=6)
        assert mean[2] - mean[0] == pytest.approx(0, abs=6)


@pytest.mark.parametrize(("scenario", "bound"), [(S15, (499, 212, 150)), (S30, (203, 121, 89))], ids=["15", "30 km"])
def test_table_8_5_four_dopplers(scenario: dict[str, Any], bound: tuple[float, ...]) -> None:
    four = {**scenario, "transmitter_spacing_m": 300.0}
    found = Found(ML, four, trials=512, acceleration_switch=False)
    assert found.at(BOUND_4, WHERE) == pytest.approx(bound, abs=0.6)
    assert found.at(RMS, WHERE) == pytest.approx(bound, rel=0.15)
    # The closed form of both pairs together is better than that of either before the crossing, and just after it.
    both = Found(LINES, four).at(RMS, ("t=9", "t=16"))
    receivers = Found(LINES, scenario).at(RMS, ("t=9", "t=16"))
    transmitters = Found(LINES, {**four, "one_receiver": True}).at(RMS, ("t=9", "t=16"))
    assert (np.array(both) < np.minimum(receivers, transmitters)).all()


def test_section_7_two_transmitters_are_the_mirror_image() -> None:
    """Reciprocity: with the same noise the same error, from the other end."""
    for distance in (10_000.0, 25_000.0):
        scenario = {"crossing_distance_m": distance, "transmitter_spacing_m": 300.0, "one_receiver": True}
        here = Found(LINES, scenario)
        there = Found(LINES, {"crossing_distance_m": 40_000.0 - distance})
        assert here.at(RMS) == pytest.approx(there.at(RMS), rel=1e-6)
        assert here.at(MEAN) == pytest.approx(-np.array(there.at(MEAN)), rel=1e-6)


# 8.6: share of false values, method: median error at 16 s and share of errors beyond 5 km; as allowed here. What is
# printed for least squares and the plain likelihood differs by up to 7 % of the trials.
CONSENSUS = {"robust": "consensus", "confirm": 3}
HUBER = {"robust": "huber", "confirm": 3}
PLAIN_ML = {"acceleration_switch": False}
ROBUST_ML = {"acceleration_switch": False, "robust": "consensus"}


@pytest.mark.parametrize(
    ("name", "parameters", "share", "median", "far"),
    [
        (LINES, {}, 0.0, (381, 0.12), (0, 0.001)),
        (LINES, HUBER, 0.0, (387, 0.12), (0, 0.001)),
        (LINES, CONSENSUS, 0.0, (381, 0.12), (0, 0.001)),
        (ML, PLAIN_ML, 0.0, (227, 0.12), (0, 0.001)),
        (ML, ROBUST_ML, 0.0, (227, 0.12), (0, 0.001)),
        (LINES, {}, 0.05, (5623, 0.7), (0.52, 0.74)),
        (LINES, HUBER, 0.05, (422, 0.13), (0, 0.01)),
        (LINES, CONSENSUS, 0.05, (404, 0.13), (0, 0.005)),
        (ML, PLAIN_ML, 0.05, (8835, 0.25), (0.58, 0.76)),
        (ML, ROBUST_ML, 0.05, (246, 0.13), (0, 0.005)),
        (LINES, {}, 0.1, (12646, 0.15), (0.77, 0.93)),
        (LINES, HUBER, 0.1, (483, 0.13), (0, 0.03)),
        (LINES, CONSENSUS, 0.1, (411, 0.13), (0, 0.01)),
        (ML, PLAIN_ML, 0.1, (11153, 0.2), (0.74, 0.91)),
        (ML, ROBUST_ML, 0.1, (243, 0.13), (0, 0.005)),
        (LINES, {}, 0.2, (13324, 0.15), (0.87, 1.0)),
        (LINES, HUBER, 0.2, (622, 0.13), (0.04, 0.14)),
        (LINES, CONSENSUS, 0.2, (423, 0.13), (0, 0.03)),
        (ML, PLAIN_ML, 0.2, (13471, 0.15), (0.82, 0.96)),
        (ML, ROBUST_ML, 0.2, (268, 0.13), (0, 0.01)),
    ],
)
def test_table_8_6_false_values(
    name: str, parameters: dict[str, Any], share: float, median: tuple[float, float], far: tuple[float, float]
) -> None:
    found = Found(name, {**S15, "false_share": share}, trials=512, passes="one", **parameters)
    assert found.at(MEDIAN, ("t=16",))[0] == pytest.approx(median[0], rel=median[1])
    assert far[0] <= found.at(FAR, ("t=16",))[0] <= far[1]


def test_table_8_6_confirmation_is_needed() -> None:
    """Without three windows in a row even robust lines fail in some runs: one early false line is kept for ever."""
    for share in (0.1, 0.2):
        scenario = {**S15, "false_share": share}
        once = Found(LINES, scenario, trials=512, passes="one", robust="huber").at(FAR, ("t=16",))[0]
        thrice = Found(LINES, scenario, trials=512, passes="one", **HUBER).at(FAR, ("t=16",))[0]
        assert once > thrice + 0.03


@pytest.mark.parametrize(
    ("name", "parameters", "median", "far"),
    [
        (LINES, {}, 439, (0, 0.001)),
        # A robust line needs five values; of ten with 30 % missing there are fewer in a tenth of the trials, and then
        # there is no estimate at this instant. The printed 0 does not count that.
        (LINES, HUBER, 441, (0.04, 0.14)),
        (LINES, CONSENSUS, 439, (0.04, 0.14)),
        (ML, PLAIN_ML, 284, (0, 0.001)),
        (ML, ROBUST_ML, 284, (0, 0.001)),
    ],
)
def test_table_8_6_missing_values(
    name: str, parameters: dict[str, Any], median: float, far: tuple[float, float]
) -> None:
    found = Found(name, {**S15, "missing_share": 0.3}, trials=512, **parameters)
    assert found.at(MEDIAN, ("t=16",))[0] == pytest.approx(median, rel=0.13)
    assert far[0] <= found.at(FAR, ("t=16",))[0] <= far[1]


@pytest.mark.parametrize(
    ("zone", "paper", "likelihood"), [(0.0, 520, 257), (5.0, 719, 264), (10.0, 860, 270), (20.0, 2318, 308)]
)
def test_table_8_6_blind_zone(zone: float, paper: float, likelihood: float) -> None:
    scenario = {**S15, "blind_zone_hz": zone}
    assert Found(LINES, scenario, passes="one").at(RMS, ("t=30",))[0] == pytest.approx(paper, rel=0.1)
    fit = Found(ML, scenario, trials=512, acceleration_switch=False)
    assert fit.at(RMS, ("t=30",))[0] == pytest.approx(likelihood, rel=0.12)


def test_table_8_6_magnitudes_get_all_their_signs_back() -> None:
    """500 of 500 runs."""
    algorithm = algorithms_by_name()[ML]
    for scenario in (S15, S30):
        signed, unsigned = (
            simulate(PassParameters(unsigned=without, **scenario), tuple(range(500)), 77) for without in (False, True)
        )
        one = algorithm.run(signed, algorithm.parameters(), LocalContext()).arrays["theta"][-1]
        other = algorithm.run(unsigned, algorithm.parameters(unsigned=True), LocalContext()).arrays["theta"][-1]
        assert other == pytest.approx(one, rel=1e-6, abs=1e-6)


def test_table_8_7_calibration() -> None:
    """What an error costs does not depend on the noise: the mean moves by it."""
    for change, near, far in (
        ({"clock_error_ms": 10.0}, 203, 400),
        ({"frequency_offset_hz": 0.1}, -463, -753),
        ({"spacing_error_percent": 1.0}, 187, 147),
        ({"base_error_percent": 1.0}, 56, 227),
        ({"wavelength_error_percent": 1.0}, -93, -74),
        ({"common_offset_hz": 0.1}, 0, 0),
    ):
        for scenario, printed in ((S15, near), (S30, far)):
            moved = Found(LINES, {**scenario, **change})
            shift = moved.at(MEAN, ("t=16",))[0] - Found(LINES, scenario).at(MEAN, ("t=16",))[0]
            assert shift == pytest.approx(printed, rel=0.2, abs=15), (change, scenario)


def test_table_8_7_chi2_does_not_show_it() -> None:
    plain, late = (Found(ML, {**S15, "clock_error_ms": c}, trials=256) for c in (0.0, 10.0))
    assert late.at("chi2_per_dof", ("t=30",)) == pytest.approx(plain.at("chi2_per_dof", ("t=30",)), abs=0.03)


def test_table_8_8_spacing_and_noise() -> None:
    where = ("t=16", "t=30")
    for spacing, printed in ((150.0, (1073, 963)), (300.0, (527, 530)), (600.0, (262, 346)), (1000.0, (165, 321))):
        assert Found(LINES, {**S15, "spacing_m": spacing}).at(RMS, where) == pytest.approx(printed, rel=0.1)
    for sigma, printed in ((0.5, (1329, 1151)), (0.2, (527, 530)), (0.1, (267, 368))):
        assert Found(LINES, {**S15, "sigma_doppler_hz": sigma}).at(RMS, where) == pytest.approx(printed, rel=0.1)
    # The floor at the end is the bias of the curvature.
    assert Found(LINES, {**S15, "spacing_m": 1000.0}).at(SD, ("t=30",))[0] < 0.5 * 321


def test_table_8_8_a_window_can_be_too_long_for_a_fast_target() -> None:
    fast = {**S30, "speed_mps": 600.0}
    found = Found(LINES, fast)
    assert found.at(RMS, ("end",))[0] == pytest.approx(1196, rel=0.1)
    assert 140 < found.at(BOUND_3, ("end",))[0] < found.at(BOUND_3, ("crossing",))[0] < 200
    # v N T below 0.2 min(s, a - s) = 2 km: N = 3.
    assert Found(LINES, fast, window=4).at(RMS, ("end",))[0] < 0.6 * 1196


def test_table_8_8_near_the_ends_the_bound_vanishes_and_the_closed_form_does_not() -> None:
    for distance, bound, bias in ((5_000.0, 31, 1108), (38_000.0, 3.5, -394)):
        found = Found(LINES, {"crossing_distance_m": distance})
        assert found.at(BOUND_3, ("end",))[0] == pytest.approx(bound, abs=0.6)
        assert found.at(MEAN, ("end",))[0] == pytest.approx(bias, rel=0.06)
