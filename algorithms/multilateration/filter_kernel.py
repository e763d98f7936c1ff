"""The compiled range-difference filter: a block of trials, or of targets, through a range of marks.

One mark goes through these steps (specification 4, 5, 6.4(b)):

1. `_read_mark`      receptions and altitude that are finite; impossible spreads.
2. `_elapse`         time since the state, from the gate or from the estimated emission; gaps close a track.
3. `predict_jerk`    the block, lanes without a track standing still.
4. `decide` per lane: start a track from a one-mark fix, or from several marks together; with an unknown velocity or
                     after 20 s take the fix as point of linearisation, and restart where prediction and fix differ by
                     more than five sigma.
5. `_measure`        rows of the mark; in the robust profile their noise is scaled where the innovation is too large.
6. `_conclude`       status, consistency over twenty marks, tracks that have lost their way; the report.
"""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.begin import claim_too_large, decide, drop, emission_offset
from algorithms.multilateration.lanes import (
    ALTITUDE_ONLY,
    AMBIGUOUS,
    COAST,
    DOWNWEIGHTED,
    EIGENVALUE_FLOOR,
    GAP_S,
    INCONSISTENT_RATIO,
    INITIALISED,
    NOT_INITIALISED,
    R_CLAIM,
    R_FEW,
    R_NONE,
    R_OLD,
    R_REPAIRED,
    R_SCALED,
    R_SINGULAR,
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
from algorithms.toolbox.kernels import LANES, inlined, kernel
from algorithms.toolbox.kernels.unrolled import update_rows_3, update_rows_9
from algorithms.toolbox.motion.jerk import predict_jerk
from algorithms.toolbox.sensors.altitude import altitude_row
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS, contrast_rows


@inlined
def _read_mark(k, marks, setup, now):
    """Copy one mark into the lanes: finite receptions, altitude, and whether its spread is possible."""
    n_stations = setup.stations.shape[0]
    lanes = marks.toa.shape[2]
    for lane in range(LANES):
        now.receptions[lane] = 0
        now.possible[lane] = 1
        now.has_altitude[lane] = 0.0
        now.altitude[lane] = 0.0
        now.elapsed[lane] = 0.0
        now.go[lane] = 0.0
        now.iterate[lane] = 0
        now.reason[lane] = R_NONE
        now.dof[lane] = 0
    for s in range(n_stations):
        for lane in range(lanes):
            value = marks.toa[k, s, lane]
            here = np.isfinite(value)
            now.used[s, lane] = 1.0 if here else 0.0
            now.toa[s, lane] = SPEED_OF_LIGHT_MPS * value if here else 0.0
            now.receptions[lane] += 1 if here else 0
    for s in range(n_stations):
        for q in range(s):
            limit = setup.spread_limit[s, q]
            for lane in range(lanes):
                both = now.used[s, lane] * now.used[q, lane]
                if both * abs(now.toa[s, lane] - now.toa[q, lane]) > limit:
                    now.possible[lane] = 0
    if setup.use_altitude:
        for lane in range(lanes):
            value = marks.altitude[k, lane]
            if np.isfinite(value):
                now.altitude[lane] = value
                now.has_altitude[lane] = 1.0


@inlined
def _elapse(lanes, gate, setup, track, now):
    """Time from each state to this mark; reject what is older, close what has coasted too long.

    The article filters at the gate's time; the robust profile at the emission, estimated with the predicted position.
    """
    x = track.x
    for lane in range(lanes):
        if gate[lane] < track.gate[lane] or not np.isfinite(gate[lane]):
            now.status[lane] = REJECTED_TIME
            now.reason[lane] = R_OLD
            continue
        now.status[lane] = COAST
        track.gate[lane] = gate[lane]
        if track.live[lane] == 0:
            continue
        t = gate[lane] - track.time[lane]
        if setup.robust:
            px = x[0, 0, lane] + t * (x[0, 1, lane] + 0.5 * t * x[0, 2, lane])
            py = x[0, 3, lane] + t * (x[0, 4, lane] + 0.5 * t * x[0, 5, lane])
            pz = x[0, 6, lane] + t * (x[0, 7, lane] + 0.5 * t * x[0, 8, lane])
            offset = np.nan
            if now.possible[lane] == 1:
                offset = emission_offset(px, py, pz, now.toa, now.used, setup.stations, lane)
            t += offset if np.isfinite(offset) else setup.gate_centre_s
        t = max(t, 0.0)
        if setup.robust and track.time[lane] + t - track.last_update[lane] > GAP_S:
            drop(lane, track)
            t = 0.0
        now.elapsed[lane] = t


@inlined
def _build_rows(setup, now, go, x, rows):
    """All rows of the mark: S contrasts and, last, the altitude."""
    n_stations = setup.stations.shape[0]
    contrast_rows(
        now.toa, now.used, setup.stations, setup.variance, now.at, x, 3, rows.h, rows.nu, rows.variance, rows.active
    )
    altitude_row(now.altitude, now.at, x, 3, setup.earth, rows.h[n_stations], rows.nu[n_stations])
    for lane in range(LANES):
        rows.variance[n_stations, lane] = setup.altitude_variance
        rows.active[n_stations, lane] = now.has_altitude[lane]
    for r in range(n_stations + 1):
        for lane in range(LANES):
            rows.active[r, lane] *= go[lane]


@inlined
def _learn_nis(setup, track, which, now, go, rows):
    """NIS of the mark from an update of the bare position; linearise again where asked; set the noise's scale.

    The rows see the position only, so its 3 x 3 covariance is enough. Rule 6.4(b): where sqrt(NIS) exceeds three
    sigma, the noise is multiplied by NIS / (9 dof).
    """
    n_rows = rows.nu.shape[0]
    x = track.x[which]
    p = track.p[which]
    again = 0
    for lane in range(LANES):
        again += now.iterate[lane]
    for step in range(RELINEARISATIONS if again > 0 else 1):
        if step > 0:
            _build_rows(setup, now, go, x, rows)
        for a in range(3):
            for b in range(a + 1):
                i = 3 * a * (3 * a + 1) // 2 + 3 * b
                for lane in range(LANES):
                    rows.covariance[a * (a + 1) // 2 + b, lane] = p[i, lane]
            for lane in range(LANES):
                rows.position[a, lane] = rows.start[a, lane]
        for lane in range(LANES):
            now.nis[lane] = 0.0
        update_rows_3(
            rows.position,
            rows.covariance,
            rows.start,
            rows.h,
            rows.nu,
            rows.variance,
            rows.active,
            now.nis,
            now.determinant,
        )
        if step + 1 < RELINEARISATIONS:
            for lane in range(LANES):
                if now.iterate[lane] == 1:
                    for a in range(3):
                        now.at[a, lane] = rows.position[a, lane]
    for lane in range(LANES):
        dof = 0.0
        for r in range(n_rows):
            dof += rows.active[r, lane]
        limit = SCALE_FROM_SIGMA**2 * dof
        if now.nis[lane] > limit and dof > 0.0:
            now.scale[lane] = now.nis[lane] / limit
    for r in range(n_rows):
        for lane in range(LANES):
            rows.variance[r, lane] *= now.scale[lane]


@inlined
def _measure(which, setup, track, now, go, rows):
    """Update the block's tracks (or their rivals) with the mark."""
    x = track.x[which]
    p = track.p[which]
    for a in range(3):
        for lane in range(LANES):
            rows.start[a, lane] = x[3 * a, lane]
    for lane in range(LANES):
        now.scale[lane] = 1.0
    _build_rows(setup, now, go, x, rows)
    if setup.robust:
        _learn_nis(setup, track, which, now, go, rows)
    for lane in range(LANES):
        rows.nis[lane] = 0.0
        now.determinant[lane] = 1.0
    update_rows_9(x, p, rows.start, rows.h, rows.nu, rows.variance, rows.active, rows.nis, now.determinant)
    for lane in range(LANES):
        if not setup.robust:
            now.nis[lane] = rows.nis[lane]
        track.cost[which, lane] += rows.nis[lane] + np.log(now.determinant[lane]) if track.rival[lane] == 1 else 0.0


@kernel
def _turn_to_rivals(lanes, track, now):
    """Set the mark up for the second hypotheses of the lanes that have one; remember what the first ones made of it."""
    for lane in range(LANES):
        now.first_nis[lane] = now.nis[lane]
        now.first_scale[lane] = now.scale[lane]
        now.rival_go[lane] = now.go[lane] if lane < lanes and track.rival[lane] == 1 else 0.0
        for a in range(3):
            now.at[a, lane] = track.x[1, 3 * a, lane]


@kernel
def _settle_rivals(lanes, track, now):
    """Keep the better of two hypotheses in front; forget the worse once the data have decided."""
    for lane in range(lanes):
        now.nis[lane] = now.first_nis[lane]
        now.scale[lane] = now.first_scale[lane]
        if now.rival_go[lane] > 0.0:
            _settle_rival(lane, track)


@kernel
def _settle_rival(lane, track):
    """Settle one lane."""
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
def _repair(lane, track):
    """Lift the eigenvalues of a lane's covariance to the floor, so that it is a covariance again."""
    full = np.empty((9, 9))
    for i in range(9):
        for j in range(i + 1):
            full[i, j] = track.p[0, i * (i + 1) // 2 + j, lane]
            full[j, i] = full[i, j]
    values, vectors = np.linalg.eigh(full)
    for i in range(9):
        for j in range(i + 1):
            total = 0.0
            for k in range(9):
                total += vectors[i, k] * max(values[k], EIGENVALUE_FLOOR) * vectors[j, k]
            track.p[0, i * (i + 1) // 2 + j, lane] = total


@inlined
def _conclude(lanes, setup, track, now):
    """Status of each updated lane; the consistency of its last twenty marks; end a track that lost its way."""
    for lane in range(lanes):
        if now.go[lane] > 0.0:
            known = 1 if now.has_altitude[lane] > 0.0 else 0
            now.dof[lane] = max(now.receptions[lane] - 1, 0) + known
            track.last_update[lane] = track.time[lane]
            finite = True
            positive = True
            for i in range(9):
                finite = finite and np.isfinite(track.x[0, i, lane])
                positive = positive and track.p[0, i * (i + 1) // 2 + i, lane] > 0.0
            if not finite:
                now.status[lane] = SINGULAR
                now.reason[lane] = R_SINGULAR
                drop(lane, track)
                continue
            if not positive:
                _repair(lane, track)
                now.status[lane] = SINGULAR
                now.reason[lane] = R_REPAIRED
                continue
            if track.rival[lane] == 1:
                now.status[lane] = AMBIGUOUS
                now.reason[lane] = R_TWO
            elif now.scale[lane] > 1.0:
                now.status[lane] = DOWNWEIGHTED
                now.reason[lane] = R_SCALED
            elif now.receptions[lane] < 2:
                now.status[lane] = ALTITUDE_ONLY
                now.reason[lane] = R_FEW
            else:
                now.status[lane] = UPDATED
            if setup.robust and now.dof[lane] > 0:
                fill = track.window_fill[lane]
                track.window[fill % WINDOW_MARKS, lane] = min(now.nis[lane] / now.dof[lane], WINDOW_CAP)
                track.window_fill[lane] = fill + 1
                if fill + 1 >= WINDOW_MARKS:
                    mean = 0.0
                    for i in range(WINDOW_MARKS):
                        mean += track.window[i, lane]
                    track.suspect[lane] = 1 if mean / WINDOW_MARKS > INCONSISTENT_RATIO else 0
        if setup.robust and track.live[lane] == 1 and claim_too_large(lane, setup, track):
            drop(lane, track)
            now.status[lane] = NOT_INITIALISED
            now.reason[lane] = R_CLAIM


@inlined
def _write(k, lanes, setup, track, now, report):
    """Report the mark: every lane, row by row, so that whole rows are written."""
    for lane in range(lanes):
        report.status[k, lane] = now.status[lane]
        report.reason[k, lane] = now.reason[lane]
        shown = track.live[lane] == 1 and now.status[lane] != REJECTED_TIME
        now.shown[lane] = 1.0 if shown else np.nan
        report.track[k, lane] = track.number[lane] if shown else 0
        report.time[k, lane] = track.time[lane] * now.shown[lane]
        report.dof[k, lane] = now.dof[lane] if shown else 0
        report.nis[k, lane] = now.nis[lane] if shown and now.dof[lane] > 0 else np.nan
        took = now.go[lane] > 0.0 or now.status[lane] == INITIALISED or now.status[lane] == REINITIALISED
        now.took[lane] = 1 if took and shown else 0
        report.altitude_used[k, lane] = now.took[lane] == 1 and now.has_altitude[lane] > 0.0
    for i in range(9):
        for lane in range(lanes):
            report.state[k, i, lane] = track.x[0, i, lane] * now.shown[lane]
    if report.covariance.shape[1] == 45:
        for i in range(45):
            for lane in range(lanes):
                report.covariance[k, i, lane] = track.p[0, i, lane] * now.shown[lane]
    else:
        for a in range(3):
            for b in range(a + 1):
                i = 3 * a * (3 * a + 1) // 2 + 3 * b
                for lane in range(lanes):
                    report.covariance[k, a * (a + 1) // 2 + b, lane] = track.p[0, i, lane] * now.shown[lane]
    if report.residual.shape[0] > 0:
        for lane in range(lanes):
            waiting = now.status[lane] == NOT_INITIALISED and track.gathered.kept[lane] > 0
            report.start_error[k, lane] = track.gathered.error[lane] if waiting else np.nan
        _write_receptions(k, lanes, setup, track, now, report)


@inlined
def _write_receptions(k, lanes, setup, track, now, report):
    """Which receptions were used, and the range residuals of all about their mean."""
    n_stations = setup.stations.shape[0]
    mean = np.zeros(LANES)
    for s in range(n_stations):
        for lane in range(lanes):
            dx = track.x[0, 0, lane] - setup.stations[s, 0]
            dy = track.x[0, 3, lane] - setup.stations[s, 1]
            dz = track.x[0, 6, lane] - setup.stations[s, 2]
            left = now.toa[s, lane] - np.sqrt(dx * dx + dy * dy + dz * dz)
            report.residual[k, s, lane] = left
            mean[lane] += now.used[s, lane] * left
    for s in range(n_stations):
        for lane in range(lanes):
            there = now.used[s, lane] > 0.0 and now.receptions[lane] >= 2
            report.residual[k, s, lane] -= mean[lane] / max(now.receptions[lane], 1)
            report.residual[k, s, lane] *= now.shown[lane] if there else np.nan
            report.used[k, s, lane] = now.took[lane] == 1 and there


@kernel
def filter_marks(marks, setup, track, now, rows, report, first, stop):
    """Run marks first <= k < stop of every lane through the filter.

    Parameters
    ----------
    marks : Marks, L <= LANES lanes, each with its own times: trials of one target, or targets of one trial
    setup : Setup
    track : Track, changed in place
    now, rows : Now, Rows
        Workspace.
    report : Report, filled for these marks
    first, stop : int
    """
    lanes = marks.toa.shape[2]
    for k in range(first, stop):
        gate = marks.time[k]
        _read_mark(k, marks, setup, now)
        _elapse(lanes, gate, setup, track, now)
        rivals = 0
        for lane in range(lanes):
            rivals += track.rival[lane]
        predict_jerk(track.x[0], track.p[0], now.elapsed, setup.sigma_jerk, setup.noise_form)
        if rivals > 0:
            predict_jerk(track.x[1], track.p[1], now.elapsed, setup.sigma_jerk, setup.noise_form)
        for lane in range(LANES):
            track.time[lane] += now.elapsed[lane]
            for a in range(3):
                now.at[a, lane] = track.x[0, 3 * a, lane]
        decide(lanes, gate, setup, track, now)
        # One place that measures, so that it is compiled once: first the tracks, then their rivals.
        for which in range(2 if rivals > 0 else 1):
            if which == 1:
                _turn_to_rivals(lanes, track, now)
            _measure(which, setup, track, now, now.go if which == 0 else now.rival_go, rows)
        if rivals > 0:
            _settle_rivals(lanes, track, now)
        _conclude(lanes, setup, track, now)
        _write(k, lanes, setup, track, now, report)
