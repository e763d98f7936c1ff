"""Sites, courses, accelerations, altitude and filters of the forward-scatter specification (4, 6, 8.3, 8.4) in trials.

Bands as in test_forward_scatter.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.errors import RecordingError
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.registry import algorithms_by_name
from algorithms.spec import LocalContext
from tests.monte_carlo.scatter import BOUND_4, KALMAN, LINES, MEAN, ML, RMS, S15, S30, SD, Found

pytestmark = pytest.mark.slow

WEAK = {"acceleration_switch": False, "sigma_velocity_along_mps": None}


def arrays(name: str, scenario: dict[str, Any], trials: int = 1024, **parameters: Any) -> dict[str, Any]:
    """Everything an algorithm gives for so many trials."""
    algorithm = algorithms_by_name()[name]
    recording = simulate(PassParameters(**scenario), tuple(range(trials)), 77)
    return dict(algorithm.run(recording, algorithm.parameters(**parameters), LocalContext()).arrays)


# 8.4: course; the paper's mean and sd at the crossing and at the end; a fixed course: mean and chi2/dof there; course
# unknown: sd there.
TABLE_8_4 = {
    60.0: ((-702, 989, 112, 768), (6236, 7.7, -5062, 318), (380, 197)),
    75.0: ((-424, 907, -7, 706), (4004, 4.3, -2327, 89), (440, 267)),
    105.0: ((344, 861, 42, 684), (-2874, 10.3, -2507, 89), (530, 269)),
    120.0: ((-234, 1271, -943, 1115), (-4905, 55, -6133, 328), (583, 203)),
}


@pytest.mark.parametrize("course", TABLE_8_4)
def test_table_8_4_the_trap_of_a_known_course(course: float) -> None:
    paper, fixed, unknown = TABLE_8_4[course]
    scenario, where = {**S30, "course_deg": course}, ("crossing", "end")
    found = Found(LINES, scenario)
    assert found.at(MEAN, where) == pytest.approx(paper[::2], abs=150)
    assert found.at(SD, where) == pytest.approx(paper[1::2], rel=0.1)
    trap = Found(ML, scenario, trials=256, unknowns=3)
    assert trap.at(MEAN, where) == pytest.approx(fixed[::2], rel=0.03)
    assert trap.at("chi2_per_dof", where) == pytest.approx(fixed[1::2], rel=0.05)
    free = Found(ML, scenario, **WEAK)
    # Four standard errors of the mean.
    assert np.abs(free.at(MEAN, where)) == pytest.approx(0, abs=75)
    assert free.at(SD, where) == pytest.approx(unknown, rel=0.1)


def test_table_8_3_the_course_is_found() -> None:
    """Its standard deviation at 5, 9, 12, 16 and 30 s; at 5 s its tails have no moments, so the middle counts."""
    for scenario, printed in ((S15, (27.7, 9.2, 5.0, 2.6, 0.6)), (S30, (12.9, 3.7, 2.0, 1.1, 0.2))):
        theta = arrays(ML, scenario, **WEAK)["theta"][[5, 9, 12, 16, 30]]
        course = np.degrees(np.arctan2(theta[:, 2], theta[:, 3]))
        low, high = np.percentile(course, [15.87, 84.13], axis=1)
        assert (high - low) / 2 == pytest.approx(printed, rel=0.12)
        assert np.median(course, axis=1) == pytest.approx(90, abs=3)


def test_table_8_3_the_wrong_sign_of_the_velocity_along_the_base_line() -> None:
    """Course of 80 degrees, at 7, 9, 12 and 16 s."""
    for scenario, printed in ((S15, (0.27, 0.13, 0.02, 0.0)), (S30, (0.09, 0.01, 0.0, 0.0))):
        theta = arrays(ML, {**scenario, "course_deg": 80.0}, **WEAK)["theta"][[7, 9, 12, 16]]
        assert (theta[:, 3] < 0).mean(axis=1) == pytest.approx(printed, abs=0.06)


@pytest.mark.parametrize("scenario", [S15, S30], ids=["15 km", "30 km"])
def test_section_4_sites_that_are_not_symmetrical(scenario: dict[str, Any]) -> None:
    """The receivers' line is turned: the fit stays at the bound of that site, the closed form works up to a degree."""
    for turn in (-30.0, 30.0, 60.0):
        found = Found(ML, {**scenario, "askew_deg": turn})
        ratio = found.curve(RMS)[9:] / found.curve(BOUND_4)[9:]
        assert ((ratio > 0.88) & (ratio < 1.13)).all(), (turn, ratio)
        share = found.curve("crossing_distance_coverage_share")[9:]
        assert ((share > 0.92) & (share < 0.975)).all(), (turn, share)
    straight, turned = (Found(LINES, {**scenario, "askew_deg": d}) for d in (0.0, 0.9))
    assert turned.at(RMS) == pytest.approx(straight.at(RMS), rel=0.05)
    with pytest.raises(RecordingError, match=r"2\.00 degrees"):
        Found(LINES, {**scenario, "askew_deg": 2.0})


def test_section_6_2_the_switch_to_an_acceleration() -> None:
    near, far = ({**s, "acceleration_mps2": 1.0, "crossing_time_s": 15.0} for s in (S15, S30))
    assert Found(ML, near).at(RMS, ("t=16", "t=30")) == pytest.approx((537, 252), rel=0.12)
    assert Found(ML, far).at(RMS, ("t=16", "t=30")) == pytest.approx((1301, 316), rel=0.12)
    fired = arrays(ML, far)["theta"][[16, 30], 4] != 0
    assert fired.mean(axis=1) == pytest.approx((0.21, 1.0), abs=0.05)
    # Left out, it goes into the velocity along the base line; the windows of the paper's method suffer less.
    fixed = Found(ML, near, trials=256, acceleration_switch=False)
    assert (np.array(fixed.at(RMS, ("t=9", "t=16", "t=30"))) > 1800).all()
    assert (np.array(fixed.at(RMS, ("t=9", "t=16", "t=30"))) < 3300).all()
    assert fixed.at(RMS, ("t=16",))[0] > 3 * Found(LINES, near).at(RMS, ("t=16",))[0]


def test_section_6_2_five_unknowns_end_on_curved_ridges() -> None:
    """Full steps overshoot there from side to side; one fit in fifty used to give up."""
    found = arrays(ML, {**S30, "acceleration_mps2": 1.0, "crossing_time_s": 15.0}, unknowns=5)
    assert (found["status"][8:] == found["status"][30, 0]).mean() > 0.9995


def test_section_6_3_a_known_altitude_takes_its_bias_away() -> None:
    """Ignored, 2 km cost the fit about 100 m at 15 km and -90 m at 30 km."""
    for scenario, bias in ((S15, 100), (S30, -90)):
        quiet = {**scenario, "altitude_m": 2000.0, "sigma_doppler_hz": 0.002}
        told = {"sigma_doppler_hz": 0.2, "acceleration_switch": False}
        distance = scenario["crossing_distance_m"]
        ignored, known = (
            arrays(ML, quiet, trials=8, altitude_m=h, **told)["theta"][16, 1].mean() - distance for h in (0.0, 2000.0)
        )
        assert ignored == pytest.approx(bias, abs=25)
        assert abs(known) < 8


@pytest.mark.parametrize(
    ("form", "pairs", "near", "far", "honest"),
    [
        ("ekf", 13, 1.03, 1.08, 20),
        ("ekf", 10, 1.05, 1.12, 40),
        ("ukf", 13, 1.03, 1.08, 20),
        ("static", 13, 1.02, 1.03, 14),
    ],
)
def test_section_6_4_filters_lose_little_when_they_start_late(
    form: str, pairs: int, near: float, far: float, honest: float
) -> None:
    """Up to 5 % of the fit's error with 13 pairs (static form 3 %), up to 10 % with ten."""
    for scenario, most in ((S15, near), (S30, far)):
        where = ("t=16", "t=20", "t=30")
        fit = np.array(Found(ML, scenario, trials=512, acceleration_switch=False).at(RMS, where))
        found = Found(KALMAN, scenario, trials=512, filter=form, start_pairs=pairs)
        assert (np.array(found.at(RMS, where)) / fit < most).all(), scenario
    # Jointly overconfident even then: 4 would be honest, 12 and 5 are printed for 13 pairs.
    assert 4.5 < _joint_nees(form, pairs) < honest


def test_section_6_4_filters_that_start_early_lose_much_and_do_not_know_it() -> None:
    where = ("t=16", "t=30")
    fit = np.array(Found(ML, S30, trials=512, acceleration_switch=False).at(RMS, where))
    for form, least in (("ekf", 1.2), ("static", 2.0)):
        assert (np.array(Found(KALMAN, S30, trials=512, filter=form, start_pairs=6).at(RMS, where)) / fit > least).all()
        assert _joint_nees(form, 6) > 30


def _joint_nees(form: str, pairs: int) -> float:
    """Mean over trials at 30 s of the squared error of (tau, s, v_y, v_x) in units of its covariance."""
    found = arrays(KALMAN, S30, trials=512, filter=form, start_pairs=pairs)
    error = found["theta"][30, :4].T - np.array([15.0, 30_000.0, 200.0, 0.0])
    known = np.isfinite(error).all(axis=1)
    covariance = np.moveaxis(found["theta_covariance"][30, :4, :4], -1, 0)[known]
    return float(np.einsum("ni,nij,nj->n", error[known], np.linalg.inv(covariance), error[known]).mean())
