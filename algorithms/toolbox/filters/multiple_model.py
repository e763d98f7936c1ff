"""Multiple-model filters on a block of trials: GPB1, IMM and GPB2 over any list of motion models.

N Kalman filters, one for each model, run side by side; a Markov chain says how the model changes; hypotheses are merged
so that their number stays N. A mark goes through

1. `advance`    transition over each lane's interval and the prediction of every hypothesis
                (`imm`: merge first, then N predictions; `gpb1`: N predictions of the common state; `gpb2`: N^2);
2. `absorb`     one hypothesis takes the mark as a list of uncorrelated scalar rows (the caller makes the rows, at
                `work.x`), which gives its likelihood;
3. `conclude`   probabilities, and the merging of `gpb1` and `gpb2`; lanes that do not take the mark stay as they were;
4. `combine`    the answer: of the most probable model, or the moments of all. It never feeds back into `imm`, `gpb2`.

What is remembered of probabilities are logarithms. Beside them stand the probabilities themselves, of which joint ones
are products: exponentials are taken once a mark. Where a sum of products is so small that what was lost below e^-700
might count, its lane is done again in logarithms. This file knows no sensor and no family.

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

from algorithms.toolbox.filters.merging import (
    MOMENT,
    choose_weights,
    copy_hypothesis,
    exponents,
    merge_moments,
    merge_positions_and_velocities,
    merge_weights,
    stands_alone,
)
from algorithms.toolbox.filters.transition import LN_ZERO, Chains, transitions
from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.exponential import logarithm
from algorithms.toolbox.kernels.flat import woven
from algorithms.toolbox.kernels.hypothesis import predict_6, predict_9, predict_turn_9, update_6, update_9
from algorithms.toolbox.motion.models import (
    CA,
    CT,
    GD,
    known_acceleration,
    knows_acceleration,
    noise_coefficients,
    transition_coefficients,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STRUCTURES = ("gpb1", "imm", "gpb2")
"""Names of the structures; a kernel takes the position in this tuple."""
GPB1, IMM, GPB2 = range(3)

LN_2PI = float(np.log(2 * np.pi))
SMALLEST_SUM = 1e-280
"""Probabilities below e^-700 are not told from zero; beside a sum of at least this much that is nothing."""


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
    share: Floats
    """(N, LANES), the probabilities"""
    common: Floats
    """(54, LANES): in `gpb1` what the next mark starts from"""
    lead: Ints
    """(LANES,) the most probable model"""
    boost: Floats
    """(LANES,), factor of every model's sigma"""


class Work(NamedTuple):
    """Room for one mark; H = N hypotheses, N^2 in `gpb2`."""

    s: Floats
    """(H, 54, LANES) predicted"""
    updated: Floats
    """(H, 54, LANES), where the caller does not have them written into the track at once"""
    log: Floats
    """(H, LANES): joint probability before the mark, then with its likelihood"""
    nis: Floats
    likelihood: Floats
    """(H, LANES), ln w"""
    transition: Floats
    """(N, N, LANES), P(dt)"""
    log_transition: Floats
    """(N, N, LANES), ln P(dt)"""
    known_dt: Floats
    known_power: Floats
    """(LANES,), dt over the base interval, for which the transitions stand"""
    known_region: Ints
    known_boost: Floats
    matrix: Floats
    joint: Floats
    weight: Floats
    """(N, LANES)"""
    total: Floats
    coefficients: Floats
    """(N, 16, LANES) of the prediction for each model"""
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
    again: Floats
    """(LANES,) room to work in"""
    sound: Floats
    """(LANES,) 1 = no hypothesis has a number without meaning: not finite, or a negative variance"""


def new_track(models: int) -> Track:
    """Lanes without a track; idle lanes stay harmless."""
    s = np.zeros((models, 54, LANES))
    for i in range(9):
        s[:, place(i, i)] = 1.0
    return Track(
        s=s,
        log=np.full((models, LANES), -np.log(models)),
        share=np.full((models, LANES), 1 / models),
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
        updated=np.zeros((h, 54, LANES)),
        log=np.zeros(block),
        nis=np.zeros(block),
        likelihood=np.zeros(block),
        transition=np.zeros((models, models, LANES)),
        log_transition=np.zeros((models, models, LANES)),
        known_dt=np.full(LANES, -1.0),
        known_power=np.full(LANES, -1.0),
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
        again=np.zeros(LANES),
        sound=np.ones(LANES),
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
        carries = not knows_acceleration(bank.kinds[m])
        for a in range(3):
            track.s[m, 3 * a, lane] = position[a]
            for b in range(a + 1):
                track.s[m, place(3 * a, 3 * b), lane] = covariance[a * (a + 1) // 2 + b]
            track.s[m, place(3 * a + 1, 3 * a + 1), lane] = velocity_variance
            track.s[m, place(3 * a + 2, 3 * a + 2), lane] = acceleration_variance if carries else 0.0
        track.log[m, lane] = -np.log(n)
        track.share[m, lane] = 1.0 / n
    track.lead[lane] = 0


@bare
def settle_start(bank, track, work, fresh):
    """After `start_lane`: known accelerations, and the common state of the lanes with fresh = 1."""
    n = track.log.shape[0]
    for m in range(n):
        known_acceleration(bank.kinds[m], track.s[m], work.coefficients[m])
        if knows_acceleration(bank.kinds[m]):
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
    count = 0
    for lane in range(LANES):
        count += 1 if go[lane] > 0.0 else 0
    if count == LANES:
        copy_hypothesis(source, target)
        return
    for lane in range(LANES):
        if go[lane] > 0.0:
            for i in range(54):
                target[i, lane] = source[i, lane]


@woven
def _predict(bank, model, s, dt, work, boost, out):
    """Predict one hypothesis with one model; the coefficients of linear models live as long as the intervals do."""
    kind = bank.kinds[model]
    c = work.coefficients[model]
    stale = work.stale[0] == 1
    if stale or kind == GD:
        known_acceleration(kind, s, c)
    if stale or kind == CT:
        transition_coefficients(kind, dt, s, c)
    if stale:
        for lane in range(LANES):
            work.sigma[lane] = bank.sigma[model] * boost[lane]
            work.as_rate[lane] = 1.0 if bank.as_rate == 1 or dt[lane] > bank.rate_above_s else 0.0
        noise_coefficients(kind, work.sigma, dt, work.as_rate, bank.chains.step_s, c)
    if knows_acceleration(kind):
        predict_6(s, c, out)
    elif kind == CA:
        predict_9(s, c, out)
    else:
        predict_turn_9(s, c, out)


@woven
def _mix(bank, track, work, after):
    """Weights of the models before, seen from the model after, and the logarithm of its predicted probability."""
    n = track.log.shape[0]
    total, sums, rule = work.log[after], work.spare[0], MOMENT if bank.structure == GPB1 else bank.rule
    for lane in range(LANES):
        sums[lane] = 0.0
    for before in range(n):
        p, q, out = work.transition[after, before], track.share[before], work.weight[before]
        for lane in range(LANES):
            out[lane] = p[lane] * q[lane]
        for lane in range(LANES):
            sums[lane] += out[lane]
    small = 0
    for lane in range(LANES):
        work.again[lane] = sums[lane]
        small += 1 if sums[lane] < SMALLEST_SUM else 0
    choose_weights(after, rule, work.weight, sums, total)
    if small == 0:
        return
    for before in range(n):
        for lane in range(LANES):
            work.joint[before, lane] = max(work.log_transition[after, before, lane] + track.log[before, lane], LN_ZERO)
    merge_weights(work.joint, after, rule, work.share, work.total, work.spare)
    for lane in range(LANES):
        if work.again[lane] < SMALLEST_SUM:
            total[lane] = work.total[lane]
            for before in range(n):
                work.weight[before, lane] = work.share[before, lane]


@woven
def advance_here(bank, track, work, dt, region):
    """Move all hypotheses over dt (LANES,) s, in `work`; return the largest clip of a transition power (NaN = none)."""
    n = track.log.shape[0]
    changed = 0
    for lane in range(LANES):
        changed += 1 if dt[lane] != work.known_dt[lane] or track.boost[lane] != work.known_boost[lane] else 0
    work.stale[0] = 1 if changed > 0 else 0
    if changed > 0:
        for lane in range(LANES):
            work.known_boost[lane] = track.boost[lane]
            work.known_dt[lane] = dt[lane]
    clip = transitions(bank.chains, region, dt, work)
    for after in range(n):
        if bank.structure == GPB2:
            for before in range(n):
                h = after * n + before
                p, known, out = work.log_transition[after, before], track.log[before], work.log[h]
                for lane in range(LANES):
                    out[lane] = max(p[lane] + known[lane], LN_ZERO)
                _predict(bank, after, track.s[before], dt, work, track.boost, work.s[h])
            continue
        _mix(bank, track, work, after)
        source = work.merged
        if bank.structure == GPB1:
            source = track.common
        elif stands_alone(after, work.weight):
            source = track.s[after]
        elif knows_acceleration(bank.kinds[after]):
            merge_positions_and_velocities(track.s, work.weight, source)
        else:
            merge_moments(track.s, work.weight, source)
        _predict(bank, after, source, dt, work, track.boost, work.s[after])
    return clip


@bare
def advance(bank, track, work, dt, region):
    """`advance_here` for those who call it beside the step."""
    return advance_here(bank, track, work, dt, region)


@woven
def absorb(bank, work, which, rows, log_volume, out):
    """Let one hypothesis take the mark; the updated one is written into `out`.

    rows : (23, LANES) of `update_9`, innovations at the predicted position
    log_volume : (LANES,), what ln det R exceeds the sum of ln variance by (0 unless rows were scaled)
    """
    models = bank.kinds.shape[0]
    if knows_acceleration(bank.kinds[which // models if work.s.shape[0] > models else which]):
        update_6(work.s[which], rows, out)
    else:
        update_9(work.s[which], rows, out)
    nis, likelihood, log = work.nis[which], work.likelihood[which], work.log[which]
    for lane in range(LANES):
        count = rows[15, lane] + rows[16, lane] + rows[17, lane]
        nis[lane] = rows[18, lane]
        likelihood[lane] = -0.5 * (rows[18, lane] + logarithm(rows[19, lane]) + log_volume[lane] + count * LN_2PI)
    for lane in range(LANES):
        log[lane] = max(log[lane] + likelihood[lane], LN_ZERO)
    for lane in range(LANES):
        # A position is never known exactly; other things may be, where a model has no noise.
        good = rows[20, lane] > 0.0 and rows[21, lane] >= 0.0 and rows[22, lane] - rows[22, lane] == 0.0
        before = 1.0 if which == 0 else work.sound[lane]
        work.sound[lane] = before if good else 0.0


@woven
def conclude_here(bank, track, work, s, go, taken):
    """Take hypotheses s (H, 54, LANES) over into the lanes with go = 1: probabilities, states, merging after the mark.

    Where `taken` they stand in the track already (`imm` and `gpb1`, all lanes).
    """
    n = track.log.shape[0]
    if bank.structure == GPB2:
        for after in range(n):
            first = after * n
            merge_weights(work.log[first : first + n], after, bank.rule, work.weight, work.joint[after], work.spare)
            source = work.merged
            if stands_alone(after, work.weight):
                source = s[first + after]
            else:
                merge_moments(s[first : first + n], work.weight, source)
            _blend(source, track.s[after], go)
    else:
        for m in range(n):
            if not taken:
                _blend(s[m], track.s[m], go)
            ours, theirs = work.joint[m], work.log[m]
            for lane in range(LANES):
                ours[lane] = theirs[lane]
    # Counted from the largest: beside logarithms of -1e12 the sum of all would keep four digits only.
    sums, top, total, evidence = work.spare[0], work.spare[1], work.total, work.evidence
    exponents(work.joint, work.weight, top, sums)
    for lane in range(LANES):
        total[lane] = logarithm(sums[lane])
        sums[lane] = 1.0 / sums[lane]
    for lane in range(LANES):
        evidence[lane] = top[lane] + total[lane]
    for m in range(n):
        joint, weight, log, share = work.joint[m], work.weight[m], track.log[m], track.share[m]
        for lane in range(LANES):
            value = max((joint[lane] - top[lane]) - total[lane], LN_ZERO)
            log[lane] = value if go[lane] > 0.0 else log[lane]
        for lane in range(LANES):
            share[lane] = weight[lane] * sums[lane] if go[lane] > 0.0 else share[lane]
    if bank.structure == GPB1:
        merge_weights(track.log, -1, bank.rule, work.weight, work.total, work.spare)
        merge_moments(track.s, work.weight, work.merged)
        _blend(work.merged, track.common, go)
    lead, best = track.lead, work.total
    for lane in range(LANES):
        lead[lane] = 0
        best[lane] = track.log[0, lane]
    for m in range(1, n):
        log = track.log[m]
        for lane in range(LANES):
            lead[lane] = m if log[lane] > best[lane] else lead[lane]
        for lane in range(LANES):
            best[lane] = max(best[lane], log[lane])


@bare
def conclude(bank, track, work, s, go):
    """`conclude_here` for those who call it beside the step."""
    conclude_here(bank, track, work, s, go, False)


@woven
def combine(bank, track, work, rows, out):
    """Write the answer's `rows` into out (54, LANES), and the model probabilities into `work.share`."""
    n = track.log.shape[0]
    for m in range(n):
        ours, theirs = work.share[m], track.share[m]
        for lane in range(LANES):
            ours[lane] = theirs[lane]
    if bank.output_moment == 1:
        merge_moments(track.s, work.share, out)
        return
    first, mixed = track.lead[0], 0
    for lane in range(LANES):
        mixed += 1 if track.lead[lane] != first else 0
    for k in range(rows.shape[0]):
        i = rows[k]
        ours, theirs = out[i], track.s[first, i]
        if mixed == 0:
            for lane in range(LANES):
                ours[lane] = theirs[lane]
        else:
            for lane in range(LANES):
                ours[lane] = track.s[track.lead[lane], i, lane]
