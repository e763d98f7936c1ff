"""Two motion models side by side for every lane: constant velocity and constant acceleration, each with a bias.

A model's state has ten components, [x vx ax  y vy ay  z vz az  b]: b is what the decoded altitude differs by from the
geometric height, first-order Gauss-Markov. The models interact (blom1988): before each mark every model starts from a
mixture of both, afterwards both are merged by their moments into the estimate that is shown.

Nothing is fused here (`strict`), so that no last digit can hang on a lane's place in the block.

References
----------
blom1988; barshalom2001, sec. 11.6.6; specification 6.2, 6.5.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.conditions import Conditions
from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import LANES, strict
from algorithms.toolbox.motion.jerk import predict_jerk

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STATES = 10
PACKED = 55
BIAS = 45
"""Where the bias's row begins in a packed covariance."""
# Of the constant-velocity model, so that its covariance has an inverse: (m/s2)^2.
STILL_VARIANCE = 1e-6
SMALLEST_WEIGHT = 1e-6
# No division by an interval of zero.
SHORTEST_S = 1e-9
# Packed elements in whose row or column an acceleration stands.
_ACCELERATIONS = np.array(
    [i * (i + 1) // 2 + j for i in range(STATES) for j in range(i + 1) if {i, j} & {2, 5, 8}], np.int64
)


class Choice(NamedTuple):
    """What the bank's models are."""

    stay_cv_s: float
    """Mean time for which a flight stays straight."""
    stay_ca_s: float
    """Mean time of a manoeuvre."""
    sigma_acceleration: float
    """m/s^2, of the straight flight"""
    sigma_jerk: float
    """m/s^3, of the manoeuvre"""
    noise_form: int
    altitude_variance: float
    """m^2, of the decoded altitude about its bias"""
    bias_variance: float
    """m^2, 0 = there is no bias"""
    bias_time_s: float
    limits: Floats
    """(S + 2,) NIS that a good mark with so many degrees of freedom exceeds with one minus the gate's probability"""


def straight_noise(t: Floats, sigma_acceleration: float) -> Floats:
    """(L, 9, 9): process noise of the straight flight over intervals t (L,) s, as `predict_bank` adds it."""
    q1 = np.zeros((t.size, 3, 3))
    held = np.maximum(t, 1.0 / np.maximum(t, SHORTEST_S))
    g = np.stack([0.5 * t * t, t], axis=1) * (sigma_acceleration * np.sqrt(held))[:, None]
    q1[:, :2, :2] = g[:, :, None] * g[:, None, :]
    q1[:, 2, 2] = STILL_VARIANCE
    out = np.zeros((t.size, 9, 9))
    for a in range(0, 9, 3):
        out[:, a : a + 3, a : a + 3] = q1
    return out


def with_altitude_noise(choice: Choice, conditions: Conditions) -> Choice:
    """Complete what the models need with the noise of the altitude."""
    return choice._replace(altitude_variance=conditions.sigma_altitude_m**2)


class Bank(NamedTuple):
    """What every lane remembers of both models, and room for one mark."""

    x: Floats
    """(2, 10, LANES)"""
    p: Floats
    """(2, 55, LANES) packed"""
    weight: Floats
    """(2, LANES)"""
    on: Ints
    """(LANES,) 1 where the lane's track is the bank's"""
    t: Floats
    """(LANES,) s to predict"""
    go: Floats
    """(LANES,) 1 where the mark updates the bank"""
    bias: Floats
    """(2, LANES): merged bias and its variance"""
    left: Ints
    """(LANES,) what was left out: 0 = nothing, s + 1 = the reception of station s, -1 = the altitude"""
    at: Floats
    """(2, 3, LANES) m, where each model linearises the mark"""
    start: Floats
    """(2, 4, LANES), predicted position and bias"""
    h: Floats
    """(2, S + 1, 3, LANES)"""
    along: Floats
    """(S + 1, LANES)"""
    nu: Floats
    variance: Floats
    active: Floats
    """(2, S + 1, LANES)"""
    small_x: Floats
    small_p: Floats
    """(4, LANES), (10, LANES): position and bias, to learn NIS"""
    nis: Floats
    """(2, LANES), before the noise was scaled"""
    determinant: Floats
    """(2, LANES), product of S / R"""
    score: Floats
    """(2, LANES)"""
    waste: Floats
    """(LANES,)"""


def new_bank(stations: int) -> Bank:
    """Lanes without a track."""
    p = np.zeros((2, PACKED, LANES))
    for i in range(STATES):
        p[:, i * (i + 1) // 2 + i] = 1.0  # idle lanes stay harmless
    along = np.zeros((stations + 1, LANES))
    along[stations] = 1.0
    return Bank(
        x=np.zeros((2, STATES, LANES)),
        p=p,
        weight=np.full((2, LANES), 0.5),
        on=np.zeros(LANES, np.int64),
        t=np.zeros(LANES),
        go=np.zeros(LANES),
        bias=np.zeros((2, LANES)),
        left=np.zeros(LANES, np.int64),
        at=np.zeros((2, 3, LANES)),
        start=np.zeros((2, 4, LANES)),
        h=np.zeros((2, stations + 1, 3, LANES)),
        along=along,
        nu=np.zeros((2, stations + 1, LANES)),
        variance=np.ones((2, stations + 1, LANES)),
        active=np.zeros((2, stations + 1, LANES)),
        small_x=np.zeros((4, LANES)),
        small_p=np.zeros((10, LANES)),
        nis=np.zeros((2, LANES)),
        determinant=np.ones((2, LANES)),
        score=np.zeros((2, LANES)),
        waste=np.zeros(LANES),
    )


@strict
def take_over(lane, setup, choice, track, bank, altitude, has_altitude):
    """Give both models the lane's track.

    What the track knows of the height it knows from altitudes whose noise included the bias. So height and bias are
    correlated: with K the gain that such an altitude had, cov(p, b) = -K sigma_b^2, and the bias itself is what this
    altitude's residual says.
    """
    q = np.zeros(9)
    x = track.x[0]
    p = track.p[0]
    share = 0.0
    residual = 0.0
    seen = 0.0
    if choice.bias_variance > 0.0 and has_altitude:
        h, gx, gy, gz = height_and_up(x[0, lane], x[3, lane], x[6, lane], setup.earth)
        g = (gx, gy, gz)
        for i in range(9):
            for a in range(3):
                j = 3 * a
                q[i] += p[max(i, j) * (max(i, j) + 1) // 2 + min(i, j), lane] * g[a]
        seen = gx * q[0] + gy * q[3] + gz * q[6]
        share = choice.bias_variance / setup.altitude_variance
        residual = altitude - h
    for m in range(2):
        for i in range(9):
            bank.x[m, i, lane] = x[i, lane]
            bank.p[m, BIAS + i, lane] = -share * q[i]
        for i in range(45):
            bank.p[m, i, lane] = p[i, lane]
        bank.x[m, 9, lane] = share * residual
        bank.p[m, 54, lane] = choice.bias_variance - share * choice.bias_variance + share * share * seen
        bank.weight[m, lane] = 0.5
    bank.on[lane] = 1


@strict
def predict_bank(choice, bank):
    """Mix and predict both models over `bank.t`; a lane with t = 0 keeps what it has."""
    x0 = bank.x[0].reshape(STATES * LANES)
    x1 = bank.x[1].reshape(STATES * LANES)
    p0 = bank.p[0].reshape(PACKED * LANES)
    p1 = bank.p[1].reshape(PACKED * LANES)
    w0 = bank.weight[0]
    w1 = bank.weight[1]
    # Share of model 1 in what model 0 starts from, and the other way round.
    a = bank.score[0]
    b = bank.score[1]
    for lane in range(LANES):
        t = bank.t[lane]
        go0 = 1.0 - np.exp(-t / choice.stay_cv_s)
        go1 = 1.0 - np.exp(-t / choice.stay_ca_s)
        c0 = w0[lane] - go0 * w0[lane] + go1 * w1[lane]
        c1 = w1[lane] - go1 * w1[lane] + go0 * w0[lane]
        a[lane] = go1 * w1[lane] / c0
        b[lane] = go0 * w0[lane] / c1
        w0[lane] = c0
        w1[lane] = c1
    for i in range(STATES):
        for j in range(i + 1):
            k = (i * (i + 1) // 2 + j) * LANES
            for lane in range(LANES):
                apart = (x1[i * LANES + lane] - x0[i * LANES + lane]) * (x1[j * LANES + lane] - x0[j * LANES + lane])
                u = p0[k + lane]
                v = p1[k + lane]
                p0[k + lane] = u + a[lane] * (v - u) + a[lane] * (1.0 - a[lane]) * apart
                p1[k + lane] = v + b[lane] * (u - v) + b[lane] * (1.0 - b[lane]) * apart
    for i in range(STATES):
        for lane in range(LANES):
            u = x0[i * LANES + lane]
            v = x1[i * LANES + lane]
            x0[i * LANES + lane] = u + a[lane] * (v - u)
            x1[i * LANES + lane] = v + b[lane] * (u - v)
    _stand_still(bank)
    for m in range(2):
        _predict_bias(choice, bank.x[m], bank.p[m], bank.t)
    predict_jerk(bank.x[0, :9], bank.p[0, :45], bank.t, 0.0, 2)
    _disturb(choice, bank)
    predict_jerk(bank.x[1, :9], bank.p[1, :45], bank.t, choice.sigma_jerk, choice.noise_form)


@strict
def _stand_still(bank):
    """Take the acceleration out of the constant-velocity model where time passes."""
    x = bank.x[0]
    p = bank.p[0]
    for i in range(2, 9, 3):
        for lane in range(LANES):
            x[i, lane] = 0.0 if bank.t[lane] > 0.0 else x[i, lane]
    for k in _ACCELERATIONS:
        for lane in range(LANES):
            p[k, lane] = 0.0 if bank.t[lane] > 0.0 else p[k, lane]


@strict
def _disturb(choice, bank):
    """Process noise of the constant-velocity model: an acceleration held over the interval, anew in each.

    Its variance is that of the parameter for marks a second apart. Over longer intervals it grows with them, as the
    manoeuvre's does, whose jerk is white: else the straight flight would be the stiffer beside it the sparser the
    marks, and neither would follow an aircraft that speeds up in its climb. Over shorter ones it grows against them, so
    that the velocity spreads with the time and not with how many marks fell in it.
    """
    p = bank.p[0]
    s = choice.sigma_acceleration * choice.sigma_acceleration
    for a in range(3):
        i = 3 * a
        r0 = i * (i + 1) // 2 + i
        r1 = (i + 1) * (i + 2) // 2 + i
        r2 = (i + 2) * (i + 3) // 2 + i
        for lane in range(LANES):
            t = bank.t[lane]
            v = s * t * t * max(t, 1.0 / max(t, SHORTEST_S))
            p[r0, lane] += 0.25 * v * t * t
            p[r1, lane] += 0.5 * v * t
            p[r1 + 1, lane] += v
            p[r2 + 2, lane] += STILL_VARIANCE if t > 0.0 else 0.0


@strict
def _predict_bias(choice, x, p, times):
    """Let the bias fade and its row follow the motion; before the motion is predicted, as both are linear."""
    for lane in range(LANES):
        t = times[lane]
        fade = np.exp(-t / choice.bias_time_s)
        x[9, lane] *= fade
        for a in range(3):
            i = BIAS + 3 * a
            p[i, lane] = fade * (p[i, lane] + t * (p[i + 1, lane] + 0.5 * t * p[i + 2, lane]))
            p[i + 1, lane] = fade * (p[i + 1, lane] + t * p[i + 2, lane])
            p[i + 2, lane] = fade * p[i + 2, lane]
        p[54, lane] = fade * fade * p[54, lane] + (1.0 - fade * fade) * choice.bias_variance


@strict
def merge_bank(bank, x, p):
    """Merge both models by their moments into the tracks x (9, LANES), p (45, LANES) of the bank's lanes."""
    x0 = bank.x[0]
    x1 = bank.x[1]
    p0 = bank.p[0]
    p1 = bank.p[1]
    w1 = bank.weight[1]
    for i in range(9):
        for j in range(i + 1):
            k = i * (i + 1) // 2 + j
            for lane in range(LANES):
                apart = (x1[i, lane] - x0[i, lane]) * (x1[j, lane] - x0[j, lane])
                value = p0[k, lane] + w1[lane] * (p1[k, lane] - p0[k, lane])
                value += w1[lane] * (1.0 - w1[lane]) * apart
                p[k, lane] = value if bank.on[lane] == 1 else p[k, lane]
    for i in range(9):
        for lane in range(LANES):
            value = x0[i, lane] + w1[lane] * (x1[i, lane] - x0[i, lane])
            x[i, lane] = value if bank.on[lane] == 1 else x[i, lane]
    for lane in range(LANES):
        apart = x1[9, lane] - x0[9, lane]
        bank.bias[0, lane] = x0[9, lane] + w1[lane] * apart
        variance = p0[54, lane] + w1[lane] * (p1[54, lane] - p0[54, lane])
        bank.bias[1, lane] = variance + w1[lane] * (1.0 - w1[lane]) * apart * apart
