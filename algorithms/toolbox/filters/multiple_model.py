"""Multiple-model filters on a block of trials: GPB1, IMM and GPB2 over any list of motion models.

N Kalman filters, one for each model, run side by side; a Markov chain says how the model changes; hypotheses are merged
so that their number stays N. A mark goes through

1. `advance`    transition over each lane's interval and the prediction of every hypothesis
                (`imm`: merge first, then N predictions; `gpb1`: N predictions of the common state; `gpb2`: N^2);
2. `absorb`     one hypothesis takes the mark as a list of uncorrelated scalar rows (the caller makes the rows, at
                `work.x`), which gives its likelihood;
3. `conclude`   probabilities, and the merging of `gpb1` and `gpb2`; lanes that do not take the mark stay as they were;
4. `combine`    the answer: of the most probable model, or the moments of all. It never feeds back into `imm`, `gpb2`.

Everything about probabilities stays in logarithms. This file knows no sensor and no family.

References
----------
trudymai2023, eqs. (1)-(9); blom1988; barshalom2001, sections 11.6.4-11.6.6.

Differences from the paper
--------------------------
Its MMA2 (= `imm`) extrapolates N^2 hypotheses and merges them afterwards; merging first is the same mapping for linear
models (4e-8 m) and the one to use for `ct` and `gd`. (6) calls P[n2][n1] p[n1] conditional; it is the joint one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.filters.merging import MOMENT, copy_hypothesis, log_sum, merge_moments, merge_weights
from algorithms.toolbox.filters.transition import LN_ZERO, Chains, log_transitions
from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.exponential import exponential, logarithm
from algorithms.toolbox.kernels.hypothesis import predict_9, update_9
from algorithms.toolbox.motion.models import (
    CA,
    CT,
    GD,
    known_acceleration,
    noise_coefficients,
    transition_coefficients,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STRUCTURES = ("gpb1", "imm", "gpb2")
"""Names of the structures; a kernel takes the position in this tuple."""
GPB1, IMM, GPB2 = range(3)

LN_2PI = float(np.log(2 * np.pi))


class Bank(NamedTuple):
    """What does not change: the models and how they are merged."""

    kinds: Ints
    """(N,) positions in `models.KINDS`"""
    sigma: Floats
    """(N,) m/s^2, of the step form at the base interval"""
    structure: int
    rule: int
    output_moment: int
    """1 = the answer is the moment merge of all models, 0 = the most probable model's"""
    as_rate: int
    """1 = process noise in the rate form"""
    rate_above_s: float
    """Longer intervals take the rate form in any case."""
    chains: Chains


class Track(NamedTuple):
    """What a block remembers."""

    s: Floats
    """(N, 54, LANES) hypotheses: nine means, then the packed covariance"""
    log: Floats
    """(N, LANES), logarithms of the model probabilities"""
    common: Floats
    """(54, LANES): in `gpb1` what the next mark starts from"""
    lead: Ints
    """(LANES,) the most probable model"""
    boost: Floats
    """(LANES,), factor of every model's sigma"""


class Work(NamedTuple):
    """Room for one mark; H = N hypotheses, N^2 in `gpb2`."""

    s: Floats
    """(H, 54, LANES) predicted, then updated"""
    log: Floats
    """(H, LANES): joint probability before the mark, then with its likelihood"""
    nis: Floats
    likelihood: Floats
    """(H, LANES), ln w"""
    transition: Floats
    """(N, N, LANES), ln P(dt)"""
    known_dt: Floats
    known_region: Ints
    known_boost: Floats
    matrix: Floats
    joint: Floats
    weight: Floats
    """(N, LANES)"""
    total: Floats
    coefficients: Floats
    """(N, 16, LANES) of `predict_9` for each model"""
    stale: Ints
    """(1,) 1 = the intervals or sigmas have changed since the coefficients were computed"""
    as_rate: Floats
    sigma: Floats
    merged: Floats
    """(54, LANES)"""
    evidence: Floats
    """(LANES,), ln of the mark's density"""
    spare: Floats
    """(2, LANES)"""
    share: Floats
    """(N, LANES), model probabilities of the last answer"""


def new_track(models: int) -> Track:
    """Lanes without a track; idle lanes stay harmless."""
    s = np.zeros((models, 54, LANES))
    for i in range(9):
        s[:, place(i, i)] = 1.0
    return Track(
        s=s,
        log=np.full((models, LANES), -np.log(models)),
        common=s[0].copy(),
        lead=np.zeros(LANES, np.int64),
        boost=np.ones(LANES),
    )


def new_work(models: int, structure: int) -> Work:
    """Room for one mark."""
    h = models * models if structure == GPB2 else models
    block = (h, LANES)
    return Work(
        s=np.zeros((h, 54, LANES)),
        log=np.zeros(block),
        nis=np.zeros(block),
        likelihood=np.zeros(block),
        transition=np.zeros((models, models, LANES)),
        known_dt=np.full(LANES, -1.0),
        known_region=np.full(LANES, -1),
        known_boost=np.zeros(LANES),
        matrix=np.zeros((models, models)),
        joint=np.zeros((models, LANES)),
        weight=np.zeros((models, LANES)),
        total=np.zeros(LANES),
        coefficients=np.zeros((models, 16, LANES)),
        stale=np.ones(1, np.int64),
        as_rate=np.zeros(LANES),
        sigma=np.zeros(LANES),
        merged=np.zeros((54, LANES)),
        evidence=np.zeros(LANES),
        spare=np.zeros((2, LANES)),
        share=np.zeros((models, LANES)),
    )


@bare
def place(i, j):
    """Where P[i, j], i >= j, stands in a hypothesis."""
    return 9 + i * (i + 1) // 2 + j


@bare
def start_lane(bank, track, lane, position, covariance, velocity_variance, acceleration_variance):
    """Start every model of a lane from one position (3,) and its packed covariance (6,): nothing is known of the rest.

    `cv` has acceleration 0 with variance 0, `gv` and `gd` the known one; all models are equally probable.
    """
    n = track.log.shape[0]
    for m in range(n):
        for i in range(54):
            track.s[m, i, lane] = 0.0
        carries = bank.kinds[m] == CA or bank.kinds[m] == CT
        for a in range(3):
            track.s[m, 3 * a, lane] = position[a]
            for b in range(a + 1):
                track.s[m, place(3 * a, 3 * b), lane] = covariance[a * (a + 1) // 2 + b]
            track.s[m, place(3 * a + 1, 3 * a + 1), lane] = velocity_variance
            track.s[m, place(3 * a + 2, 3 * a + 2), lane] = acceleration_variance if carries else 0.0
        track.log[m, lane] = -np.log(n)
    track.lead[lane] = 0


@bare
def settle_start(bank, track, work, fresh):
    """After `start_lane`: known accelerations, and the common state of the lanes with fresh = 1."""
    n = track.log.shape[0]
    for m in range(n):
        known_acceleration(bank.kinds[m], track.s[m], work.coefficients[m])
        if bank.kinds[m] != CA and bank.kinds[m] != CT:
            for a in range(3):
                for lane in range(LANES):
                    if fresh[lane] > 0.0:
                        track.s[m, 3 * a + 2, lane] = work.coefficients[m, 13 + a, lane]
    merge_weights(track.log, -1, MOMENT, work.weight, work.total, work.spare)
    merge_moments(track.s, work.weight, work.merged)
    _blend(work.merged, track.common, fresh)


@bare
def _blend(source, target, go):
    """Copy the lanes with go = 1."""
    count = 0.0
    for lane in range(LANES):
        count += go[lane]
    if count == LANES:
        copy_hypothesis(source, target)
        return
    for lane in range(LANES):
        if go[lane] > 0.0:
            for i in range(54):
                target[i, lane] = source[i, lane]


@bare
def _predict(bank, model, s, dt, work, boost):
    """Predict one hypothesis with one model; the coefficients of linear models live as long as the intervals do."""
    kind = bank.kinds[model]
    c = work.coefficients[model]
    if work.stale[0] == 1 or kind in (CT, GD):
        for lane in range(LANES):
            work.sigma[lane] = bank.sigma[model] * boost[lane]
            work.as_rate[lane] = 1.0 if bank.as_rate == 1 or dt[lane] > bank.rate_above_s else 0.0
        known_acceleration(kind, s, c)
        transition_coefficients(kind, dt, s, c)
        noise_coefficients(kind, work.sigma, dt, work.as_rate, bank.chains.step_s, c)
    predict_9(s, c)


@bare
def advance(bank, track, work, dt, region):
    """Move all hypotheses over dt (LANES,) s, in `work`; return the largest clip of a transition power (NaN = none)."""
    n = track.log.shape[0]
    stale = 0
    for lane in range(LANES):
        if dt[lane] != work.known_dt[lane] or track.boost[lane] != work.known_boost[lane]:
            stale = 1
            work.known_boost[lane] = track.boost[lane]
    work.stale[0] = stale
    clip = log_transitions(bank.chains, region, dt, work.known_dt, work.known_region, work.transition, work.matrix)
    for after in range(n):
        for before in range(n):
            for lane in range(LANES):
                value = work.transition[after, before, lane] + track.log[before, lane]
                work.joint[before, lane] = max(value, LN_ZERO)
        if bank.structure == GPB2:
            for before in range(n):
                h = after * n + before
                copy_hypothesis(track.s[before], work.s[h])
                for lane in range(LANES):
                    work.log[h, lane] = work.joint[before, lane]
                _predict(bank, after, work.s[h], dt, work, track.boost)
            continue
        if bank.structure == IMM:
            merge_weights(work.joint, after, bank.rule, work.weight, work.log[after], work.spare)
            merge_moments(track.s, work.weight, work.s[after])
        else:
            log_sum(work.joint, work.log[after], work.spare)
            copy_hypothesis(track.common, work.s[after])
        _predict(bank, after, work.s[after], dt, work, track.boost)
    return clip


@bare
def absorb(work, which, rows, log_volume):
    """Let one hypothesis take the mark.

    rows : (23, LANES) of `update_9`, innovations at the predicted position
    log_volume : (LANES,), what ln det R exceeds the sum of ln variance by (0 unless rows were scaled)
    """
    update_9(work.s[which], rows)
    nis, likelihood, log = work.nis[which], work.likelihood[which], work.log[which]
    for lane in range(LANES):
        count = rows[15, lane] + rows[16, lane] + rows[17, lane]
        value = -0.5 * (rows[18, lane] + logarithm(rows[19, lane]) + log_volume[lane] + count * LN_2PI)
        nis[lane] = rows[18, lane]
        likelihood[lane] = value
        log[lane] = max(log[lane] + value, LN_ZERO)


@bare
def conclude(bank, track, work, go):
    """Take the mark over into the lanes with go = 1: probabilities, states, merging after the mark."""
    n = track.log.shape[0]
    if bank.structure == GPB2:
        for after in range(n):
            first = after * n
            merge_weights(work.log[first : first + n], after, bank.rule, work.weight, work.joint[after], work.spare)
            merge_moments(work.s[first : first + n], work.weight, work.merged)
            _blend(work.merged, track.s[after], go)
    else:
        for m in range(n):
            _blend(work.s[m], track.s[m], go)
            for lane in range(LANES):
                work.joint[m, lane] = work.log[m, lane]
    # Counted from the largest: beside logarithms of -1e12 the sum of all would keep four digits only.
    for lane in range(LANES):
        work.evidence[lane] = work.joint[0, lane]
    for m in range(1, n):
        for lane in range(LANES):
            work.evidence[lane] = max(work.evidence[lane], work.joint[m, lane])
    for m in range(n):
        for lane in range(LANES):
            work.joint[m, lane] -= work.evidence[lane]
    log_sum(work.joint, work.total, work.spare)
    for lane in range(LANES):
        work.evidence[lane] += work.total[lane]
    for m in range(n):
        for lane in range(LANES):
            value = max(work.joint[m, lane] - work.total[lane], LN_ZERO)
            track.log[m, lane] = value if go[lane] > 0.0 else track.log[m, lane]
    if bank.structure == GPB1:
        merge_weights(track.log, -1, bank.rule, work.weight, work.total, work.spare)
        merge_moments(track.s, work.weight, work.merged)
        _blend(work.merged, track.common, go)
    for lane in range(LANES):
        best = 0
        for m in range(1, n):
            if track.log[m, lane] > track.log[best, lane]:
                best = m
        track.lead[lane] = best


@bare
def combine(bank, track, work, out):
    """Write the answer, (54, LANES), and the model probabilities into `work.share`."""
    n = track.log.shape[0]
    for m in range(n):
        for lane in range(LANES):
            work.share[m, lane] = exponential(track.log[m, lane])
    if bank.output_moment == 1:
        merge_moments(track.s, work.share, out)
        return
    if n == 1:
        copy_hypothesis(track.s[0], out)
        return
    for i in range(54):
        for lane in range(LANES):
            out[i, lane] = track.s[track.lead[lane], i, lane]
