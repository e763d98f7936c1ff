"""Which receiver disagrees with the others: a test on the residuals of redundant marks.

Linearise each mark at its own solution: whitened residuals y = G b + e with the unknowns b = (position, emission time)
and rows g_i = (u_i, 1) / sigma_i, the altitude as one more row. What the solution leaves is M y with the projector
M = I - G (G^T G)^-1 G^T. If receiver j is late by d, or stands elsewhere than its site says by delta, the residuals
carry M[:, j] (d, or -u . delta) / sigma_j. By least squares over all marks that j heard

    delay:    d = sum(m_j) / sum(M_jj),                 chi2 = d^2 sum(M_jj)
    drift:    d + e t from sum(M_jj (1, t)(1, t)^T), sum((1, t) m_j), chi2 likewise
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
from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.receiver_faults import (
    FEWEST_RECEPTIONS,
    LEAST_REDUNDANCY,
    RATIO_CAP,
    Fault,
    Left,
    explanations,
    faults_of,
    what_is_left,
)
from algorithms.recording import ToaMarks
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]

# Marks looked at; more would not change the answer.
MOST_MARKS = 20_000
# Explanations whose chi2 reaches this share of the largest are corrected in turn, at most so many, so many times each,
# in so many marks. A fault of kilometres takes that many: far off, the marks' own solutions are wrong too.
NEAR_SHARE = 0.2
MOST_TRIED = 10
CORRECTIONS = 8
SETTLED = 1e-3
MARKS_TRIED = 2_000
# Another receiver whose correction leaves no more than this many times as much cannot be told from the one named.
AS_GOOD = 1.1
# The best correction must leave so little, in standard deviations (0.8 where all is right), or this share of what there
# was. One that does not has found nothing: it explains the residuals away and names the wrong receiver.
LEAST_LEFT = 3.0
LEAST_SHARE = 0.4
# Where so many marks are wild and nobody was found, somebody is wrong all the same.
MANY_WILD = 0.5
TOO_FEW = "too few to tell"
NO_REDUNDANCY = "its marks have no redundancy"
DISAGREE = "the marks disagree, and no fault of one receiver explains it"


@dataclass(frozen=True)
class Assessment:
    """Verdict on one receiver: True, False, or None with the reason why there is none."""

    suspect: bool | None
    reason: str | None
    kind: str | None = None
    """Of a suspect: position, clock_offset or clock_drift"""


@dataclass(frozen=True)
class Judged:
    """Verdicts on all receivers, in the order of the stations, and what they rest on.

    Attributes
    ----------
    left : of each receiver the solutions in which it is heard and those named before it are not
    without : of each receiver that is named, the solutions without it
    """

    verdicts: list[Assessment]
    left: list[Left]
    without: dict[int, Left]
    conditions: Conditions
    truth_m: Floats
    """(M, 3) of the marks that were looked at"""


def assess_receivers(recording: ToaMarks, parameters: AltitudeParameters) -> list[Assessment]:
    """Judge every receiver of a recording (its first trial), in the order of its stations."""
    return judge_receivers(recording, parameters).verdicts


def judge_receivers(recording: ToaMarks, parameters: AltitudeParameters) -> Judged:
    """Judge every receiver of a recording (its first trial), and keep what the verdicts rest on."""
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
    left = what_is_left(recording, conditions, toa, altitude)
    heard_in: dict[int, Left] = {}
    without: dict[int, Left] = {}
    open_cases = [int(j) for j in np.flatnonzero(count >= FEWEST_RECEPTIONS)]
    while open_cases:
        faults = faults_of(left, conditions, open_cases)
        if not faults:
            break
        worst, others, left_ratio = _most_convincing(faults, recording, conditions, toa, altitude)
        if left_ratio > max(LEAST_LEFT, LEAST_SHARE * _mean_ratio(left, conditions)):
            break
        words = worst.words
        if others:
            names = ", ".join(recording.stations[j] for j in others)
            words += f"; a fault of {names} would explain it as well"
        verdicts[worst.station] = Assessment(True, words, worst.kind)
        open_cases.remove(worst.station)
        toa[:, worst.station] = np.nan
        heard_in[worst.station] = left
        left = without[worst.station] = what_is_left(recording, conditions, toa, altitude)
    redundant = (left.heard & (left.redundancy > LEAST_REDUNDANCY)).sum(axis=0)
    for j in open_cases:
        if redundant[j] < FEWEST_RECEPTIONS:
            verdicts[j] = Assessment(None, NO_REDUNDANCY)
    if _disagrees(left, conditions, toa, altitude):
        for j in open_cases:
            verdicts[j] = Assessment(None, DISAGREE)
    return Judged(
        verdicts, [heard_in.get(j, left) for j in range(len(verdicts))], without, conditions, recording.truth_m
    )


def _most_convincing(
    faults: list[Fault], recording: ToaMarks, conditions: Conditions, toa_s: Floats, altitude_m: Floats
) -> tuple[Fault, tuple[int, ...], float]:
    """Correct each fault that comes near the largest, solve again, and return the one that then leaves least, the other
    receivers whose correction leaves hardly more, and how much it leaves, in standard deviations.
    """
    near = [f for f in faults if f.chi2 > NEAR_SHARE * faults[0].chi2][:MOST_TRIED]
    if len(recording) > MARKS_TRIED:
        some = np.linspace(0, len(recording) - 1, MARKS_TRIED).astype(np.int64)
        recording, toa_s, altitude_m = recording.take(some), toa_s[some], altitude_m[some]
    left_over: list[tuple[float, int, Fault]] = []
    for order, first in enumerate(near):
        fault = first
        for _ in range(CORRECTIONS):
            left = _corrected(fault, recording, conditions, toa_s, altitude_m)
            cost = _mean_ratio(left, conditions)
            if left_over and left_over[-1][1] == order and abs(left_over[-1][0] - cost) < SETTLED * cost:
                break
            left_over.append((cost, order, fault))
            more = [f for f in explanations(left, conditions, fault.station, 1.0) if f.kind == fault.kind]
            if not more:
                break
            fault = fault.with_more(more[0])
    best = min(left_over, key=lambda item: item[:2])
    others = {f.station for cost, _, f in left_over if cost <= AS_GOOD * best[0]} - {best[2].station}
    return best[2], tuple(sorted(others)), best[0]


def _disagrees(left: Left, conditions: Conditions, toa_s: Floats, altitude_m: Floats) -> bool:
    """Whether most marks that could contradict themselves do, or have no solution at all."""
    data = np.isfinite(toa_s[:, :, 0]).sum(axis=1) + np.isfinite(altitude_m[:, 0])
    redundant = np.flatnonzero(data > 4)
    if redundant.size < FEWEST_RECEPTIONS:
        return False
    wild = left.wild(conditions, 1.0).sum() + np.setdiff1d(redundant, left.row).size
    return bool(wild > MANY_WILD * redundant.size)


def _mean_ratio(left: Left, conditions: Conditions) -> float:
    """Mean residual in standard deviations, wild ones counted as ten; infinite where no mark can be solved."""
    ratio = left.ratio(conditions)
    return float(np.mean(np.minimum(np.abs(ratio), RATIO_CAP))) if ratio.size else np.inf


def _corrected(fault: Fault, recording: ToaMarks, conditions: Conditions, toa_s: Floats, altitude_m: Floats) -> Left:
    """What is left where the fault is undone."""
    corrected = toa_s.copy()
    corrected[:, fault.station] -= fault.delay_at(recording.time_s)[:, None] / SPEED_OF_LIGHT_MPS
    places = conditions.stations.copy()
    places[fault.station] += fault.displacement_m
    return what_is_left(recording, replace(conditions, stations=places), corrected, altitude_m - fault.bias_m)
