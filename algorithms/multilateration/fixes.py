"""Every mark of a recording solved by itself: the compiled loop and its arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration import lanes
from algorithms.multilateration.begin import emission_offset
from algorithms.multilateration.conditions import Conditions
from algorithms.multilateration.fix import residual_rms, solve_mark
from algorithms.multilateration.mark_at_hand import impossible_reception
from algorithms.recording import ToaMarks
from algorithms.spec import RunContext
from algorithms.toolbox.kernels import kernel
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

# Marks in one call of the kernel: some 50 ms, so that a cancel is seen soon.
SLICE_MARKS = 1_000


@kernel
def solve_marks(
    time,
    toa,
    altitude,
    stations,
    variance,
    spread_limit,
    altitude_variance,
    earth,
    centre,
    radius,
    gate_m,
    first,
    stop,
    out_time,
    position,
    covariance,
    roots,
    status,
    reason,
    used_out,
    altitude_used,
    residual,
    cost_out,
    dof,
):
    """Solve marks first <= k < stop of every trial; arrays as in `OUTPUTS`, positions and covariances apart."""
    n_stations, trials = toa.shape[1], toa.shape[2]
    toa_m = np.empty(n_stations)
    used = np.empty(n_stations)
    left = np.empty(n_stations)
    p = np.empty((2, 3))
    c = np.empty((2, 6))
    cost = np.empty(2)
    lane_toa = np.empty((n_stations, 1))
    lane_used = np.empty((n_stations, 1))
    for k in range(first, stop):
        for trial in range(trials):
            count = 0
            for s in range(n_stations):
                value = toa[k, s, trial]
                here = np.isfinite(value)
                toa_m[s] = SPEED_OF_LIGHT_MPS * value if here else 0.0
                used[s] = 1.0 if here else 0.0
                count += 1 if here else 0
            wrong = -1
            possible = True
            for s in range(n_stations):
                for q in range(s):
                    if used[s] * used[q] * abs(toa_m[s] - toa_m[q]) > spread_limit[s, q]:
                        possible = False
            if not possible:
                wrong = impossible_reception(toa_m, used, spread_limit)
                if wrong >= 0:
                    used[wrong] = 0.0
                    count -= 1
                    possible = True
            height = altitude[k, trial]
            known = 1 if np.isfinite(height) else 0
            if known == 0:
                height = np.nan
            if not possible:
                status[k, trial] = lanes.IMPOSSIBLE_TOA
                reason[k, trial] = lanes.R_SPREAD
                continue
            if count < 3 or count + known < 4:
                reason[k, trial] = lanes.R_NO_START
                continue
            n = solve_mark(
                toa_m, used, stations, variance, height, altitude_variance, earth, centre, radius, p, c, cost
            )
            if n <= 0:
                reason[k, trial] = lanes.R_HEIGHT if n < 0 else lanes.R_NO_SOLUTION
                continue
            rms = residual_rms(p[0], toa_m, used, stations, left)
            for s in range(n_stations):
                residual[k, s, trial] = left[s]
            if rms > gate_m:
                status[k, trial] = lanes.RESIDUAL_GATE
                reason[k, trial] = lanes.R_RESIDUAL
                continue
            for s in range(n_stations):
                used_out[k, s, trial] = used[s] > 0.0
                lane_toa[s, 0] = toa_m[s]
                lane_used[s, 0] = used[s]
            altitude_used[k, trial] = known == 1
            offset = emission_offset(p[0, 0], p[0, 1], p[0, 2], lane_toa, lane_used, stations, 0)
            out_time[k, trial] = time[k] + offset
            if n == 2:
                for root in range(2):
                    for a in range(3):
                        roots[k, root, a, trial] = p[root, a]
            else:
                for a in range(3):
                    position[k, a, trial] = p[0, a]
                for i in range(6):
                    covariance[k, i, trial] = c[0, i]
            dof[k, trial] = count + known - 4
            if count + known > 4:
                cost_out[k, trial] = cost[0]
            status[k, trial] = lanes.AMBIGUOUS if n == 2 else lanes.UPDATED
            plain = lanes.R_LEFT_IMPOSSIBLE if wrong >= 0 else lanes.R_NONE
            reason[k, trial] = lanes.R_TWO if n == 2 else plain


def solve_recording(
    recording: ToaMarks,
    conditions: Conditions,
    toa: NDArray[np.float64],
    altitude: NDArray[np.float64],
    context: RunContext,
) -> dict[str, NDArray[np.generic]]:
    """Arrays of the one-mark solution (see `single_mark`) of times of arrival (M, S, L) s and altitudes (M, L) m."""
    marks, stations, trials = toa.shape
    report = lanes.new_report(marks, stations, trials, covariance="position")
    position = np.full((marks, 3, trials), np.nan)
    roots = np.full((marks, 2, 3, trials), np.nan)
    for first in range(0, marks, SLICE_MARKS):
        context.check_cancelled()
        stop = min(first + SLICE_MARKS, marks)
        solve_marks(
            recording.time_s,
            toa,
            altitude,
            conditions.stations,
            conditions.variance,
            conditions.spread_limit,
            conditions.sigma_altitude_m**2,
            conditions.earth,
            conditions.earth_centre,
            conditions.earth_radius,
            conditions.residual_gate_m,
            first,
            stop,
            report.time,
            position,
            report.covariance,
            roots,
            report.status,
            report.reason,
            report.used,
            report.altitude_used,
            report.residual,
            report.nis,
            report.dof,
        )
        context.progress(stop / marks)
    report.state[:, [0, 3, 6]] = position
    # A mark is its own track of one: tracks are numbered by target, so that a chart can tell targets apart.
    report.track[:] = np.where(np.isfinite(position[:, 0]), recording.target[:, None] + 1, 0)
    return {
        "row": recording.row,
        "target": recording.target,
        "time_s": report.time,
        "state": report.state,
        "covariance": report.covariance,
        "track": report.track,
        "status": report.status,
        "reason": report.reason,
        "nis": report.nis,
        "dof": report.dof,
        "used": report.used,
        "altitude_used": report.altitude_used,
        "residual_m": report.residual,
        "roots_m": roots,
    }
