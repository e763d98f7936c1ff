"""Compiled parts of the multiple-model filter around its step: starting a track, judging a step, reporting it."""

from __future__ import annotations

import numpy as np

from algorithms.multiple_model.states import (
    NOT_NEAREST,
    R_NONE,
    R_NOT_NEAREST,
    R_RATE,
    R_RESTARTED,
    R_STEPS,
    R_UNUSUAL,
    RESTARTED,
    UNUSUAL,
    UNUSUAL_NIS,
    UPDATED,
)
from algorithms.toolbox.filters.merging import copy_hypothesis
from algorithms.toolbox.filters.multiple_model import combine, place, start_lane
from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.flat import woven
from algorithms.toolbox.sensors.position_rows import gradients, position_covariance


@bare
def start(row, lane, marks, setup, bank, track, state, now, rows):
    """Start a track in one lane, at the measurement and with its covariance."""
    covariance, position = now.small[0], now.small[1]
    for a in range(3):
        position[a] = marks.y[row, a, lane]
        rows.at[a, lane] = position[a]
    gradients(marks.kind[row], marks.axes[marks.sensor[row]], marks.origin[row], rows.at, rows.r)
    position_covariance(rows.r, marks.sd[row], lane, covariance)
    start_lane(bank, track, lane, position, covariance, setup.velocity_variance, setup.acceleration_variance)
    track.boost[lane] = 1.0
    state.memory[lane] = 0.0
    state.live[lane] = 1
    state.time[lane] = marks.time[row]
    state.sensor[lane] = marks.sensor[row]
    state.started[lane] += 1
    state.number[lane] = state.started[lane]
    now.fresh[lane] = 1.0
    now.shown[lane] = 1


@woven
def all_usual(lanes, marks, setup, bank, track, state, work, now, report):
    """Where every lane took row `now.chosen`: do what `finish` does, if nothing in it has to be decided."""
    row, models, lead, nis = now.chosen[0], track.log.shape[0], track.lead, now.total
    step = models + 1 if work.s.shape[0] > models else 1
    for m in range(models):
        found = work.nis[m * step]
        for lane in range(LANES):
            nis[lane] = found[lane] if m == 0 or lead[lane] == m else nis[lane]
    limit, long = UNUSUAL_NIS[marks.dof[row] - 1], min(setup.substep_above_s, bank.rate_above_s)
    sound, evidence, dt = work.sound, work.evidence, now.dt
    usual = 0
    for lane in range(lanes):
        usual += 1 if sound[lane] == 1.0 and nis[lane] <= limit and dt[lane] <= long else 0
    for lane in range(lanes):
        usual += 1 if evidence[lane] - evidence[lane] == 0.0 else 0
    if usual < 2 * lanes or setup.fade > 0.0:
        return False
    out, times, sensors, time, sensor = report.nis[row], state.time, state.sensor, marks.time[row], marks.sensor[row]
    for lane in range(lanes):
        out[lane] = nis[lane]
    for lane in range(lanes):
        times[lane] = time
    for lane in range(lanes):
        sensors[lane] = sensor
    return True


@bare
def finish(lanes, marks, setup, bank, track, state, work, now, report, rows):
    """What became of the rows; lanes whose numbers lost their meaning start anew; the manoeuvre detector."""
    models = track.log.shape[0]
    again = 0
    for lane in range(lanes):
        if now.go[lane] == 0.0:
            continue
        row = now.chosen[lane]
        if work.sound[lane] < 1.0 or not np.isfinite(work.evidence[lane]):
            now.status[lane] = RESTARTED
            now.reason[lane] = R_RESTARTED
            now.go[lane] = 0.0
            start(row, lane, marks, setup, bank, track, state, now, rows)
            again += 1
            continue
        h = track.lead[lane] * (models + 1) if work.s.shape[0] > models else track.lead[lane]
        nis = work.nis[h, lane]
        report.nis[row, lane] = nis
        dof = marks.dof[row]
        if nis > UNUSUAL_NIS[dof - 1]:
            now.status[lane] = UNUSUAL
            if now.reason[lane] == R_NONE:
                now.reason[lane] = R_UNUSUAL
        elif now.reason[lane] == R_NONE and now.dt[lane] > setup.substep_above_s:
            now.reason[lane] = R_STEPS
        elif now.reason[lane] == R_NONE and now.dt[lane] > bank.rate_above_s:
            now.reason[lane] = R_RATE
        state.time[lane] = marks.time[row]
        state.sensor[lane] = marks.sensor[row]
        if setup.fade > 0.0:
            state.memory[lane] = setup.fade * state.memory[lane] + (1.0 - setup.fade) * nis / dof
            if state.memory[lane] > setup.boost_above:
                track.boost[lane] = setup.boost
            elif state.memory[lane] < setup.calm_below:
                track.boost[lane] = 1.0
    return again


@bare
def _put(values, first, lanes, now, out):
    """Write rows of `values` (K, LANES), from the first on, into out (M, J, L): each shown lane into its own row."""
    for i in range(out.shape[1]):
        for lane in range(lanes):
            if now.shown[lane] == 1:
                out[now.chosen[lane], i, lane] = values[first + i, lane]


@bare
def _blend_predicted(lanes, models, work, now):
    """Put predictions where the answer of a coasting lane stands. Of a pair of hypotheses the later model counts."""
    pairs = work.s.shape[0] // models
    for lane in range(lanes):
        if now.go[lane] > 0.0 or now.fresh[lane] > 0.0:
            continue
        for i in range(54):
            now.answer[i, lane] = now.predicted[i, lane]
        for m in range(models):
            share = 0.0
            for h in range(m * pairs, (m + 1) * pairs):
                share += now.weight[h, lane]
            work.share[m, lane] = share


@bare
def write(k, stop, lanes, coasting, setup, bank, track, work, state, now, report):
    """Report the group: the chosen row of each lane, and why the other rows were not."""
    models = track.log.shape[0]
    combine(bank, track, work, now.rows, now.answer)
    if bank.structure != 0 and setup.heights.shape[0] > 0:
        copy_hypothesis(now.answer, track.common)
    if coasting > 0:
        _blend_predicted(lanes, models, work, now)
    for lane in range(lanes):
        row = now.chosen[lane]
        for r in range(k, stop):
            if r != row:
                report.status[r, lane] = NOT_NEAREST if now.go[lane] > 0.0 else now.status[lane]
                report.reason[r, lane] = R_NOT_NEAREST if now.go[lane] > 0.0 else now.reason[lane]
        report.status[row, lane] = now.status[lane]
        report.reason[row, lane] = now.reason[lane]
        if now.shown[lane] == 1:
            report.track[row, lane] = state.number[lane]
    _put(now.answer, 0, lanes, now, report.state)
    _put(work.share, 0, lanes, now, report.probability)
    if report.model_state.shape[0] == 0:
        for a in range(3):
            for b in range(a + 1):
                i, j = place(3 * a, 3 * b), a * (a + 1) // 2 + b
                for lane in range(LANES):
                    now.block[j, lane] = now.answer[i, lane]
        _put(now.block, 0, lanes, now, report.covariance)
        return
    _put(now.answer, 9, lanes, now, report.covariance)
    for m in range(models):
        h = m * (models + 1) if work.s.shape[0] > models else m
        for lane in range(lanes):
            if now.shown[lane] == 0:
                continue
            row = now.chosen[lane]
            coasts = now.go[lane] == 0.0 and now.fresh[lane] == 0.0
            for i in range(9):
                report.model_state[row, m, i, lane] = work.s[h, i, lane] if coasts else track.s[m, i, lane]
            if now.go[lane] > 0.0:
                report.likelihood[row, m, lane] = work.likelihood[h, lane]


@bare
def _put_row(values, first, lanes, row, out):
    """Write rows of `values` (K, LANES), from the first on, into row `row` of out (M, J, L)."""
    for i in range(out.shape[1]):
        ours, theirs = values[first + i], out[row, i]
        for lane in range(lanes):
            theirs[lane] = ours[lane]


@woven
def write_together(row, lanes, setup, bank, track, work, state, now, report):
    """The same where every lane took the one row that there is."""
    combine(bank, track, work, now.rows, now.answer)
    if bank.structure != 0 and setup.heights.shape[0] > 0:
        copy_hypothesis(now.answer, track.common)
    status, track_number, number = report.status[row], report.track[row], state.number
    for lane in range(lanes):
        status[lane] = UPDATED
    for lane in range(lanes):
        track_number[lane] = number[lane]
    _put_row(now.answer, 0, lanes, row, report.state)
    _put_row(work.share, 0, lanes, row, report.probability)
    models = track.log.shape[0]
    if report.model_state.shape[0] == 0:
        for a in range(3):
            for b in range(a + 1):
                ours, theirs = now.answer[place(3 * a, 3 * b)], report.covariance[row, a * (a + 1) // 2 + b]
                for lane in range(lanes):
                    theirs[lane] = ours[lane]
        return
    _put_row(now.answer, 9, lanes, row, report.covariance)
    for m in range(models):
        h = m * (models + 1) if work.s.shape[0] > models else m
        _put_row(track.s[m], 0, lanes, row, report.model_state[:, m])
        for lane in range(lanes):
            report.likelihood[row, m, lane] = work.likelihood[h, lane]
