"""What is wrong with a receiver, from what the solutions of redundant marks leave: the least squares of `receivers`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.conditions import Conditions
from algorithms.multilateration.fixes import solve_recording
from algorithms.recording import ToaMarks
from algorithms.spec import LocalContext
from algorithms.toolbox.frames.earth import altitude_from_position, up_from_position
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]

FEWEST_RECEPTIONS = 50
# The fault must be this many times larger than the timing error (135 m at 90 ns, 15 m at 10 ns) ...
LEAST_EFFECT_IN_SIGMA = 5.0
# ... and this far beyond chance; a receiver without fault stays below 15 in 999 of 1,000 recordings.
LEAST_CHI2 = 60.0
# A displaced receiver has two more unknowns than a late one: it must explain this much more to be preferred.
PLACE_MARGIN = 6.0
# A drifting clock has one more. That of a good clock must stay unnamed, so this is well beyond chance.
DRIFT_MARGIN = 12.0
# How far a receiver may stand off, m: keeps the height, which hardly shows, from running away.
PLACE_PRIOR_M = 3_000.0
# Pressure altitude against height: how large a common bias may be.
BIAS_PRIOR_M = 300.0
LARGEST_CONDITION = 1e13
LEAST_REDUNDANCY = 1e-6
# A mark with a residual beyond this is wild: a late reception. A receiver's own fault shows in all its marks; where
# fewer than this share of them are wild, the wild ones are somebody's outliers and tell nothing about it.
WILD_RATIO = 10.0
FEW_WILD = 0.2
# A residual counts up to this many standard deviations when corrections are compared.
RATIO_CAP = 10.0


@dataclass(frozen=True)
class Left:
    """What the solutions of the marks leave, receiver by receiver."""

    heard: NDArray[np.bool_]
    """(M, S)"""
    residual_m: Floats
    """(M, S), component of M y in metres"""
    redundancy: Floats
    """(M, S), M_jj"""
    direction: Floats
    """(M, S, 3), u"""
    altitude_residual_m: Floats
    """(M,), the altitude's component of M y in metres; 0 where none is known"""
    altitude_redundancy: Floats
    """(M,), its diagonal element of M"""
    shared: Floats
    """(M, S), element of M between receiver and altitude"""
    sigma_altitude_m: float
    time_s: Floats
    """(M,)"""
    row: NDArray[np.int64]
    """(M,), which marks of the recording these are"""
    position_m: Floats
    """(M, 3), their solutions"""

    def ratio(self, conditions: Conditions) -> Floats:
        """Residuals in units of their standard deviation, one after another."""
        use = self.heard & (self.redundancy > LEAST_REDUNDANCY)
        sigma = np.sqrt(np.maximum(self.redundancy, LEAST_REDUNDANCY) * conditions.variance)
        return np.asarray((self.residual_m / sigma)[use])

    def wild(self, conditions: Conditions, noise2: float) -> NDArray[np.bool_]:
        """(M,): marks with a residual that is beyond chance, the noise being so many times the declared one."""
        use = self.heard & (self.redundancy > LEAST_REDUNDANCY)
        sigma2 = np.maximum(self.redundancy, LEAST_REDUNDANCY) * conditions.variance * noise2
        return np.asarray(((self.residual_m**2 / sigma2 > WILD_RATIO**2) & use).any(axis=1))


@dataclass(frozen=True)
class Fault:
    """What is wrong with a receiver: it is late, drifts, or stands elsewhere."""

    station: int
    chi2: float
    effect_m: float
    delay_m: float
    displacement_m: Floats
    bias_m: float = 0.0
    """Bias of the altitude that goes with it."""
    drift_mps: float = 0.0
    """How fast the delay grows; `delay_m` is that of the instant `middle_s`."""
    middle_s: float = 0.0

    @property
    def kind(self) -> str:
        """What is wrong with it, as a word that stays."""
        return "clock_drift" if self.drift_mps else "clock_offset" if self.delay_m else "position"

    def with_more(self, more: Fault) -> Fault:
        """The same kind of fault, with what another look at the corrected marks adds."""
        middle = self.middle_s or more.middle_s
        return replace(
            self,
            delay_m=self.delay_m + float(more.delay_at(np.array([middle]))[0]),
            drift_mps=self.drift_mps + more.drift_mps,
            displacement_m=self.displacement_m + more.displacement_m,
            bias_m=self.bias_m + more.bias_m,
        )

    def delay_at(self, time_s: Floats) -> Floats:
        """(M,) m"""
        return self.delay_m + self.drift_mps * (time_s - self.middle_s)

    @property
    def words(self) -> str:
        """What is wrong, for people."""
        if self.drift_mps:
            word = "late" if self.delay_m > 0 else "early"
            rate = self.drift_mps / SPEED_OF_LIGHT_MPS * 1e9 * 60
            late = abs(self.delay_m) / SPEED_OF_LIGHT_MPS * 1e9
            return f"its clock drifts by {rate:+.3g} ns a minute; {word} by {late:.0f} ns in the middle"
        if self.delay_m:
            word = "late" if self.delay_m > 0 else "early"
            return f"{word} by {abs(self.delay_m) / SPEED_OF_LIGHT_MPS * 1e9:.0f} ns ({abs(self.delay_m):.0f} m)"
        east, north = self.displacement_m[0], self.displacement_m[1]
        return f"as if it stood {np.hypot(east, north):.0f} m away (east {east:+.0f} m, north {north:+.0f} m)"


def what_is_left(
    recording: ToaMarks,
    conditions: Conditions,
    toa_s: Floats,
    altitude_m: Floats,
) -> Left:
    """Solve every mark by itself and keep what its receptions leave."""
    solved = solve_recording(recording, conditions, toa_s, altitude_m, LocalContext())
    position = solved["state"][:, [0, 3, 6], 0].astype(float)
    both = solved["roots_m"][:, 0, :, 0].astype(float)
    position = np.where(np.isfinite(position), position, both)
    keep = np.isfinite(position).all(axis=1)
    row = np.flatnonzero(keep)
    position, z, height = position[keep], SPEED_OF_LIGHT_MPS * toa_s[keep, :, 0], altitude_m[keep, 0]
    heard, known = np.isfinite(z), np.isfinite(height)
    sigma = np.sqrt(conditions.variance)
    d = position[:, None] - conditions.stations
    r = np.linalg.norm(d, axis=2)
    u = d / np.maximum(r, 1.0)[:, :, None]
    g = np.concatenate([u, np.ones((*heard.shape, 1))], axis=2) / sigma[:, None] * heard[:, :, None]
    y = np.where(heard, (np.nan_to_num(z) - r) / sigma, 0.0)
    up = up_from_position(position, conditions.earth) / conditions.sigma_altitude_m
    above = (np.nan_to_num(height) - altitude_from_position(position, conditions.earth)) / conditions.sigma_altitude_m
    g = np.concatenate([g, (np.pad(up, ((0, 0), (0, 1))) * known[:, None])[:, None]], axis=1)
    y = np.concatenate([y, np.where(known, above, 0.0)[:, None]], axis=1)
    normal = np.einsum("mia,mib->mab", g, g)
    sound = np.linalg.cond(normal) < LARGEST_CONDITION
    g, y, normal, heard, u = g[sound], y[sound], normal[sound], heard[sound], u[sound]
    k = np.linalg.solve(normal, np.swapaxes(g, 1, 2))
    e = y - np.einsum("mia,ma->mi", g, np.einsum("mai,mi->ma", k, y))
    redundancy = 1.0 - np.einsum("mia,mai->mi", g, k)
    shared = -np.einsum("mia,ma->mi", g, k[:, :, -1])[:, :-1]
    known = known[sound]
    return Left(
        heard,
        e[:, :-1] * sigma,
        redundancy[:, :-1],
        u,
        np.where(known, e[:, -1], 0.0) * conditions.sigma_altitude_m,
        np.where(known, redundancy[:, -1], 0.0),
        np.where(known[:, None], shared, 0.0),
        conditions.sigma_altitude_m,
        recording.time_s[row][sound],
        row[sound],
        position[sound],
    )


def faults_of(left: Left, conditions: Conditions, open_cases: list[int]) -> list[Fault]:
    """Return the faults that would explain the residuals beyond chance, the best explanation first."""
    ratio = left.ratio(conditions)
    if not ratio.size:
        return []
    # Real receptions scatter more than their sigma says: the median of all tells by how much. Beyond this it is no
    # noise.
    noise2 = min(max(float(np.median(np.abs(ratio)) / 0.6745), 1.0), WILD_RATIO) ** 2
    found = [fault for j in open_cases for fault in explanations(left, conditions, j, noise2)]
    sigma = np.sqrt(conditions.variance)
    found = [f for f in found if f.chi2 > LEAST_CHI2 and f.effect_m > LEAST_EFFECT_IN_SIGMA * sigma[f.station]]
    return sorted(found, key=lambda f: -f.chi2)


def explanations(left: Left, conditions: Conditions, j: int, noise2: float) -> list[Fault]:
    """Least squares for the delay, the drift and the displacement of one receiver; the best explanation first."""
    rows = left.heard[:, j] & (left.redundancy[:, j] > LEAST_REDUNDANCY)
    wild = left.wild(conditions, noise2)
    if rows.any() and wild[rows].mean() < FEW_WILD:
        rows &= ~wild
    m, e, u = left.redundancy[rows, j], left.residual_m[rows, j], left.direction[rows, j]
    if rows.sum() < FEWEST_RECEPTIONS:
        return []
    sigma, sigma_h = float(np.sqrt(conditions.variance[j])), left.sigma_altitude_m
    # Normal equations of the altitude's bias, and what they share with those of the receiver.
    known = ~wild if wild.mean() < FEW_WILD else np.ones_like(wild)
    bias_score = float(left.altitude_residual_m[known].sum()) / sigma_h**2
    bias_fisher = float(left.altitude_redundancy[known].sum()) / sigma_h**2 + 1.0 / BIAS_PRIOR_M**2
    shared = left.shared[rows, j] / (sigma * sigma_h)

    def solved(fisher: Floats, score: Floats, cross: Floats) -> tuple[Floats, float, float]:
        """Solution beside the bias, its chi2 beyond the bias alone, and the bias."""
        fisher = fisher - np.outer(cross, cross) / bias_fisher
        score = score - cross * bias_score / bias_fisher
        x: Floats = np.linalg.solve(fisher, score).astype(float)
        return x, float(score @ x) / noise2, float(bias_score - cross @ x) / bias_fisher

    late, chi2_late, bias_late = solved(
        np.array([[m.sum()]]) / sigma**2 + 1e-12, np.array([e.sum()]) / sigma**2, np.array([shared.sum()])
    )
    moved, chi2_moved, bias_moved = solved(
        np.einsum("m,ma,mb->ab", m, u, u) / sigma**2 + np.eye(3) * noise2 / PLACE_PRIOR_M**2,
        np.einsum("ma,m->a", u, e) / sigma**2,
        np.einsum("ma,m->a", u, shared),
    )
    middle = float(left.time_s[rows].mean())
    # In units of the recording's length, so that both unknowns are of one size.
    length = max(float(np.ptp(left.time_s[rows])), 1.0)
    since = np.stack([np.ones(rows.sum()), (left.time_s[rows] - middle) / length], axis=1)
    drifting, chi2_drift, bias_drift = solved(
        np.einsum("m,ma,mb->ab", m, since, since) / sigma**2 + 1e-12 * np.eye(2),
        np.einsum("ma,m->a", since, e) / sigma**2,
        np.einsum("ma,m->a", since, shared),
    )
    found = [
        Fault(j, chi2_late, abs(float(late[0])), float(late[0]), np.zeros(3), bias_late),
        Fault(
            j, chi2_moved - PLACE_MARGIN, float(np.sqrt(np.mean((u @ moved) ** 2))), 0.0, -moved, bias_moved,
        ),
        Fault(
            j, chi2_drift - DRIFT_MARGIN, float(np.sqrt(np.mean((since @ drifting) ** 2))), float(drifting[0]),
            np.zeros(3), bias_drift, float(drifting[1]) / length, middle,
        ),
    ]  # fmt: skip
    return sorted(found, key=lambda fault: -fault.chi2)
