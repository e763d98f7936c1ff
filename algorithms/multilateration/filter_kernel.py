"""The compiled range-difference filter: a block of trials through a range of marks.

One mark goes through these steps (specification 4, 5, 6.4(b)):

1. `_read_mark`      receptions and altitude that are finite; impossible spreads.
2. `_elapsed`        time since the state, from the gate or from the estimated emission; gaps close a track.
3. `predict_jerk`    the block, lanes without a track standing still.
4. `begin_or_solve` per lane: start a track from a one-mark fix; with an unknown velocity or after 20 s take the fix as
                     point of linearisation, and restart where prediction and fix differ by more than five sigma.
5. `_measure`        rows of the mark; in the robust profile their noise is scaled where the innovation is too large.
6. `_conclude`       status, consistency over twenty marks, tracks that have lost their way; the report.
"""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.begin import begin_or_solve, claim_too_large, drop, emission_offset
from algorithms.multilateration.fix import residual_rms
from algorithms.multilateration.lanes import (
    ALTITUDE_ONLY,
    AMBIGUOUS,
    COAST,
    DOWNWEIGHTED,
    GAP_S,
    IMPOSSIBLE_TOA,
    INCONSISTENT_RATIO,
    INITIALISED,
    NOT_INITIALISED,
    R_CLAIM,
    R_FEW,
    R_NONE,
    R_OLD,
    R_SCALED,
    R_SINGULAR,
    R_SPREAD,
    R_TWO,
    REINITIALISED,
    REJECTED_TIME,
    RELINEARISATIONS,
    RIVAL_COST_GAP,
    SCALE_FROM_SIGMA,
    SINGULAR,
    UPDATED,
    WINDOW_CAP,
    WINDOW_MARKS,
)
from algorithms.toolbox.kernels import LANES, kernel
from algorithms.toolbox.kernels.rows import update_row
from algorithms.toolbox.kernels.symmetric import position_block
from algorithms.toolbox.motion.jerk import predict_jerk
from algorithms.toolbox.sensors.altitude import altitude_row
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS, contrast_rows


@kernel
def _read_mark(k, marks, setup, toa_m, used, altitude, has_altitude, count, possible):
    """Copy one mark into the lanes: finite receptions, altitude, and whether its spread is possible."""
    n_stations = setup.stations.shape[0]
    n_lanes = marks.toa.shape[2]
    for lane in range(LANES):
        count[lane] = 0
        possible[lane] = 1
        has_altitude[lane] = 0.0
        altitude[lane] = 0.0
    for s in range(n_stations):
        for lane in range(n_lanes):
            value = marks.toa[k, s, lane]
            here = np.isfinite(value)
            used[s, lane] = 1.0 if here else 0.0
            toa_m[s, lane] = SPEED_OF_LIGHT_MPS * value if here else 0.0
            count[lane] += 1 if here else 0
    for s in range(n_stations):
        for q in range(s):
            limit = setup.spread_limit[s, q]
            for lane in range(n_lanes):
                both = used[s, lane] * used[q, lane]
                if both * abs(toa_m[s, lane] - toa_m[q, lane]) > limit:
                    possible[lane] = 0
    if setup.use_altitude:
        for lane in range(n_lanes):
            value = marks.altitude[k, lane]
            if np.isfinite(value):
                altitude[lane] = value
                has_altitude[lane] = 1.0


@kernel
def _elapsed(gate, lane, setup, track, toa_m, used, possible):
    """Time from the state to this mark, s.

    The article filters at the gate's time; the robust profile at the emission, estimated with the predicted position.
    """
    if not setup.robust:
        return max(gate - track.time[lane], 0.0)
    t = gate - track.time[lane]
    x = track.x
    px = x[0, 0, lane] + t * (x[0, 1, lane] + 0.5 * t * x[0, 2, lane])
    py = x[0, 3, lane] + t * (x[0, 4, lane] + 0.5 * t * x[0, 5, lane])
    pz = x[0, 6, lane] + t * (x[0, 7, lane] + 0.5 * t * x[0, 8, lane])
    offset = np.nan
    if possible[lane] == 1:
        offset = emission_offset(px, py, pz, toa_m, used, setup.stations, lane)
    if not np.isfinite(offset):
        offset = setup.gate_centre_s
    return max(t + offset, 0.0)


@kernel
def _rows(setup, toa_m, used, altitude, has_altitude, go, at, x, n_axis, h, nu, var, active):
    """All rows of one mark: S contrasts and, last, the altitude."""
    n_stations = setup.stations.shape[0]
    contrast_rows(toa_m, used, setup.stations, setup.variance, at, x, n_axis, h, nu, var, active)
    altitude_row(altitude, at, x, n_axis, setup.earth, h[n_stations], nu[n_stations])
    for lane in range(LANES):
        var[n_stations, lane] = setup.altitude_variance
        active[n_stations, lane] = has_altitude[lane]
    for r in range(n_stations + 1):
        for lane in range(LANES):
            active[r, lane] *= go[lane]


@kernel
def _measure(which, setup, track, toa_m, used, altitude, has_altitude, go, iterate, at, nis, log_likelihood, scale):
    """Update the block's track (or rival) with one mark; NIS before scaling, and the scale of the noise."""
    n_rows = setup.stations.shape[0] + 1
    h = np.empty((n_rows, 3, LANES))
    nu = np.empty((n_rows, LANES))
    var = np.empty((n_rows, LANES))
    active = np.empty((n_rows, LANES))
    w = np.empty((9, LANES))
    x = track.x[which]
    p = track.p[which]
    start = np.empty((3, LANES))
    for a in range(3):
        for lane in range(LANES):
            start[a, lane] = x[3 * a, lane]
    for lane in range(LANES):
        scale[lane] = 1.0
    _rows(setup, toa_m, used, altitude, has_altitude, go, at, x, 3, h, nu, var, active)
    if setup.robust:
        again = 0
        for lane in range(LANES):
            again += iterate[lane]
        small_x = np.empty((3, LANES))
        small_p = np.empty((6, LANES))
        block = np.empty(6)
        for step in range(RELINEARISATIONS if again > 0 else 1):
            if step > 0:
                _rows(setup, toa_m, used, altitude, has_altitude, go, at, x, 3, h, nu, var, active)
            for lane in range(LANES):
                position_block(p, 3, lane, block)
                for k in range(6):
                    small_p[k, lane] = block[k]
                for a in range(3):
                    small_x[a, lane] = start[a, lane]
                nis[lane] = 0.0
                log_likelihood[lane] = 0.0
            for r in range(n_rows):
                update_row(small_x, small_p, start, h[r], nu[r], var[r], active[r], 1, w, nis, log_likelihood)
            if step + 1 < RELINEARISATIONS:
                for lane in range(LANES):
                    if iterate[lane] == 1:
                        for a in range(3):
                            at[a, lane] = small_x[a, lane]
        for lane in range(LANES):
            dof = 0.0
            for r in range(n_rows):
                dof += active[r, lane]
            limit = SCALE_FROM_SIGMA**2 * dof
            if nis[lane] > limit and dof > 0.0:
                scale[lane] = nis[lane] / limit
        for r in range(n_rows):
            for lane in range(LANES):
                var[r, lane] *= scale[lane]
    full_nis = np.zeros(LANES)
    for lane in range(LANES):
        log_likelihood[lane] = 0.0
    for r in range(n_rows):
        update_row(x, p, start, h[r], nu[r], var[r], active[r], 3, w, full_nis, log_likelihood)
    if not setup.robust:
        for lane in range(LANES):
            nis[lane] = full_nis[lane]


@kernel
def _settle_rival(lane, track):
    """Keep the better of two hypotheses in front; forget the worse once the data have decided."""
    if track.cost[1, lane] < track.cost[0, lane]:
        for i in range(9):
            keep = track.x[0, i, lane]
            track.x[0, i, lane] = track.x[1, i, lane]
            track.x[1, i, lane] = keep
        for k in range(45):
            keep = track.p[0, k, lane]
            track.p[0, k, lane] = track.p[1, k, lane]
            track.p[1, k, lane] = keep
        keep = track.cost[0, lane]
        track.cost[0, lane] = track.cost[1, lane]
        track.cost[1, lane] = keep
    if track.cost[1, lane] - track.cost[0, lane] > RIVAL_COST_GAP:
        track.rival[lane] = 0


@kernel
def _sound(lane, track):
    """Whether the lane's covariance still has a positive diagonal and the state is finite."""
    sound = True
    for i in range(9):
        sound = sound and track.p[0, i * (i + 1) // 2 + i, lane] > 0.0 and np.isfinite(track.x[0, i, lane])
    return sound


@kernel
def _conclude(lane, setup, track, count, has_altitude, nis, scale, dof, status, reason):
    """Status of an updated lane; the consistency of its last twenty marks; end a track that lost its way."""
    track.last_update[lane] = track.time[lane]
    if not _sound(lane, track):
        status[lane] = SINGULAR
        reason[lane] = R_SINGULAR
        drop(lane, track)
        return
    if track.rival[lane] == 1:
        status[lane] = AMBIGUOUS
        reason[lane] = R_TWO
    elif scale[lane] > 1.0:
        status[lane] = DOWNWEIGHTED
        reason[lane] = R_SCALED
    elif count[lane] < 2:
        status[lane] = ALTITUDE_ONLY
        reason[lane] = R_FEW
    else:
        status[lane] = UPDATED
        reason[lane] = R_NONE
    if not setup.robust or dof == 0:
        return
    fill = track.window_fill[lane]
    track.window[fill % WINDOW_MARKS, lane] = min(nis[lane] / dof, WINDOW_CAP)
    track.window_fill[lane] = fill + 1
    if fill + 1 >= WINDOW_MARKS:
        mean = 0.0
        for i in range(WINDOW_MARKS):
            mean += track.window[i, lane]
        track.suspect[lane] = 1 if mean / WINDOW_MARKS > INCONSISTENT_RATIO else 0


@kernel
def _write(k, lane, setup, track, toa_m, used, nis, dof, status, reason, took, took_altitude, report, work):
    """Report one lane at one mark."""
    n_stations = setup.stations.shape[0]
    report.status[k, lane] = status
    report.reason[k, lane] = reason
    if status == REJECTED_TIME or track.live[lane] == 0:
        return
    report.track[k, lane] = track.number[lane]
    report.time[k, lane] = track.time[lane]
    for i in range(9):
        report.state[k, i, lane] = track.x[0, i, lane]
    for i in range(45):
        report.covariance[k, i, lane] = track.p[0, i, lane]
    report.dof[k, lane] = dof
    if dof > 0:
        report.nis[k, lane] = nis
    report.altitude_used[k, lane] = took and took_altitude
    position = np.empty(3)
    for a in range(3):
        position[a] = track.x[0, 3 * a, lane]
    n = 0
    for s in range(n_stations):
        work[0, s] = toa_m[s, lane]
        work[1, s] = used[s, lane]
        n += 1 if used[s, lane] > 0.0 else 0
    if n >= 2:
        residual_rms(position, work[0], work[1], setup.stations, work[2])
        for s in range(n_stations):
            report.residual[k, s, lane] = work[2, s]
            report.used[k, s, lane] = took and used[s, lane] > 0.0


@kernel
def filter_marks(marks, setup, track, report, first, stop):
    """Run marks first <= k < stop of a block of trials through the filter.

    Parameters
    ----------
    marks : Marks, L <= LANES trials
    setup : Setup
    track : Track, changed in place
    report : Report, filled for these marks
    first, stop : int
    """
    n_stations = setup.stations.shape[0]
    n_lanes = marks.toa.shape[2]
    toa_m = np.zeros((n_stations, LANES))
    used = np.zeros((n_stations, LANES))
    altitude = np.zeros(LANES)
    has_altitude = np.zeros(LANES)
    count = np.zeros(LANES, np.int64)
    possible = np.zeros(LANES, np.int64)
    t = np.zeros(LANES)
    at = np.zeros((3, LANES))
    go = np.zeros(LANES)
    rival_go = np.zeros(LANES)
    iterate = np.zeros(LANES, np.int64)
    status = np.zeros(LANES, np.int64)
    reason = np.zeros(LANES, np.int64)
    nis = np.zeros(LANES)
    rival_nis = np.zeros(LANES)
    log_likelihood = np.zeros(LANES)
    scale = np.ones(LANES)
    work = np.empty((3, n_stations))
    for k in range(first, stop):
        gate = marks.time[k]
        _read_mark(k, marks, setup, toa_m, used, altitude, has_altitude, count, possible)
        rivals = 0
        for lane in range(LANES):
            t[lane] = 0.0
            go[lane] = 0.0
            rival_go[lane] = 0.0
            iterate[lane] = 0
            nis[lane] = 0.0
            reason[lane] = R_NONE
        for lane in range(n_lanes):
            if gate < track.gate[lane] or not np.isfinite(gate):
                status[lane] = REJECTED_TIME
                reason[lane] = R_OLD
                continue
            status[lane] = COAST
            track.gate[lane] = gate
            if track.live[lane] == 1:
                t[lane] = _elapsed(gate, lane, setup, track, toa_m, used, possible)
                if setup.robust and track.time[lane] + t[lane] - track.last_update[lane] > GAP_S:
                    drop(lane, track)
                    t[lane] = 0.0
            rivals += track.rival[lane]
        predict_jerk(track.x[0], track.p[0], t, setup.sigma_jerk, setup.noise_form)
        if rivals > 0:
            predict_jerk(track.x[1], track.p[1], t, setup.sigma_jerk, setup.noise_form)
        for lane in range(LANES):
            track.time[lane] += t[lane]
            for a in range(3):
                at[a, lane] = track.x[0, 3 * a, lane]
        for lane in range(n_lanes):
            if status[lane] == REJECTED_TIME:
                continue
            if possible[lane] == 0:
                status[lane] = IMPOSSIBLE_TOA
                reason[lane] = R_SPREAD
            else:
                begin_or_solve(
                    lane,
                    gate,
                    setup,
                    track,
                    toa_m,
                    used,
                    altitude,
                    has_altitude,
                    count,
                    at,
                    iterate,
                    go,
                    status,
                    reason,
                    work,
                )
            if track.rival[lane] == 1:
                rival_go[lane] = go[lane]
        _measure(0, setup, track, toa_m, used, altitude, has_altitude, go, iterate, at, nis, log_likelihood, scale)
        for lane in range(LANES):
            track.cost[0, lane] -= 2.0 * log_likelihood[lane] * go[lane]
        if rivals > 0:
            rival_scale = np.ones(LANES)
            for lane in range(LANES):
                for a in range(3):
                    at[a, lane] = track.x[1, 3 * a, lane]
            _measure(
                1,
                setup,
                track,
                toa_m,
                used,
                altitude,
                has_altitude,
                rival_go,
                iterate,
                at,
                rival_nis,
                log_likelihood,
                rival_scale,
            )
            for lane in range(LANES):
                track.cost[1, lane] -= 2.0 * log_likelihood[lane] * rival_go[lane]
        for lane in range(n_lanes):
            took = go[lane] > 0.0 or status[lane] == INITIALISED or status[lane] == REINITIALISED
            dof = 0
            if go[lane] > 0.0:
                dof = max(count[lane] - 1, 0) + (1 if has_altitude[lane] > 0.0 else 0)
                if track.rival[lane] == 1:
                    _settle_rival(lane, track)
                _conclude(lane, setup, track, count, has_altitude, nis, scale, dof, status, reason)
            if setup.robust and track.live[lane] == 1 and claim_too_large(lane, setup, track):
                drop(lane, track)
                status[lane] = NOT_INITIALISED
                reason[lane] = R_CLAIM
            _write(
                k,
                lane,
                setup,
                track,
                toa_m,
                used,
                nis[lane],
                dof,
                status[lane],
                reason[lane],
                took,
                has_altitude[lane] > 0.0,
                report,
                work,
            )
