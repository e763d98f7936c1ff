"""What became of a mark in each lane: status, consistency over twenty marks, tracks that have lost their way."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.begin import claim_too_large, drop, impossible_height, reason_of_spread
from algorithms.multilateration.lanes import (
    ALTITUDE_ONLY,
    AMBIGUOUS,
    DOWNWEIGHTED,
    EIGENVALUE_FLOOR,
    INCONSISTENT_RATIO,
    NOT_INITIALISED,
    R_CLAIM,
    R_FEW,
    R_HEIGHT,
    R_REPAIRED,
    R_SCALED,
    R_SINGULAR,
    R_TWO,
    SINGULAR,
    UPDATED,
    WINDOW_CAP,
    WINDOW_MARKS,
)
from algorithms.toolbox.kernels import inlined, kernel

# A height that is known to this is told by the marks; one that lies below the ground says that they lie.
TOLD_HEIGHT_SD_M = 200.0


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
def count_sound(lanes, x, p, go, rival):
    """How many lanes took the mark, have no rival, and hold a finite state and positive variances."""
    count = 0
    for lane in range(lanes):
        # Nothing times an infinity or a NaN is NaN.
        nothing = 0.0 * x[0, lane] + 0.0 * x[1, lane] + 0.0 * x[2, lane]
        nothing += 0.0 * x[3, lane] + 0.0 * x[4, lane] + 0.0 * x[5, lane]
        nothing += 0.0 * x[6, lane] + 0.0 * x[7, lane] + 0.0 * x[8, lane]
        positive = (p[0, lane] > 0.0) & (p[2, lane] > 0.0) & (p[5, lane] > 0.0)
        positive &= (p[9, lane] > 0.0) & (p[14, lane] > 0.0) & (p[20, lane] > 0.0)
        positive &= (p[27, lane] > 0.0) & (p[35, lane] > 0.0) & (p[44, lane] > 0.0)
        plain = (go[lane] > 0.0) & (rival[lane] == 0)
        count += 1 if plain & (nothing == 0.0) & positive else 0
    return count


@inlined
def conclude_plainly(lanes, receptions, has_altitude, times, dof, last_update, status, reason):
    """What `conclude` does in the article's profile where all lanes are sound. One array is written at a time."""
    for lane in range(lanes):
        known = 1 if has_altitude[lane] > 0.0 else 0
        more = receptions[lane] - 1
        dof[lane] = (more if more > 0 else 0) + known
    for lane in range(lanes):
        last_update[lane] = times[lane]
    for lane in range(lanes):
        status[lane] = ALTITUDE_ONLY if receptions[lane] < 2 else UPDATED
    for lane in range(lanes):
        reason[lane] = R_FEW if receptions[lane] < 2 else reason[lane]


@kernel
def conclude(lanes, setup, track, now):
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
                now.reason[lane] = (
                    reason_of_spread(now.spread_left[lane]) if now.spread_left[lane] != 0 else now.reason[lane]
                )
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
        elif setup.robust and track.live[lane] == 1 and impossible_height(lane, setup, track):
            now.reason[lane] = R_HEIGHT
            # Where marks tell no height it may wander, while the place in the plan is as good as claimed.
            if track.p[0, 27, lane] < TOLD_HEIGHT_SD_M**2:
                drop(lane, track)
                now.status[lane] = NOT_INITIALISED
