"""Tables 8.1 to 8.3 of the forward-scatter specification through scenario, algorithm and statistics.

Bands: what is printed is known to +-3 % (means: to their standard deviation over experiments of a thousand runs); ours
of 1024 trials to as much. A number is allowed 10 % (a mean 4 standard deviations), false alarm below 1e-4 each; the
seed is fixed.
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
    AT,
    BOUND_3,
    BOUND_4,
    CLAIMED,
    KALMAN,
    LINES,
    MEAN,
    ML,
    RMS,
    S15,
    S30,
    SD,
    Found,
)

pytestmark = pytest.mark.slow

# 8.1 row by row: instant; for 15 km mean and its standard deviation, sd, both bounds; for 30 km the same.
TABLE_8_1 = """
 5   20  69 2144 603 2224  -139 118 3668 959 1619
 7 -114  36 1281 513 1169  -332  61 2179 797  902
 9 -122  29  868 452  722  -337  49 1460 675  679
10  -97  29  808 428  600  -282  47 1343 624  625
12  -44  22  690 389  457  -175  36 1126 538  561
14   -4  17  582 359  383   -94  28  937 469  522
15    7  16  536 346  360   -71  25  858 441  506
16   64  13  522 335  342   207  22  838 417  492
18   39  14  533 315  317   201  23  857 379  466
20   35  15  529 299  299   202  24  850 352  440
25  108  11  439 269  269   224  18  704 322  366
28  211  11  423 256  257   245  18  677 306  315
30  304  11  425 249  249   263  17  677 281  281
"""
ROWS = np.array([line.split() for line in TABLE_8_1.strip().splitlines()], float)
INSTANTS = tuple(ROWS[:, 0].tolist())
SEGMENTS = tuple(f"t={t:g}" for t in INSTANTS)


@pytest.mark.parametrize(("scenario", "columns"), [(S15, slice(1, 6)), (S30, slice(6, 11))], ids=["15 km", "30 km"])
def test_table_8_1_every_row(scenario: dict[str, Any], columns: slice) -> None:
    mean, spread, sd, three, four = ROWS[:, columns].T
    found = Found(LINES, {**scenario, "instants_s": INSTANTS})
    # At 5 s the sample sd itself scatters by 3 % and more.
    assert found.at(SD, SEGMENTS)[0] == pytest.approx(sd[0], rel=0.15)
    assert found.at(SD, SEGMENTS)[1:] == pytest.approx(sd[1:], rel=0.1)
    assert (np.abs(np.array(found.at(MEAN, SEGMENTS)) - mean) < 4 * np.sqrt(2) * spread).all()
    assert found.at(BOUND_3, SEGMENTS) == pytest.approx(three, abs=0.6)
    assert found.at(BOUND_4, SEGMENTS) == pytest.approx(four, abs=0.6)


def test_table_8_1_other_quantities() -> None:
    """Crossing time, velocity, y just after the crossing and later."""
    where = ("t=16", "t=20", "t=25", "t=30")
    for scenario, tau, vy, y in ((S15, 0.018, 4.0, (5.6, 20, 50, 84)), (S30, 0.015, 5.4, (6.3, 26, 76, 119))):
        found = Found(LINES, {**scenario, "instants_s": (16.0, 20.0, 25.0, 30.0)})
        assert found.at("rms_across_m", where) == pytest.approx(y, rel=0.1)
        assert found.at("rms_velocity_mps", ("t=16",)) == pytest.approx([vy], rel=0.1)
        trials = simulate(PassParameters(**scenario), tuple(range(512)), 5)
        algorithm = algorithms_by_name()[LINES]
        theta = algorithm.run(trials, algorithm.parameters(), LocalContext()).arrays["theta"]
        assert np.std(theta[16, 0]) == pytest.approx(tau, rel=0.13)


def test_table_8_1_before_six_seconds_there_are_no_moments() -> None:
    """At 3 s 13 % of the runs at 30 km fall outside the base line; medians and shares are what can be told."""
    found = Found(LINES, {**S30, "instants_s": (3.0,)}, trials=4096)
    assert 1 - found.at("answered_share", ("t=3",))[0] == pytest.approx(0.13, abs=0.035)
    algorithm = algorithms_by_name()[LINES]
    trials = simulate(PassParameters(**S30), tuple(range(4096)), 5).take(np.arange(7))
    raw = algorithm.run(trials, algorithm.parameters(), LocalContext()).arrays["theta"][:, 1].reshape(7, 8, 512)
    sd = raw.std(axis=2)
    assert sd[3].max() > 2 * sd[3].min(), "of eight experiments: they do not settle"
    assert sd[6].max() < 1.5 * sd[6].min(), "from 6 s on they do"


def test_section_4_predicted_errors_are_those_of_monte_carlo() -> None:
    """874 m predicted and 868 m found at 9 s, 416 and 425 m at 30 s; 667 and 677 m at 30 km."""
    near, far = Found(LINES, S15), Found(LINES, S30)
    # The prediction is made with estimated numbers, which widens its root mean square early.
    assert near.at(CLAIMED, ("t=9", "t=30")) == pytest.approx((874, 416), rel=0.1)
    assert far.at(CLAIMED, ("t=30",)) == pytest.approx((667,), rel=0.1)
    for found in (near, far):
        ratio = np.array(found.at(SD, ("t=12", "t=16", "t=20", "t=30"))) / found.at(
            CLAIMED, ("t=12", "t=16", "t=20", "t=30")
        )
        assert ratio == pytest.approx(1, abs=0.12)


# 8.3: rms error at 9, 12, 16, 20, 30 s.
WEAK = {"acceleration_switch": False, "sigma_velocity_along_mps": None}
TABLE_8_3: tuple[tuple[str, dict[str, Any], tuple[float, ...], tuple[float, ...]], ...] = (
    (LINES, {}, (877, 692, 526, 530, 523), (1498, 1139, 863, 874, 726)),
    (LINES, {"freeze_rule": "c"}, (877, 692, 500, 511, 478), (1498, 1139, 799, 818, 629)),
    (LINES, {"window": 31}, (882, 583, 431, 407, 391), (1505, 991, 748, 722, 687)),
    (LINES, {"formula": 18}, (1667, 1200, 731, 733, 774), (2672, 1926, 1244, 1235, 1363)),
    (LINES, {"formula": 19}, (577, 483, 435, 431, 581), (740, 698, 680, 682, 737)),
    (LINES, {"formula": 19, "window": 31}, (577, 490, 412, 371, 395), (740, 637, 544, 482, 395)),
    (
        LINES,
        {"freeze_delay": 4, "curvature_correction": True},
        (959, 720, 501, 424, 315),
        (1527, 1153, 800, 677, 486),
    ),
    (KALMAN, {"start_pairs": 10}, (627, 452, 353, 309, 263), (670, 561, 502, 460, 301)),
    (ML, {"unknowns": 3}, (455, 389, 337, 306, 259), (666, 532, 401, 344, 281)),
    (ML, WEAK, (719, 463, 351, 306, 259), (669, 557, 486, 442, 281)),
)


@pytest.mark.parametrize(("name", "parameters", "near", "far"), TABLE_8_3)
def test_table_8_3_estimators(name: str, parameters: dict[str, Any], near: Any, far: Any) -> None:
    # One number does not repeat: the filter at 9 s and 15 km, printed 627, is at 720 here, which is what the fit that
    # it starts from has, and the bound (722).
    skip = 1 if name == KALMAN else 0
    for scenario, printed in ((S15, near), (S30, far)):
        assert Found(name, scenario, **parameters).at(RMS, AT[skip:]) == pytest.approx(printed[skip:], rel=0.1)


@pytest.mark.parametrize("scenario", [S15, S30], ids=["15 km", "30 km"])
def test_the_default_reaches_the_bound_and_covers_what_it_says(scenario: dict[str, Any]) -> None:
    """At every instant from 9 s on: within 10 % of the bound, and 93 to 97 % inside the claimed 95 % interval."""
    found = Found(ML, scenario, trials=4096)
    ratio = found.curve(RMS)[9:] / found.curve(BOUND_4)[9:]
    assert (ratio < 1.10).all(), ratio
    assert (ratio > 0.93).all(), ratio
    share = found.curve("crossing_distance_coverage_share")[9:]
    assert ((share > 0.93) & (share < 0.97)).all(), share


@pytest.mark.parametrize("scenario", [S15, S30], ids=["15 km", "30 km"])
def test_intervals_hold_at_ten_times_the_noise(scenario: dict[str, Any]) -> None:
    """1.96 standard deviations cover 84 to 90 % there: the likelihood is curved, and the interval follows it."""
    found = Found(ML, scenario | {"sigma_doppler_hz": 2.0}, trials=2048)
    share = found.curve("crossing_distance_coverage_share")[20:]
    assert ((share > 0.91) & (share < 0.97)).all(), share


def test_table_8_2_all_measurements_in_place_of_ten() -> None:
    """The spread falls by 14 and 11 %; the rms error with its bias by 26 and 6 %."""
    for scenario, sd, rms in ((S15, 0.14, 0.26), (S30, 0.11, 0.06)):
        ten, every = (Found(LINES, scenario, window=n) for n in (10, 31))
        assert 1 - every.at(SD, ("t=30",))[0] / ten.at(SD, ("t=30",))[0] == pytest.approx(sd, abs=0.03)
        assert 1 - every.at(RMS, ("t=30",))[0] / ten.at(RMS, ("t=30",))[0] == pytest.approx(rms, abs=0.04)


def test_table_8_2_a_long_window_has_more_bias_on_a_slanted_course() -> None:
    for distance, crossing, end in ((15_000.0, (302, 662), (535, 1528)), (30_000.0, (702, 1383), (1736, 2769))):
        scenario = {"crossing_distance_m": distance, "course_deg": 60.0}
        found = [Found(LINES, scenario, window=n) for n in (10, 31)]
        assert [-f.at(MEAN, ("crossing",))[0] for f in found] == pytest.approx(crossing, abs=110)
        # x = s + v_x d: the bias of the velocity along the base line, which is taken for zero, is all of it.
        assert found[1].at("rms_horizontal_m", ("end",))[0] > 1.2 * found[0].at("rms_horizontal_m", ("end",))[0]
        assert end[1] > end[0]


def test_table_8_2_courses_of_60_to_120_degrees() -> None:
    for course in (60.0, 120.0):
        near, far = ({**s, "course_deg": course} for s in (S15, S30))
        assert 667 * 0.9 < Found(LINES, near).at(RMS, ("crossing",))[0] < 740 * 1.2
        assert 1213 * 0.9 < Found(LINES, far).at(RMS, ("crossing",))[0] < 1293 * 1.1
    assert Found(LINES, {**S15, "course_deg": 60.0}).at(MEAN, ("end",))[0] == pytest.approx(1760, abs=100)


def test_table_8_2_small_accelerations() -> None:
    """y(0) = -3 km; the printed velocity is taken for that at the crossing."""
    where = ("t=9", "t=17", "t=30")

    def at(acceleration: float) -> list[float]:
        scenario = {"acceleration_mps2": acceleration, "observed_s": 30.0, "instants_s": (9.0, 17.0, 30.0)}
        return Found(LINES, {**S15, **scenario}).at(RMS, where)

    assert at(1.0) == pytest.approx((1634, 570, 428), rel=0.12)
    assert at(-1.0)[2] == pytest.approx(906, rel=0.12)


def test_table_8_2_altitude_is_insignificant() -> None:
    for scenario, bias in ((S15, 102), (S30, -92)):
        plain, high = Found(LINES, scenario), Found(LINES, {**scenario, "altitude_m": 2000.0})
        # The draws are the same, so only the bias differs.
        assert high.at(MEAN, ("t=16",))[0] - plain.at(MEAN, ("t=16",))[0] == pytest.approx(bias, abs=12)
        assert high.at(SD, ("t=16",))[0] == pytest.approx(plain.at(SD, ("t=16",))[0], rel=0.03)


def test_table_8_2_formulas() -> None:
    """531, 731 and 954 m of (14), (18) and (17) as printed at 16 s; 524, 774 and 1324 m at 30 s; then 30 km."""
    for scenario, near, late in ((S15, (531, 731, 954), (524, 774, 1324)), (S30, None, (728, 1363, 2226))):
        found = [
            Found(LINES, scenario, formula=14),
            Found(LINES, scenario, formula=18),
            Found(LINES, scenario, formula=17, formula_17_origin="start"),
        ]
        assert [f.at(RMS, ("t=30",))[0] for f in found] == pytest.approx(late, rel=0.1)
        if near is not None:
            assert [f.at(RMS, ("t=16",))[0] for f in found] == pytest.approx(near, rel=0.1)


def test_section_11_formula_17_depends_on_the_origin() -> None:
    """With its origin at the crossing it is (18); at the window's centre it lies between the two."""
    printed = Found(LINES, S15, formula=17, formula_17_origin="start")
    centred, at_crossing = (Found(LINES, S15, formula=f) for f in (17, 18))
    spread = [f.at(SD, ("t=30",))[0] for f in (at_crossing, centred, printed)]
    assert spread == sorted(spread)
    assert (spread[0], spread[2]) == pytest.approx((736, 1254), rel=0.1)


def test_section_11_rules_of_freezing() -> None:
    """Mean error at 30 km and 16 s: A +201, B +343, C -49 m."""
    for rule, mean in (("a", 201), ("b", 343), ("c", -49)):
        assert Found(LINES, S30, freeze_rule=rule).at(MEAN, ("t=16",))[0] == pytest.approx(mean, abs=110)
    # The draws are the same, so their differences are known better.
    a, b, c = (Found(LINES, S30, freeze_rule=rule).at(MEAN, ("t=16",))[0] for rule in "abc")
    assert (b - a, a - c) == pytest.approx((142, 250), abs=30)
