"""Which receiver disagrees with the others: a test on the residuals of redundant marks.

Linearise each mark at its own solution: whitened residuals y = G b + e with the unknowns b = (position, emission time)
and rows g_i = (u_i, 1) / sigma_i, the altitude as one more row. What the solution leaves is M y with the projector
M = I - G (G^T G)^-1 G^T. If receiver j is late by d, or stands elsewhere than its site says by delta, the residuals
carry M[:, j] (d, or -u . delta) / sigma_j. By least squares over all marks that j heard

    delay:    d = sum(m_j) / sum(M_jj),                 chi2 = d^2 sum(M_jj)
    place:    delta from sum(M_jj u u^T), sum(u m_j),   chi2 likewise

(m_j the j-th component of M y, both in metres). A decoded altitude differs from the height by a bias that is common to
all marks and would be laid at a receiver's door; it is estimated with the fault, with a prior of 300 m, and a receiver
must explain what the bias alone does not (Schur complement of the joint normal equations).

A fault of one receiver leaks into the residuals of all, but by the Cauchy-Schwarz inequality the largest chi2 belongs
to the one that has it - as long as the fault is small enough for the linearisation. Receivers whose chi2 comes near
the largest are therefore tried in earnest: each is corrected, the marks are solved again, and the one whose correction
explains most is named, if chi2 is beyond chance and the effect large against the timing error. Then the test is
repeated without it.

The marks are solved without the residual gate, since the marks of a bad receiver are just those that fail it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.conditions import Conditions, conditions_of, toa_of
from algorithms.multilateration.fixes import solve_recording
from algorithms.multilateration.parameters import AltitudeParameters
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
# How far a receiver may stand off, m: keeps the height, which hardly shows, from running away.
PLACE_PRIOR_M = 3_000.0
# Pressure altitude against height: how large a common bias may be.
BIAS_PRIOR_M = 300.0
LARGEST_CONDITION = 1e13
# Marks looked at; more would not change the answer.
MOST_MARKS = 20_000
LEAST_REDUNDANCY = 1e-6
# Receivers whose chi2 reaches this share of the largest are corrected in turn, at most so many, so many times each.
NEAR_SHARE = 0.2
MOST_TRIED = 4
CORRECTIONS = 3
# A mark with a residual beyond this is wild: a late reception. A receiver's own fault shows in all its marks; where
# fewer than this share of them are wild, the wild ones are somebody's outliers and tell nothing about it.
WILD_RATIO = 10.0
FEW_WILD = 0.2
# A residual counts up to this many standard deviations when corrections are compared.
RATIO_CAP = 10.0
TOO_FEW = "too few to tell"
NO_REDUNDANCY = "its marks have no redundancy"


@dataclass(frozen=True)
class Assessment:
    """Verdict on one receiver: True, False, or None with the reason why there is none."""

    suspect: bool | None
    reason: str | None


@dataclass(frozen=True)
class _Left:
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
class _Fault:
    """What is wrong with a receiver: it is late, or it stands elsewhere."""

    station: int
    chi2: float
    effect_m: float
    delay_m: float
    displacement_m: Floats
    bias_m: float = 0.0
    """Bias of the altitude that goes with it."""

    @property
    def words(self) -> str:
        if self.delay_m:
            word = "late" if self.delay_m > 0 else "early"
            return f"{word} by {abs(self.delay_m) / SPEED_OF_LIGHT_MPS * 1e9:.0f} ns ({abs(self.delay_m):.0f} m)"
        east, north = self.displacement_m[0], self.displacement_m[1]
        return f"as if it stood {np.hypot(east, north):.0f} m away (east {east:+.0f} m, north {north:+.0f} m)"


def assess_receivers(recording: ToaMarks, parameters: AltitudeParameters) -> list[Assessment]:
    """Judge every receiver of a recording (its first trial), in the order of its stations."""
    conditions = conditions_of(recording, parameters, with_altitude=True)
    # The marks of a bad receiver are those that gate and spread would reject.
    conditions = replace(conditions, residual_gate_m=1e9, spread_limit=np.full_like(conditions.spread_limit, 1e12))
    toa = toa_of(recording, conditions)[:, :, :1].copy()
    altitude = np.ascontiguousarray(recording.altitude_m[:, :1])
    count = np.isfinite(toa[:, :, 0]).sum(axis=0)
    verdicts = [Assessment(False, None) if n >= FEWEST_RECEPTIONS else Assessment(None, TOO_FEW) for n in count]
    if len(recording) > MOST_MARKS:
        chosen = np.linspace(0, len(recording) - 1, MOST_MARKS).astype(np.int64)
        recording, toa, altitude = recording.take(chosen), toa[chosen], altitude[chosen]
    left = _what_is_left(recording, conditions, toa, altitude)
    open_cases = [int(j) for j in np.flatnonzero(count >= FEWEST_RECEPTIONS)]
    while open_cases:
        faults = _faults(left, conditions, open_cases)
        if not faults:
            break
        worst = _most_convincing(faults, recording, conditions, toa, altitude)
        verdicts[worst.station] = Assessment(True, worst.words)
        open_cases.remove(worst.station)
        toa[:, worst.station] = np.nan
        left = _what_is_left(recording, conditions, toa, altitude)
    redundant = (left.heard & (left.redundancy > LEAST_REDUNDANCY)).sum(axis=0)
    for j in open_cases:
        if redundant[j] < FEWEST_RECEPTIONS:
            verdicts[j] = Assessment(None, NO_REDUNDANCY)
    return verdicts


def _what_is_left(recording: ToaMarks, conditions: Conditions, toa_s: Floats, altitude_m: Floats) -> _Left:
    solved = solve_recording(recording, conditions, toa_s, altitude_m, LocalContext())
    position = solved["state"][:, [0, 3, 6], 0].astype(float)
    both = solved["roots_m"][:, 0, :, 0].astype(float)
    position = np.where(np.isfinite(position), position, both)
    keep = np.isfinite(position).all(axis=1)
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
    return _Left(
        heard,
        e[:, :-1] * sigma,
        redundancy[:, :-1],
        u,
        np.where(known, e[:, -1], 0.0) * conditions.sigma_altitude_m,
        np.where(known, redundancy[:, -1], 0.0),
        np.where(known[:, None], shared, 0.0),
        conditions.sigma_altitude_m,
    )


def _faults(left: _Left, conditions: Conditions, open_cases: list[int]) -> list[_Fault]:
    """Return the faults that would explain the residuals beyond chance, the best explanation first."""
    ratio = left.ratio(conditions)
    if not ratio.size:
        return []
    # Real receptions scatter more than their sigma says: the median of all tells by how much.
    noise2 = max(float(np.median(np.abs(ratio)) / 0.6745) ** 2, 1.0)
    found = [f for j in open_cases if (f := _fault(left, conditions, j, noise2)) is not None]
    sigma = np.sqrt(conditions.variance)
    found = [f for f in found if f.chi2 > LEAST_CHI2 and f.effect_m > LEAST_EFFECT_IN_SIGMA * sigma[f.station]]
    return sorted(found, key=lambda f: -f.chi2)


def _fault(left: _Left, conditions: Conditions, j: int, noise2: float) -> _Fault | None:
    """Least squares for the delay and for the displacement of one receiver: the better explanation of the two."""
    rows = left.heard[:, j] & (left.redundancy[:, j] > LEAST_REDUNDANCY)
    wild = left.wild(conditions, noise2)
    if rows.any() and wild[rows].mean() < FEW_WILD:
        rows &= ~wild
    m, e, u = left.redundancy[rows, j], left.residual_m[rows, j], left.direction[rows, j]
    if rows.sum() < FEWEST_RECEPTIONS:
        return None
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
    if chi2_moved - PLACE_MARGIN > chi2_late:
        effect = float(np.sqrt(np.mean((u @ moved) ** 2)))
        return _Fault(j, chi2_moved - PLACE_MARGIN, effect, 0.0, -moved, bias_moved)
    return _Fault(j, chi2_late, abs(float(late[0])), float(late[0]), np.zeros(3), bias_late)


def _most_convincing(
    faults: list[_Fault], recording: ToaMarks, conditions: Conditions, toa_s: Floats, altitude_m: Floats
) -> _Fault:
    """Correct each fault that comes near the largest, solve again, and return the one that then leaves least."""
    near = [f for f in faults if f.chi2 > NEAR_SHARE * faults[0].chi2][:MOST_TRIED]
    if len(near) == 1:
        return near[0]
    left_over: list[tuple[float, int, _Fault]] = []
    for order, first in enumerate(near):
        fault = first
        for _ in range(CORRECTIONS):
            corrected = toa_s.copy()
            corrected[:, fault.station] -= fault.delay_m / SPEED_OF_LIGHT_MPS
            places = conditions.stations.copy()
            places[fault.station] += fault.displacement_m
            height = altitude_m - fault.bias_m
            left = _what_is_left(recording, replace(conditions, stations=places), corrected, height)
            rest = _fault(left, conditions, fault.station, 1.0)
            cost = float(np.mean(np.minimum(np.abs(left.ratio(conditions)), RATIO_CAP)))
            left_over.append((cost, order, fault))
            if rest is None:
                break
            further = rest.delay_m if fault.delay_m else 0.0
            elsewhere = rest.displacement_m if not fault.delay_m else np.zeros(3)
            fault = replace(
                fault,
                delay_m=fault.delay_m + further,
                displacement_m=fault.displacement_m + elsewhere,
                bias_m=fault.bias_m + rest.bias_m,
            )
    return min(left_over, key=lambda item: item[:2])[2]
