"""Interacting constant-velocity and coordinated-turn filters of many tracks side by side.

The state of each model is x, vx, y, vy in m and m/s (x east, y north) and the turn rate w in rad/s, counter-clockwise.
With `constant_velocity` w is 0 and stays so; with `coordinated_turn`

    x' = x + sin(w t)/w vx - (1 - cos(w t))/w vy      vx' = cos(w t) vx - sin(w t) vy
    y' = y + (1 - cos(w t))/w vx + sin(w t)/w vy      vy' = sin(w t) vx + cos(w t) vy

by its first-order expansion, and w walks at random. Both have an acceleration that is constant between plots and drawn
anew at each. The chain of models is given for one antenna period and taken to the power of the periods gone by.

All arrays have tracks first, then models: (T, M), (T, M, 5), (T, M, 5, 5). No sum runs over tracks.

Differences from the paper: the paper has no such filter; this is what is recommended in its place.

References
----------
blom1988; barshalom2001, sections 11.6 and 11.7; specification 9.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STATES = 5
POSITION = np.array([0, 2])
# Below this turn within a step the quotients by w are taken from their series.
SMALL_TURN = 1e-4


@dataclass(frozen=True)
class Motion:
    """What the models allow for.

    Attributes
    ----------
    period_s : of the antenna
    sd_straight, sd_turn : m/s2, acceleration noise of the two models
    sd_turn_rate_step : rad/s, by which w walks in a period
    sd_turn_rate : rad/s, of w at the beginning
    stay : probabilities to stay in each model over a period
    turning : whether there is the second model at all
    """

    period_s: float
    sd_straight: float
    sd_turn: float
    sd_turn_rate_step: float
    sd_turn_rate: float
    stay: tuple[float, float]
    turning: bool = True

    @property
    def models(self) -> int:
        """Number of models."""
        return 2 if self.turning else 1

    @property
    def prior(self) -> Floats:
        """Probabilities of the models of a new track."""
        return np.array([0.8, 0.2]) if self.turning else np.ones(1)


@dataclass
class Bank:
    """Filters of T tracks: x (T, M, 5), p (T, M, 5, 5), mu (T, M)."""

    x: Floats
    p: Floats
    mu: Floats

    def take(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> Bank:
        """Some of the tracks."""
        return Bank(self.x[which], self.p[which], self.mu[which])

    def put(self, which: NDArray[np.int64], other: Bank) -> None:
        """Write other filters into places of these."""
        self.x[which], self.p[which], self.mu[which] = other.x, other.p, other.mu

    def joined(self, other: Bank) -> Bank:
        """Both, the other's behind these."""
        return Bank(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in ("x", "p", "mu")))

    def moments(self) -> tuple[Floats, Floats]:
        """Mean (T, 5) and covariance (T, 5, 5) of the mixture."""
        mean = np.einsum("tm,tmi->ti", self.mu, self.x)
        d = self.x - mean[:, None]
        spread = self.p + d[..., :, None] * d[..., None, :]
        return mean, np.einsum("tm,tmij->tij", self.mu, spread)


def begun(
    first: Floats, second: Floats, r_first: Floats, r_second: Floats, dt: Floats, largest_speed: float, motion: Motion
) -> Bank:
    """Filters of tracks with two plots (T, 2), their covariances (T, 2, 2), dt (T,) s apart.

    The velocity is that between the plots, brought together with what is known before: that no target is faster than
    `largest_speed`, taken for two standard deviations of each component.
    """
    count = dt.size
    x, p = np.zeros((count, STATES)), np.zeros((count, STATES, STATES))
    velocity = (second - first) / dt[:, None]
    moved = 0.25 * motion.sd_turn**2 * dt**2
    spread = (r_first + r_second) / dt[:, None, None] ** 2 + moved[:, None, None] * np.eye(2)
    # Linear combination with the prior N(0, s^2), in the form that needs the inverse of the sum only.
    prior = (largest_speed / 2) ** 2 * np.eye(2)
    gain = prior @ _inverse_2(spread + prior)
    cross = r_second / dt[:, None, None]
    x[:, POSITION], x[:, [1, 3]] = second, np.einsum("tij,tj->ti", gain, velocity)
    rates = POSITION + 1
    both = gain @ cross
    for rows, columns, block in (
        (POSITION, POSITION, r_second),
        (rates, rates, gain @ spread @ gain.swapaxes(1, 2) + _left_over(gain, prior)),
        (rates, POSITION, both),
        (POSITION, rates, both.swapaxes(1, 2)),
    ):
        p[:, rows[:, None], columns] = block
    models = motion.models
    bank = Bank(
        np.repeat(x[:, None], models, axis=1), np.repeat(p[:, None], models, axis=1), np.tile(motion.prior, (count, 1))
    )
    if motion.turning:
        bank.p[:, 1, 4, 4] = motion.sd_turn_rate**2
    return bank


def _left_over(gain: Floats, prior: Floats) -> Floats:
    """What the prior leaves open: (I - G) P0 (I - G)'."""
    rest = np.eye(2) - gain
    out: Floats = rest @ prior @ rest.swapaxes(1, 2)
    return out


def predicted(bank: Bank, dt: Floats, motion: Motion) -> Bank:
    """Mix the models and carry each on by dt (T,) s."""
    x, p, mu = _mixed(bank, dt, motion)
    f = np.zeros((dt.size, motion.models, STATES, STATES))
    f[..., range(STATES), range(STATES)] = 1.0
    f[:, 0, 0, 1] = f[:, 0, 2, 3] = dt[:, None][:, 0]
    f[:, 0, 4, 4] = 0.0
    new = x.copy()
    new[:, 0, 0] += dt * x[:, 0, 1]
    new[:, 0, 2] += dt * x[:, 0, 3]
    new[:, 0, 4] = 0.0
    if motion.turning:
        new[:, 1], f[:, 1] = _turned(x[:, 1], dt)
    carried = f @ p @ f.swapaxes(-1, -2) + _noise(dt, motion)
    return Bank(new, 0.5 * (carried + carried.swapaxes(-1, -2)), mu)


def _mixed(bank: Bank, dt: Floats, motion: Motion) -> tuple[Floats, Floats, Floats]:
    """States and covariances that each model starts from, and the models' probabilities now."""
    if not motion.turning:
        return bank.x, bank.p, bank.mu
    chain = _chain(dt / motion.period_s, motion.stay)
    joint = bank.mu[:, :, None] * chain
    mu = joint.sum(axis=1)
    share = joint / mu[:, None, :]
    x = np.einsum("tij,tik->tjk", share, bank.x)
    d = bank.x[:, :, None] - x[:, None]
    spread = bank.p[:, :, None] + d[..., :, None] * d[..., None, :]
    # Straight flight says nothing of the turn that may follow it.
    spread[:, 0, 1, 4, 4] += motion.sd_turn_rate**2
    p = np.einsum("tij,tijab->tjab", share, spread)
    return x, p, mu


def _chain(periods: Floats, stay: tuple[float, float]) -> Floats:
    """(T, 2, 2) probabilities from a model (row) to another (column) over so many periods."""
    a, b = stay
    rest = 2.0 - a - b
    first = (1.0 - b) / rest if rest > 0 else 0.5
    memory = np.maximum(a + b - 1.0, 0.0) ** periods
    out = np.empty((periods.size, 2, 2))
    out[:, 0, 0] = first + (1.0 - first) * memory
    out[:, 1, 1] = (1.0 - first) + first * memory
    out[:, 0, 1], out[:, 1, 0] = 1.0 - out[:, 0, 0], 1.0 - out[:, 1, 1]
    return out


def _turned(x: Floats, dt: Floats) -> tuple[Floats, Floats]:
    """A coordinated turn (T, 5) and its derivatives (T, 5, 5)."""
    vx, vy, w = x[:, 1], x[:, 3], x[:, 4]
    turn = w * dt
    s, c = np.sin(turn), np.cos(turn)
    small = np.abs(turn) < SMALL_TURN
    safe = np.where(small, 1.0, w)
    a = np.where(small, dt * (1.0 - turn**2 / 6.0), s / safe)
    b = np.where(small, dt * turn / 2.0, (1.0 - c) / safe)
    da = np.where(small, -w * dt**3 / 3.0, (c * dt - a) / safe)
    db = np.where(small, dt**2 / 2.0, (s * dt - b) / safe)
    new = np.stack([x[:, 0] + a * vx - b * vy, c * vx - s * vy, x[:, 2] + b * vx + a * vy, s * vx + c * vy, w], axis=1)
    f = np.zeros((dt.size, STATES, STATES))
    f[:, range(STATES), range(STATES)] = 1.0
    f[:, 0, 1], f[:, 0, 3], f[:, 0, 4] = a, -b, da * vx - db * vy
    f[:, 1, 1], f[:, 1, 3], f[:, 1, 4] = c, -s, -dt * (s * vx + c * vy)
    f[:, 2, 1], f[:, 2, 3], f[:, 2, 4] = b, a, db * vx + da * vy
    f[:, 3, 1], f[:, 3, 3], f[:, 3, 4] = s, c, dt * (c * vx - s * vy)
    return new, f


def _noise(dt: Floats, motion: Motion) -> Floats:
    """(T, M, 5, 5) of an acceleration that is drawn anew in each period, and of the turn rate's walk.

    Over n periods T it gives a place the variance s^2 T^4 (n^3 / 3 - n / 12), a velocity n s^2 T^2, both together
    s^2 T^3 n^2 / 2. Constant over the whole of a gap, it would let a coasting track be anywhere: n^4 / 4.
    """
    n = dt / motion.period_s
    long = n >= 1.0
    step = np.where(long, 1.0, n)
    rest = np.where(long, n, 1.0)
    t = motion.period_s * step
    block = np.empty((dt.size, 2, 2))
    block[:, 0, 0] = t**4 * (rest**3 / 3.0 - rest / 12.0)
    block[:, 1, 1] = t**2 * rest
    block[:, 0, 1] = block[:, 1, 0] = t**3 * rest**2 / 2.0
    out = np.zeros((dt.size, motion.models, STATES, STATES))
    for m, sd in enumerate((motion.sd_straight, motion.sd_turn)[: motion.models]):
        out[:, m, 0:2, 0:2] = out[:, m, 2:4, 2:4] = sd**2 * block
    if motion.turning:
        out[:, 1, 4, 4] = motion.sd_turn_rate_step**2 * dt / motion.period_s
    return out


def updated(bank: Bank, z: Floats, r: Floats) -> Bank:
    """Each track with its one measurement z (T, 2) m of covariance r (T, 2, 2)."""
    one = np.ones((z.shape[0], 1))
    return updated_by_many(bank, z[:, None], r[:, None], one, 0.0 * one[:, 0])


def updated_by_many(bank: Bank, z: Floats, r: Floats, beta: Floats, none: Floats) -> Bank:
    """Each track with K possible measurements z (T, K, 2), r (T, K, 2, 2), their probabilities beta, and `none` (T,).

    All possible measurements of a track share the mean covariance: they come from one radar and lie close together.
    Probabilistic data association of each model; a model's likelihood is the sum of those of the measurements under
    it, each relative to the mixture's, so that what the association has decided is not counted twice.
    """
    nu = z[:, None] - bank.x[:, :, None, POSITION]
    total = np.maximum(beta.sum(axis=1), 1e-300)
    mean_r = np.einsum("tk,tkij->tij", beta / total[:, None], r)
    across = bank.p[:, :, :, POSITION]
    s = across[:, :, POSITION] + mean_r[:, None]
    inverse = _inverse_2(s)
    gain = across @ inverse
    log_likelihood = (
        -0.5 * np.einsum("tmki,tmij,tmkj->tmk", nu, inverse, nu) - 0.5 * np.log(_determinant_2(s))[..., None]
    )
    combined = np.einsum("tk,tmki->tmi", beta, nu)
    x = bank.x + np.einsum("tmij,tmj->tmi", gain, combined)
    second = np.einsum("tk,tmki,tmkj->tmij", beta, nu, nu) - combined[..., :, None] * combined[..., None, :]
    inside = (1.0 - none)[:, None, None, None] * s - second
    p = bank.p - gain @ inside @ gain.swapaxes(-1, -2)
    # Under the mixture, for each measurement; what no model explains keeps its weights.
    top = log_likelihood.max(axis=1, keepdims=True)
    relative = np.exp(log_likelihood - top)
    relative /= np.einsum("tm,tmk->tk", bank.mu, relative)[:, None]
    weight = none[:, None] + np.einsum("tk,tmk->tm", beta, relative)
    mu = bank.mu * weight
    mu /= mu.sum(axis=1, keepdims=True)
    return Bank(x, 0.5 * (p + p.swapaxes(-1, -2)), mu)


def _determinant_2(m: Floats) -> Floats:
    out: Floats = m[..., 0, 0] * m[..., 1, 1] - m[..., 0, 1] * m[..., 1, 0]
    return out


def _inverse_2(m: Floats) -> Floats:
    """Inverses of 2 by 2 matrices."""
    out = np.empty_like(m)
    out[..., 0, 0], out[..., 1, 1] = m[..., 1, 1], m[..., 0, 0]
    out[..., 0, 1], out[..., 1, 0] = -m[..., 0, 1], -m[..., 1, 0]
    inverse: Floats = out / _determinant_2(m)[..., None, None]
    return inverse
