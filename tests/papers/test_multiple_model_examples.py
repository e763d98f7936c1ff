"""The worked examples of the multiple-model specification (section 18), relative 1e-8; frames as it has them, NUE."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.toolbox.filters.merging import RULES, merge_weights
from algorithms.toolbox.filters.multiple_model import (
    STRUCTURES,
    Bank,
    absorb,
    advance,
    combine,
    conclude,
    new_track,
    new_work,
)
from algorithms.toolbox.filters.transition import chains_of, transition_over
from algorithms.toolbox.frames.bicone import (
    antenna_axes,
    bicone_from_position,
    bicone_jacobian,
    conversion_bias,
    covariance_from_bicone,
    position_from_bicone,
)
from algorithms.toolbox.kernels import LANES
from algorithms.toolbox.kernels.symmetric import pack, unpack
from algorithms.toolbox.motion.models import (
    KINDS,
    known_acceleration,
    noise_coefficients,
    transition_coefficients,
)

Floats = np.ndarray
# North, up, east in the places of east, north, up.
NUE = [1, 2, 0]
THREE = np.array([[0.996, 0, 0.002], [0, 0.996, 0.002], [0.004, 0.004, 0.996]])
TWO = np.array([[0.995, 0.01], [0.005, 0.99]])


def close(got: object, want: object, rtol: float = 1e-8) -> None:
    np.testing.assert_allclose(got, want, rtol=rtol, atol=0)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "centre", "position", "upper"),
    [
        (
            0, 30, (0, 0, 0), (58885.09338, 50038.25606, -20705.52361),
            (9208.545079, -9054.256725, 4289.618092, 11685.98536, 2476.287809, 18189.98167),
        ),
        (
            40, 20, (1.5, 12, -2), (64390.25161, 39064.77335, 26997.43628),
            (6562.315415, -7281.868132, -5102.318447, 14708.01957, -3899.1361, 17814.17712),
        ),
    ],
)  # fmt: skip
def test_18_1_bicone(azimuth: float, elevation: float, centre: tuple, position: tuple, upper: tuple) -> None:
    b = (80_000.0, np.radians(10), np.radians(-15))
    sd = (2.5, np.radians(0.1), np.radians(0.1))
    axes = antenna_axes(np.radians(azimuth), np.radians(elevation))
    middle = np.array([centre[2], centre[0], centre[1]], float)
    y = position_from_bicone(*b, axes, middle)
    close(y[NUE], position)
    r = covariance_from_bicone(*b, sd, axes)
    close(r[NUE][:, NUE][np.triu_indices(3)], upper)
    close(np.linalg.eigvalsh(r), (6.25, 18615.97214, 20462.28997))
    np.testing.assert_allclose(bicone_from_position(y, axes, middle), b, rtol=1e-12)
    close(bicone_jacobian(*b)[0], (0.950188935, -14397.98468, 21048.44549))


def test_the_antenna_looks_where_it_should() -> None:
    close(antenna_axes(0, np.radians(30))[0], (0, np.cos(np.pi / 6), 0.5))
    np.testing.assert_allclose(antenna_axes(np.pi / 2, 0)[0], (1, 0, 0), atol=1e-15)
    assert np.linalg.det(antenna_axes(0.7, 0.4)) == pytest.approx(1)


def test_the_bias_of_conversion_is_that_of_draws() -> None:
    r, eps, alpha, s = 100_000.0, np.radians(45), np.radians(30), np.radians(1.0)
    draws = np.random.default_rng(3).normal(size=(2, 400_000)) * s
    # Opposite errors beside each other: what is odd cancels.
    both = np.concatenate([draws, -draws], axis=1)
    mean = position_from_bicone(np.full(both.shape[1], r), eps + both[0], alpha + both[1], np.eye(3), np.zeros(3)).mean(
        0
    )
    true = position_from_bicone(r, eps, alpha, np.eye(3), np.zeros(3))
    np.testing.assert_allclose(mean - true, conversion_bias(r, eps, alpha, s, s), rtol=0.02)


def test_18_2_powers_of_the_transition_matrix() -> None:
    half, clip = transition_over(THREE, 0.5)
    close(np.diag(half), np.full(3, 0.9979959859))
    assert half[0, 1] == half[1, 0] == 0
    assert clip == pytest.approx(1.006035e-6, rel=1e-6)
    close((half[0, 2], half[2, 0]), (0.00100200804, 0.002004014064))
    close(transition_over(THREE, 1)[0], THREE)
    p = transition_over(THREE, 2.5)[0]
    close((p[0, 0], p[0, 1], p[0, 2], p[2, 0], p[2, 2]),
          (0.99004495, 1.496996491e-5, 0.00497004004, 0.00994008008, 0.9900599199))  # fmt: skip
    p = transition_over(THREE, 20)[0]
    close((p[0, 0], p[0, 1], p[0, 2], p[2, 0], p[2, 2]),
          (0.9243830491, 0.001414784471, 0.03710108323, 0.07420216646, 0.9257978335))  # fmt: skip
    for s, want in (
        (0.5, (0.997490554, 0.005018891957, 0.002509445979, 0.994981108)),
        (2.5, (0.9876402728, 0.02471945445, 0.01235972722, 0.9752805456)),
        (20, (0.9130454778, 0.1739090444, 0.08695452222, 0.8260909556)),
    ):
        close(transition_over(TWO, s)[0].ravel(), want)


def test_hours_give_the_stationary_probabilities() -> None:
    p = transition_over(THREE, 1e9)[0]
    np.testing.assert_allclose(p, np.tile([[0.25], [0.25], [0.5]], 3), atol=1e-7)
    np.testing.assert_allclose(p.sum(axis=0), 1, atol=1e-15)
    np.testing.assert_allclose(transition_over(THREE, 1e-6)[0], np.eye(3), atol=1e-8)


def coefficients(kind: str, dt: float, rate: bool, x: tuple = (0,) * 9) -> Floats:
    c, t = np.zeros((16, LANES)), np.full(LANES, dt)
    s = np.repeat(np.array([*x, *(0,) * 45], float)[:, None], LANES, 1)
    known_acceleration(KINDS.index(kind), s, c)
    transition_coefficients(KINDS.index(kind), t, s, c)
    noise_coefficients(KINDS.index(kind), np.ones(LANES), t, np.full(LANES, float(rate)), 1.0, c)
    return c[:, 5]


def test_18_3_noise_of_both_forms() -> None:
    # Upper triangle xx xv xa vv va aa; ours is the lower one, row by row.
    order = [0, 1, 3, 2, 4, 5]
    for kind, dt, rate, want in (
        ("cv", 0.05, False, (1.5625e-6, 6.25e-5, 0, 0.0025, 0, 0)),
        ("cv", 1, False, (0.25, 0.5, 0, 1, 0, 0)),
        ("cv", 0.05, True, (4.1666666667e-5, 0.00125, 0, 0.05, 0, 0)),
        ("ca", 0.05, False, (1.5625e-6, 6.25e-5, 0.00125, 0.0025, 0.05, 1)),
        ("ca", 0.05, True, (1.5625e-8, 7.8125e-7, 2.0833333333e-5, 4.1666666667e-5, 0.00125, 0.05)),
        ("ca", 1, True, (0.05, 0.125, 1 / 6, 1 / 3, 0.5, 1)),
    ):
        close(coefficients(kind, dt, rate)[7:13][order], want, 1e-7)


@pytest.mark.parametrize(
    ("kind", "want"),
    [
        ("ca", (97020, -1480, 10, 20560, 260, -20, 5260, 160, 30)),
        ("ct", (97021.07046, -1478.396222, 11.59991037, 20559.79235, 259.6921328, -20.30065081, 5259.917657,
                159.8711234, 29.86040457)),
        ("gv", (97000, -1500, 0, 20580.3867, 280.3867, -9.80665, 5200, 100, 0)),
        ("gd", (97017.5141, -1482.485904, 8.757047842, 20576.88388, 276.8838809, -11.55805957, 5198.832394, 98.83239362,
                -0.5838031895)),
    ],
)  # fmt: skip
def test_18_3_predictions(kind: str, want: tuple) -> None:
    north, up, east = (100_000, -1500, 10), (20_000, 300, -20), (5_000, 100, 30)
    bank = Bank(np.array([KINDS.index(kind)]), np.zeros(1), 1, 0, 0, 0, np.inf, chains_of([np.eye(1)], 1.0))
    track, work = new_track(1), new_work(1, 1)
    track.s[0, :9] = np.array([*east, *north, *up], float)[:, None]
    advance(bank, track, work, np.full(LANES, 2.0), np.zeros(LANES, np.int64))
    got = work.s[0, :9, 3].reshape(3, 3)[[1, 2, 0]].ravel()
    np.testing.assert_allclose(got, want, rtol=1e-8, atol=1e-9)


STATES = np.array(
    [
        (100000, -1500, 0, 20000, 300, 0, 5000, 50, 0),
        (100040, -1510, 8, 20030, 290, -9, 4980, 55, 1),
        (99970, -1480, -15, 19950, 320, 20, 5030, 40, -10),
    ],
    float,
)
AXES = np.array([[1, 0.2, -0.1], [0.2, 1.5, 0.3], [-0.1, 0.3, 0.8]])
BLOCKS = (
    np.diag([900.0, 100.0, 0.0]),
    np.array([[1600, 120, 6], [120, 64, 4], [6, 4, 1.0]]),
    np.array([[2500, 900, 200], [900, 1600, 500], [200, 500, 400.0]]),
)
MARK = np.array([98490, 20330, 5045.0])
NOISE = np.array([[2500, 300, -200], [300, 10000, 500], [-200, 500, 8000.0]])


def one_step(structure: str, rule: str, *, moment: bool = True):
    """One step of three models over 1 s; the models know no axis from another, so NUE stands in the places of ENU."""
    bank = Bank(
        np.array([0, 1, 1]), np.array([0.05, 0.05, 30]), STRUCTURES.index(structure), RULES.index(rule), int(moment), 0,
        np.inf, chains_of([THREE], 0.05),
    )  # fmt: skip
    track, work = new_track(3), new_work(3, bank.structure)
    for m in range(3):
        track.s[m, :9] = STATES[m][:, None]
        track.s[m, 9:] = pack(np.kron(AXES, BLOCKS[m]))[:, None]
    track.share[:] = np.array([0.90, 0.07, 0.03])[:, None]
    track.log[:] = np.log(track.share)
    common = np.zeros((54, LANES))
    combine(bank._replace(output_moment=1), track, work, np.arange(54), common)
    track.common[:] = common
    advance(bank, track, work, np.full(LANES, 1.0), np.zeros(LANES, np.int64))
    root = np.linalg.cholesky(NOISE)
    inverse = np.linalg.inv(root)
    for h in range(len(work.s)):
        rows = np.zeros((23, LANES))
        rows[:9] = inverse.ravel()[:, None]
        rows[9:12] = (inverse @ (MARK - work.s[h, [0, 3, 6], 0]))[:, None]
        rows[12:18] = 1.0
        absorb(bank, work, h, rows, np.full(LANES, 2 * np.log(np.diag(root)).sum()), work.updated[h])
    conclude(bank, track, work, work.updated, np.ones(LANES))
    combine(bank, track, work, np.arange(54), common)
    return track, work, common


STEPS = {
    ("imm", "moment"): (
        (-16.10839738, -16.49430281, -16.51389638), -16.1646854, (0.8813985363, 0.04825331696, 0.07034814673),
        (98493.53558, -1500.863127, -4.75818841, 20304.57783, 314.5820197, 6.952908647, 5053.041692, 44.36311378,
         -3.199242949), 6570.936659,
        (98497.81882, -1500.482356, 0.004269725223, 20303.96032, 300.5271671, 0.09954992936, 5050.126345, 49.90517702,
         -0.1885212248),
    ),
    ("imm", "combined"): (
        (-16.10658175, -16.49218275, -16.51389638), -16.1629827, (0.8814980733, 0.04827346019, 0.07022846653),
        (98493.53558, -1500.863127, -4.75818841, 20304.57783, 314.5820197, 6.952908647, 5053.041692, 44.36311378,
         -3.199242949), 6570.936659,
        (98497.9079, -1500.487533, 0.04700970285, 20304.00955, 300.4009923, 0.05410080095, 5050.060476, 49.94889965,
         -0.1754798329),
    ),
    ("imm", "modified"): (
        (-16.10658175, -16.49218275, -16.51423992), -16.16300682, (0.8815193372, 0.04827462466, 0.07020603815),
        (98492.587, -1500.14505, -5.124499015, 20303.98253, 316.4361657, 7.789272041, 5053.749506, 43.64843826,
         -3.443603464), 6643.851188, None,
    ),
    ("imm", "max"): (
        None, -16.13344828, (0.8558442406, 0.0468685799, 0.0972871795),
        (98496.81056, -1501.655655, -1.407064926, 20303.85385, 301.5625153, 1.23908442, 5050.214152, 49.63579553,
         -0.4059154586), 3915.182048, None,
    ),
    ("gpb2", "moment"): (
        None, -16.15250812, (0.8715758344, 0.04784127147, 0.08058289417),
        (98496.46033, -1500.636119, -2.866345426, 20304.4478, 307.5919757, 3.863772359, 5050.923209, 46.86403537,
         -1.807574115), 4952.912554,
        (98498.05956, -1500.455033, 0.1266006679, 20303.98138, 300.0638583, -0.09290971136, 5049.951492, 50.06237444,
         -0.1033857269),
    ),
    ("gpb1", "moment"): (
        (-16.17206731, -16.17934091, -16.22800621), -16.1779978, (0.8381125283, 0.0670030995, 0.09488437221), None,
        None,
        (98498.04403, -1500.780937, -0.1454163937, 20304.30107, 300.5810415, 0.1286787265, 5050.08561, 50.06098723,
         -0.07245868122),
    ),
}  # fmt: skip


@pytest.mark.parametrize(("structure", "rule"), list(STEPS))
def test_18_4_and_18_5_one_step(structure: str, rule: str) -> None:
    likelihood, evidence, probabilities, third, norm, answer = STEPS[structure, rule]
    track, work, common = one_step(structure, rule)
    lane = 7
    close(work.evidence[lane], evidence)
    close(np.exp(track.log[:, lane]), probabilities)
    if likelihood is not None:
        close(work.likelihood[:, lane], likelihood)
    if third is not None:
        close(track.s[2, :9, lane], third)
        close(np.linalg.norm(unpack(track.s[2, 9:, lane])), norm)
    if answer is not None:
        close(common[:9, lane], answer)


def test_the_answer_of_the_most_probable_model() -> None:
    track, _, common = one_step("imm", "moment", moment=False)
    assert common.tobytes() == track.s[0].tobytes()


@pytest.mark.parametrize(
    ("p", "rule", "weights", "total"),
    [
        ((0.2, 0.5, 0.3), "moment", (0.2, 0.5, 0.3), 0.5),
        ((0.2, 0.5, 0.3), "combined", (0.2, 0.5, 0.3), 0.5),
        ((0.2, 0.5, 0.3), "combined_sum", (0.2, 0.5, 0.3), 0.5),
        ((0.2, 0.5, 0.3), "max", (0, 1, 0), 0.5),
        ((0.2, 0.5, 0.3), "modified", (0.2857142857142857, 0.7142857142857143, 0), 0.5),
        ((0.2, 0.5, 0.3), "modified_pair", (0.2857142857142857, 0.7142857142857143, 0), 0.35),
        ((0.45, 0.3, 0.25), "combined_sum", (0.45, 0.3, 0.25), 0.5),
        ((0.45, 0.3, 0.25), "combined", (1, 0, 0), 0.5),
        ((0.45, 0.3, 0.25), "modified", (1, 0, 0), 0.5),
        ((0.4, 0.4, 0.2), "combined", (0.4, 0.4, 0.2), 0.5),
        ((0.4, 0.4, 0.2), "max", (1, 0, 0), 0.5),
        ((0.4, 0.4, 0.2), "modified", (0.5, 0.5, 0), 0.5),
        ((0.4, 0.4, 0.2), "modified_pair", (0.5, 0.5, 0), 0.4),
    ],
)
def test_18_6_rules(p: tuple, rule: str, weights: tuple, total: float) -> None:
    logs = np.log(np.repeat(0.5 * np.array(p)[:, None], LANES, 1))
    # A tie must be one to the bit.
    logs[1] = logs[0] if p[0] == p[1] else logs[1]
    got, merged = np.zeros((3, LANES)), np.zeros(LANES)
    merge_weights(logs, 0, RULES.index(rule), got, merged, np.empty((2, LANES)))
    np.testing.assert_allclose(got[:, 0], weights, rtol=1e-12, atol=1e-15)
    assert np.exp(merged[0]) == pytest.approx(total, rel=1e-12)


def test_18_7_logarithms_do_not_underflow() -> None:
    logs = np.repeat((np.log([0.2, 0.5, 0.3]) + np.array([-10000, -10003.5, -10020]))[:, None], LANES, 1)
    weights, total = np.zeros((3, LANES)), np.zeros(LANES)
    merge_weights(logs, 0, RULES.index("moment"), weights, total, np.empty((2, LANES)))
    close(total[0], -10001.536658322088, 1e-14)
    close(weights[:, 0], (0.929805745605, 0.0701942515207, 2.87470872108e-9), 1e-10)
