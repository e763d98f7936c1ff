"""How a lane starts a track, restarts it, or decides where to linearise a mark (specification 5, steps 1, 2, 4)."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.fix import residual_rms, solve_mark
from algorithms.multilateration.lanes import (
    CLAIM_SHARE_OF_RANGE,
    IMPOSSIBLE_TOA,
    INITIALISED,
    NOT_INITIALISED,
    R_CLAIM,
    R_FEW,
    R_FIX,
    R_INCONSISTENT,
    R_NO_SOLUTION,
    R_NO_START,
    R_NONE,
    R_RESIDUAL,
    R_SPREAD,
    R_TWO,
    REINITIALISED,
    REJECTED_TIME,
    RESIDUAL_GATE,
    RESTART_SIGMA,
    STALE_S,
    START_ACCELERATION_SD_MPS2,
    START_VELOCITY_SD_MPS,
    VELOCITY_UNKNOWN_MPS,
)
from algorithms.toolbox.kernels import inlined, kernel
from algorithms.toolbox.kernels.symmetric import position_block, solve3
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS


@kernel
def emission_offset(px, py, pz, toa_m, used, stations, lane):
    """Emission time after the gate's start, s, from a position and the receptions of one lane; NaN without any."""
    n = 0
    total = 0.0
    for s in range(stations.shape[0]):
        if used[s, lane] > 0.0:
            dx = px - stations[s, 0]
            dy = py - stations[s, 1]
            dz = pz - stations[s, 2]
            total += toa_m[s, lane] - np.sqrt(dx * dx + dy * dy + dz * dz)
            n += 1
    return total / (n * SPEED_OF_LIGHT_MPS) if n > 0 else np.nan


@kernel
def _start(lane, which, track, position, covariance):
    """Put a fix into a lane: its covariance, unknown velocity and acceleration."""
    for i in range(9):
        track.x[which, i, lane] = 0.0
    for k in range(45):
        track.p[which, k, lane] = 0.0
    for a in range(3):
        i = 3 * a
        track.x[which, i, lane] = position[a]
        for b in range(a + 1):
            track.p[which, i * (i + 1) // 2 + 3 * b, lane] = covariance[a * (a + 1) // 2 + b]
        v = i + 1
        track.p[which, v * (v + 1) // 2 + v, lane] = START_VELOCITY_SD_MPS**2
        v = i + 2
        track.p[which, v * (v + 1) // 2 + v, lane] = START_ACCELERATION_SD_MPS2**2
    track.cost[which, lane] = 0.0


@kernel
def drop(lane, track):
    """End a lane's track and leave the lane harmless."""
    track.live[lane] = 0
    track.rival[lane] = 0
    track.suspect[lane] = 0
    track.window_fill[lane] = 0
    for which in range(2):
        for i in range(9):
            track.x[which, i, lane] = 0.0
            for j in range(i + 1):
                track.p[which, i * (i + 1) // 2 + j, lane] = 1.0 if i == j else 0.0


@kernel
def claim_too_large(lane, setup, track):
    """Whether the claimed horizontal error exceeds the tolerated share of the range."""
    drms2 = track.p[0, 0, lane] + track.p[0, 9, lane]
    far2 = 0.0
    for a in range(3):
        far2 += (track.x[0, 3 * a, lane] - setup.middle[a]) ** 2
    far2 = max(far2, setup.radius_of_site**2)
    return not drms2 <= CLAIM_SHARE_OF_RANGE**2 * far2


@kernel
def _mahalanobis2(lane, track, position, covariance):
    """Squared distance between the predicted position of a lane and a fix, in units of their joint covariance."""
    s = np.empty(6)
    position_block(track.p[0], 3, lane, s)
    diff = np.empty(3)
    solved = np.empty(3)
    for k in range(6):
        s[k] += covariance[k]
    for a in range(3):
        diff[a] = position[a] - track.x[0, 3 * a, lane]
    if not solve3(s, diff, solved):
        return np.inf
    return diff[0] * solved[0] + diff[1] * solved[1] + diff[2] * solved[2]


@kernel
def _solve_lane(lane, setup, now):
    """One-mark fix of a lane into `now.fix_*`: (number of solutions, reason where it is 0)."""
    n_stations = setup.stations.shape[0]
    work = now.work
    for s in range(n_stations):
        work[0, s] = now.toa[s, lane]
        work[1, s] = now.used[s, lane]
    height = now.altitude[lane] if now.has_altitude[lane] > 0.0 else np.nan
    known = 1 if now.has_altitude[lane] > 0.0 else 0
    count = now.receptions[lane]
    if count + known < 4 or count < 3:
        return 0, R_NO_START
    n = solve_mark(
        work[0],
        work[1],
        setup.stations,
        setup.variance,
        height,
        setup.altitude_variance,
        setup.earth,
        setup.earth_centre,
        setup.earth_radius,
        now.fix_position,
        now.fix_covariance,
        now.fix_cost,
    )
    if n == 0:
        return 0, R_NO_SOLUTION
    if count + known > 4:
        kept = 0
        for j in range(n):
            rms = residual_rms(now.fix_position[j], work[0], work[1], setup.stations, work[2])
            if rms <= setup.residual_gate_m:
                if kept != j:
                    now.fix_position[kept] = now.fix_position[j]
                    now.fix_covariance[kept] = now.fix_covariance[j]
                kept += 1
        if kept == 0:
            return 0, R_RESIDUAL
        n = kept
    return n, R_NONE


@kernel
def _begin(lane, gate, setup, track, now, first, n):
    """Start a lane from solution `first` of the mark; a second solution becomes its rival."""
    _start(lane, 0, track, now.fix_position[first], now.fix_covariance[first])
    track.rival[lane] = 0
    if n == 2:
        _start(lane, 1, track, now.fix_position[1 - first], now.fix_covariance[1 - first])
        track.rival[lane] = 1
    offset = 0.0
    if setup.robust:
        p = now.fix_position[first]
        offset = emission_offset(p[0], p[1], p[2], now.toa, now.used, setup.stations, lane)
    track.time[lane] = gate + offset
    track.last_update[lane] = track.time[lane]
    track.live[lane] = 1
    track.suspect[lane] = 0
    track.window_fill[lane] = 0


@kernel
def _try_start(lane, gate, setup, track, now):
    """Start a track in a lane that has none, or say why not."""
    n, why = _solve_lane(lane, setup, now)
    if n == 0:
        now.status[lane] = RESIDUAL_GATE if why == R_RESIDUAL else NOT_INITIALISED
        now.reason[lane] = why
        return
    _begin(lane, gate, setup, track, now, 0, n)
    if setup.robust and claim_too_large(lane, setup, track):
        drop(lane, track)
        now.status[lane] = NOT_INITIALISED
        now.reason[lane] = R_CLAIM
        return
    track.started[lane] += 1
    track.number[lane] = track.started[lane]
    now.status[lane] = INITIALISED
    now.reason[lane] = R_TWO if n == 2 else R_NONE


@kernel
def _solve_anew(lane, gate, setup, track, now):
    """Hold a track whose linearisation cannot be trusted against the mark's own fix; True where that ends the mark."""
    n, why = _solve_lane(lane, setup, now)
    if why == R_RESIDUAL:
        now.status[lane] = RESIDUAL_GATE
        now.reason[lane] = why
        return True
    if n == 0:
        now.iterate[lane] = 1
        return False
    best = 0
    d2 = _mahalanobis2(lane, track, now.fix_position[0], now.fix_covariance[0])
    if n == 2:
        other = _mahalanobis2(lane, track, now.fix_position[1], now.fix_covariance[1])
        if other < d2:
            best = 1
            d2 = other
    if d2 > RESTART_SIGMA**2 or track.suspect[lane] == 1:
        now.reason[lane] = R_INCONSISTENT if track.suspect[lane] == 1 else R_FIX
        now.status[lane] = REINITIALISED
        _begin(lane, gate, setup, track, now, best, 1)
        return True
    for a in range(3):
        now.at[a, lane] = now.fix_position[best, a]
    return False


@inlined
def decide(lanes, gate, setup, track, now):
    """Decide what each lane does with the mark: start, restart, update (and where to linearise), or nothing."""
    for lane in range(lanes):
        if now.status[lane] == REJECTED_TIME:
            continue
        if now.possible[lane] == 0:
            now.status[lane] = IMPOSSIBLE_TOA
            now.reason[lane] = R_SPREAD
            continue
        if track.live[lane] == 0:
            _try_start(lane, gate, setup, track, now)
            continue
        unknown = (
            track.p[0, 2, lane] > VELOCITY_UNKNOWN_MPS**2
            or track.p[0, 14, lane] > VELOCITY_UNKNOWN_MPS**2
            or track.time[lane] - track.last_update[lane] > STALE_S
            or track.suspect[lane] == 1
        )
        if setup.robust and unknown and track.rival[lane] == 0 and _solve_anew(lane, gate, setup, track, now):
            continue
        if now.receptions[lane] >= 2 or now.has_altitude[lane] > 0.0:
            now.go[lane] = 1.0
        else:
            now.reason[lane] = R_FEW
