"""The mark at hand, lane by lane: what was received, and how long after the state it comes."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.begin import drop, emission_offset
from algorithms.multilateration.lanes import (
    COAST,
    GAP_S,
    R_NONE,
    R_OLD,
    REJECTED_TIME,
)
from algorithms.toolbox.kernels import LANES, inlined, kernel
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

# A station whose reception was impossible is believed less for so many marks, and not at all from this doubt on: two
# within four marks begin it, ten in a row last for half a minute of marks a second apart.
DOUBT_GAIN = 4
DOUBT_LIMIT = 8
DOUBT_MOST = 40


@inlined
def read_mark(k, marks, setup, track, now):
    """Copy one mark into the lanes: finite receptions, altitude, and whether its spread is possible."""
    n_stations = setup.stations.shape[0]
    lanes = marks.toa.shape[2]
    for lane in range(LANES):
        now.receptions[lane] = 0
        now.possible[lane] = 1
        now.has_altitude[lane] = 0.0
        now.altitude[lane] = 0.0
        now.altitude_extra[lane] = 0.0
        now.altitude_biased[lane] = 0.0
        now.spread_left[lane] = 0
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
                apart = both * abs(now.toa[s, lane] - now.toa[q, lane])
                now.possible[lane] = 0 if apart > limit else now.possible[lane]
    if setup.robust:
        for lane in range(lanes):
            if now.possible[lane] == 0:
                _leave_impossible_out(lane, setup, track, now)
        doubted = 0
        for s in range(n_stations):
            for lane in range(lanes):
                doubted += track.doubt[s, lane]
        if doubted > 0:
            for lane in range(lanes):
                _leave_doubtful_out(lane, track, now)
    if setup.use_altitude:
        for lane in range(lanes):
            value = marks.altitude[k, lane]
            here = np.isfinite(value)
            now.altitude[lane] = value if here else 0.0
            now.has_altitude[lane] = 1.0 if here else 0.0
            now.altitude_extra[lane] = marks.altitude_extra[k, lane]
            now.altitude_biased[lane] = marks.altitude_biased[k, lane]


@kernel
def impossible_reception(toa_m, used, spread_limit):
    """Station without whose reception the others can be one pulse: -1 where there is none, or not one alone.

    toa_m, used : (S,). Every impossible pair must have the station in it. One impossible pair alone has two: then the
    later is meant, for a reflected pulse is late and never early, and the others must be two at least beside it.
    """
    n = toa_m.shape[0]
    count = 0
    for s in range(n):
        count += 1 if used[s] > 0.0 else 0
    if count < 3:
        return -1
    found = -1
    for j in range(n):
        if used[j] == 0.0:
            continue
        alone = True
        for s in range(n):
            for q in range(s):
                if s != j and q != j and used[s] * used[q] * abs(toa_m[s] - toa_m[q]) > spread_limit[s, q]:
                    alone = False
        if alone:
            if found >= 0 and (count < 4 or toa_m[j] < toa_m[found]):
                if count < 4:
                    return -1
                continue
            found = j
    return found


@kernel
def _leave_impossible_out(lane, setup, track, now):
    """Leave the one reception out of a lane's mark that makes its spread impossible, where there is one."""
    n = setup.stations.shape[0]
    toa = np.empty(n)
    used = np.empty(n)
    for s in range(n):
        toa[s] = now.toa[s, lane]
        used[s] = now.used[s, lane]
    found = impossible_reception(toa, used, setup.spread_limit)
    if found >= 0:
        now.used[found, lane] = 0.0
        now.receptions[lane] -= 1
        now.possible[lane] = 1
        now.spread_left[lane] = found + 1
        track.doubt[found, lane] = min(track.doubt[found, lane] + DOUBT_GAIN, DOUBT_MOST)


@kernel
def _leave_doubtful_out(lane, track, now):
    """Leave the reception of the station out that was impossible lately, where three others remain.

    A clock that has jumped is not impossible from every side: in between its receptions would pull the track away,
    which without an altitude nothing else notices.
    """
    worst = -1
    for s in range(now.used.shape[0]):
        if now.used[s, lane] > 0.0 and track.doubt[s, lane] > 0:
            if track.doubt[s, lane] >= DOUBT_LIMIT and (worst < 0 or track.doubt[s, lane] > track.doubt[worst, lane]):
                worst = s
            track.doubt[s, lane] -= 1
    if worst >= 0 and now.receptions[lane] >= 4 and now.spread_left[lane] == 0:
        now.used[worst, lane] = 0.0
        now.receptions[lane] -= 1
        now.spread_left[lane] = -worst - 1


@inlined
def elapse_to_gate(k, lanes, gate, gates, times, live, elapsed, status, reason):
    """Time from each state to mark k; reject what is older. The article filters at the gate's time, `gate` (M, L)."""
    # Without a branch, and one array written at a time: the compiler puts the lanes side by side only where it can tell
    # that arrays do not overlap, and it gives up on many.
    for lane in range(lanes):
        at = gate[k, lane]
        t = at - times[lane]
        runs = np.isfinite(at) & (at >= gates[lane]) & (live[lane] == 1) & (t > 0.0)
        elapsed[lane] = t if runs else 0.0
    for lane in range(lanes):
        status[lane] = COAST if np.isfinite(gate[k, lane]) & (gate[k, lane] >= gates[lane]) else REJECTED_TIME
    for lane in range(lanes):
        reason[lane] = R_NONE if np.isfinite(gate[k, lane]) & (gate[k, lane] >= gates[lane]) else R_OLD
    for lane in range(lanes):
        at = gate[k, lane]
        gates[lane] = at if np.isfinite(at) & (at >= gates[lane]) else gates[lane]


@inlined
def elapse_to_emission(lanes, gate, setup, track, now):
    """Time from each state to this mark; reject what is older, close what has coasted too long.

    The robust profile filters at the emission, estimated with the predicted position.
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
        px = x[0, 0, lane] + t * (x[0, 1, lane] + 0.5 * t * x[0, 2, lane])
        py = x[0, 3, lane] + t * (x[0, 4, lane] + 0.5 * t * x[0, 5, lane])
        pz = x[0, 6, lane] + t * (x[0, 7, lane] + 0.5 * t * x[0, 8, lane])
        offset = np.nan
        if now.possible[lane] == 1:
            offset = emission_offset(px, py, pz, now.toa, now.used, setup.stations, lane)
        t += offset if np.isfinite(offset) else setup.gate_centre_s
        t = max(t, 0.0)
        if track.time[lane] + t - track.last_update[lane] > GAP_S:
            drop(lane, track)
            t = 0.0
        now.elapsed[lane] = t
