"""How a lane starts a track, restarts it, or decides where to linearise a mark (specification 5)."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.accumulate import forget, remember, try_together
from algorithms.multilateration.fix import (
    HEIGHT_SIGMAS,
    HIGHEST_ALTITUDE_M,
    LOWEST_ALTITUDE_M,
    residual_rms,
    solve_mark,
)
from algorithms.multilateration.lanes import (
    CLAIM_SHARE_OF_RANGE,
    IMPOSSIBLE_TOA,
    INITIALISED,
    KNOWN_ALTITUDE_SD_M,
    NOT_INITIALISED,
    R_CLAIM,
    R_FEW,
    R_FIX,
    R_HEIGHT,
    R_INCONSISTENT,
    R_LEFT_DOUBTFUL,
    R_LEFT_IMPOSSIBLE,
    R_NO_SOLUTION,
    R_NO_START,
    R_NONE,
    R_RESIDUAL,
    R_SPREAD,
    R_TOGETHER,
    R_TWO,
    REINITIALISED,
    REJECTED_TIME,
    RESIDUAL_GATE,
    RESTART_SIGMA,
    STALE_S,
    START_ACCELERATION_SD_MPS2,
    START_VELOCITY_SD_MPS,
    STRAIGHT_ACCELERATION_SD_MPS2,
    VELOCITY_UNKNOWN_MPS,
)
from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import inlined, kernel, strict
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
def reason_of_spread(left):
    """Why a reception was left out before anything was computed, where one was."""
    return R_LEFT_IMPOSSIBLE if left > 0 else R_LEFT_DOUBTFUL if left < 0 else R_NONE


@kernel
def impossible_height(lane, setup, track):
    """Whether the track lies where nothing flies, by more than its height's error."""
    z = track.x[0, 6, lane]
    if z > LOWEST_ALTITUDE_M and z < 0.5 * HIGHEST_ALTITUDE_M:
        return False
    spread = HEIGHT_SIGMAS * np.sqrt(max(track.p[0, 27, lane], 0.0))
    h, _, _, _ = height_and_up(track.x[0, 0, lane], track.x[0, 3, lane], z, setup.earth)
    return h < LOWEST_ALTITUDE_M - spread or h > HIGHEST_ALTITUDE_M + spread


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
    extra = now.altitude_extra[lane]
    known = 1 if now.has_altitude[lane] > 0.0 and extra < KNOWN_ALTITUDE_SD_M**2 else 0
    height = now.altitude[lane] if known == 1 else np.nan
    count = now.receptions[lane]
    if count + known < 4 or count < 3:
        return 0, R_NO_START
    n = solve_mark(
        work[0],
        work[1],
        setup.stations,
        setup.variance,
        height,
        setup.altitude_variance + (extra if known == 1 else 0.0),
        setup.earth,
        setup.earth_centre,
        setup.earth_radius,
        now.fix_position,
        now.fix_covariance,
        now.fix_cost,
    )
    if n <= 0:
        return 0, R_HEIGHT if n < 0 else R_NO_SOLUTION
    # With as many data as unknowns there is a residual too, where no place explains them: the fix lies in the stations'
    # plane then, as near as it gets.
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
    _go_live(lane, gate + offset, track)


@kernel
def _go_live(lane, time, track):
    track.time[lane] = time
    track.last_update[lane] = time
    track.live[lane] = 1
    track.suspect[lane] = 0
    track.window_fill[lane] = 0


@strict
def _place_flight(lane, setup, track, theta, covariance):
    """Put the fitted flight into a lane, with its whole covariance."""
    z = 0.0
    gx = 0.0
    gy = 0.0
    gz = 1.0
    for _ in range(4):
        h, gx, gy, gz = height_and_up(theta[0], theta[3], z, setup.earth)
        z += (theta[6] - h) / gz
    # How z and vz follow from theta: the altitude is h(x, y, z), the climb its change.
    rows = np.zeros((9, 8))
    for i in range(6):
        rows[i, i] = 1.0
    for i in range(2):
        rows[6 + i, i] = -gx / gz
        rows[6 + i, 3 + i] = -gy / gz
        rows[6 + i, 6 + i] = 1.0 / gz
    for r in range(9):
        for q in range(r + 1):
            total = 0.0
            for a in range(8):
                for b in range(8):
                    high = max(a, b)
                    total += rows[r, a] * rows[q, b] * covariance[high * (high + 1) // 2 + min(a, b)]
            track.p[0, r * (r + 1) // 2 + q, lane] = total
    track.p[0, 44, lane] = STRAIGHT_ACCELERATION_SD_MPS2**2
    for i in range(6):
        track.x[0, i, lane] = theta[i]
    track.x[0, 6, lane] = z
    track.x[0, 7, lane] = (theta[7] - gx * theta[1] - gy * theta[4]) / gz
    track.x[0, 8, lane] = 0.0
    track.cost[0, lane] = 0.0
    track.rival[lane] = 0


@kernel
def _try_start_together(lane, gate, setup, track, now):
    """Start a track from the marks gathered so far, or say why not."""
    remember(lane, gate, setup, track, now)
    why = try_together(lane, setup, track, now.flight, now.flight_covariance)
    if why != R_NONE:
        now.status[lane] = NOT_INITIALISED
        now.reason[lane] = why
        return
    _place_flight(lane, setup, track, now.flight, now.flight_covariance)
    x = track.x
    offset = emission_offset(x[0, 0, lane], x[0, 3, lane], x[0, 6, lane], now.toa, now.used, setup.stations, lane)
    _go_live(lane, gate + offset, track)
    _count_start(lane, track)
    now.status[lane] = INITIALISED
    now.reason[lane] = R_TOGETHER


@kernel
def _count_start(lane, track):
    track.started[lane] += 1
    track.number[lane] = track.started[lane]
    forget(lane, track)


@kernel
def _try_start(lane, gate, setup, track, now):
    """Start a track in a lane that has none, or say why not."""
    gathers = track.gathered.gate.shape[1] > 0 and now.receptions[lane] >= 2
    n, why = _solve_lane(lane, setup, now)
    if n == 0:
        if gathers and why != R_RESIDUAL and why != R_HEIGHT:
            _try_start_together(lane, gate, setup, track, now)
            return
        now.status[lane] = RESIDUAL_GATE if why == R_RESIDUAL else NOT_INITIALISED
        now.reason[lane] = why
        return
    _begin(lane, gate, setup, track, now, 0, n)
    if setup.robust and claim_too_large(lane, setup, track):
        drop(lane, track)
        if gathers:
            _try_start_together(lane, gate, setup, track, now)
            return
        now.status[lane] = NOT_INITIALISED
        now.reason[lane] = R_CLAIM
        return
    _count_start(lane, track)
    now.status[lane] = INITIALISED
    now.reason[lane] = R_TWO if n == 2 else reason_of_spread(now.spread_left[lane])


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
def count_followed(lanes, robust, p, times, last_update, suspect, live, status, possible, receptions, has_altitude):
    """How many lanes are on their track and take the mark: mostly all of them, and there is nothing to decide."""
    count = 0
    for lane in range(lanes):
        known = (p[2, lane] <= VELOCITY_UNKNOWN_MPS**2) & (p[14, lane] <= VELOCITY_UNKNOWN_MPS**2)
        known &= (times[lane] - last_update[lane] <= STALE_S) & (suspect[lane] == 0)
        followed = (live[lane] == 1) & (status[lane] != REJECTED_TIME) & (possible[lane] == 1)
        heard = (receptions[lane] >= 2) | (has_altitude[lane] > 0.0)
        count += 1 if followed & heard & ((not robust) | known) else 0
    return count


@kernel
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
            _try_start(lane, gate[lane], setup, track, now)
            continue
        unknown = (
            track.p[0, 2, lane] > VELOCITY_UNKNOWN_MPS**2
            or track.p[0, 14, lane] > VELOCITY_UNKNOWN_MPS**2
            or track.time[lane] - track.last_update[lane] > STALE_S
            or track.suspect[lane] == 1
        )
        if setup.robust and unknown and track.rival[lane] == 0 and _solve_anew(lane, gate[lane], setup, track, now):
            continue
        if now.receptions[lane] >= 2 or now.has_altitude[lane] > 0.0:
            now.go[lane] = 1.0
        else:
            now.reason[lane] = R_FEW
