"""What is kept of a mark: the report's rows, and more where not only scores are wanted."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.lanes import INITIALISED, NOT_INITIALISED, REINITIALISED, REJECTED_TIME
from algorithms.toolbox.kernels import LANES, inlined, kernel


@inlined
def look_at(lanes, live, status, go, shown, took):
    """Note in which lanes there is an estimate to show, and which took the mark. One array is written at a time."""
    for lane in range(lanes):
        shown[lane] = 1.0 if (live[lane] == 1) & (status[lane] != REJECTED_TIME) else np.nan
    for lane in range(lanes):
        entered = (go[lane] > 0.0) | (status[lane] == INITIALISED) | (status[lane] == REINITIALISED)
        took[lane] = 1 if entered & (shown[lane] > 0.0) else 0


@inlined
def copy_row(k, lanes, values, out):
    """Report what every lane has."""
    for lane in range(lanes):
        out[k, lane] = values[lane]


@inlined
def copy_shown(k, lanes, values, shown, out):
    """Report whole numbers of the lanes that are shown, 0 elsewhere."""
    for lane in range(lanes):
        out[k, lane] = values[lane] if shown[lane] > 0.0 else 0


@inlined
def write_scores(k, lanes, times, nis, dof, took, has_altitude, shown, time_out, nis_out, used_out):
    """Report time, NIS, and whether the altitude entered."""
    for lane in range(lanes):
        time_out[k, lane] = times[lane] * shown[lane]
    for lane in range(lanes):
        nis_out[k, lane] = nis[lane] if (shown[lane] > 0.0) & (dof[lane] > 0) else np.nan
    for lane in range(lanes):
        used_out[k, lane] = (took[lane] == 1) & (has_altitude[lane] > 0.0)


@inlined
def write_state(k, lanes, x, p, shown, state, covariance):
    """Report state and covariance, whole or of the position alone, row by row."""
    for i in range(9):
        for lane in range(lanes):
            state[k, i, lane] = x[i, lane] * shown[lane]
    if covariance.shape[1] == 6:
        for a in range(3):
            for b in range(a + 1):
                i = 3 * a * (3 * a + 1) // 2 + 3 * b
                for lane in range(lanes):
                    covariance[k, a * (a + 1) // 2 + b, lane] = p[i, lane] * shown[lane]
    else:
        for i in range(45):
            for lane in range(lanes):
                covariance[k, i, lane] = p[i, lane] * shown[lane]


@inlined
def write_rivals(k, lanes, track, shown, covariance):
    """Where another position may still be the true one, claim the mean square about the likelier.

    With w the rival's probability and d its distance, P = (1 - w) P_0 + w (P_1 + d d').
    """
    whole = covariance.shape[1] == 45
    for lane in range(lanes):
        if track.rival[lane] == 1:
            apart = min(max(track.cost[1, lane] - track.cost[0, lane], 0.0), 100.0)
            w = 1.0 / (1.0 + np.exp(0.5 * apart))
            for i in range(9):
                for j in range(i + 1):
                    if whole or (i % 3 == 0 and j % 3 == 0):
                        q = i * (i + 1) // 2 + j
                        d = (track.x[1, i, lane] - track.x[0, i, lane]) * (track.x[1, j, lane] - track.x[0, j, lane])
                        value = (1.0 - w) * track.p[0, q, lane] + w * (track.p[1, q, lane] + d)
                        at = q if whole else (i // 3) * (i // 3 + 1) // 2 + j // 3
                        covariance[k, at, lane] = value * shown[lane]


@kernel
def write_more(k, lanes, setup, track, now, report):
    """Starts in vain, receptions and residuals."""
    for lane in range(lanes):
        waiting = now.status[lane] == NOT_INITIALISED and track.gathered.kept[lane] > 0
        report.start_error[k, lane] = track.gathered.error[lane] if waiting else np.nan
    _write_receptions(k, lanes, setup, track, now, report)


@kernel
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
