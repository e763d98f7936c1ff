"""Update tracks with the rows of a mark; where two positions explain the data, the second hypothesis too."""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.joint_update import update_jointly
from algorithms.multilateration.lanes import EKF, RELINEARISATIONS, RIVAL_COST_GAP, SCALE_FROM_SIGMA
from algorithms.toolbox.kernels import LANES, inlined, kernel
from algorithms.toolbox.kernels.unrolled import update_rows_3, update_rows_9
from algorithms.toolbox.sensors.altitude import altitude_row
from algorithms.toolbox.sensors.time_of_arrival import contrast_rows


@inlined
def _build_rows(setup, now, go, x, rows):
    """All rows of the mark: S contrasts and, last, the altitude."""
    n_stations = setup.stations.shape[0]
    contrast_rows(
        now.toa,
        now.used,
        setup.stations,
        setup.variance,
        now.at,
        x,
        3,
        rows.h,
        rows.nu,
        rows.variance,
        rows.active,
        rows.sums,
    )
    altitude_row(now.altitude, now.at, x, 3, setup.earth, rows.h[n_stations], rows.nu[n_stations])
    for lane in range(LANES):
        rows.variance[n_stations, lane] = setup.altitude_variance + now.altitude_extra[lane]
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
def measure(which, rivals, setup, track, now, go, rows):
    """Update the block's tracks (or their rivals) with the mark."""
    x = track.x[which]
    p = track.p[which]
    if setup.update == EKF:
        _measure_by_rows(which, setup, track, now, go, x, p, rows)
    else:
        update_jointly(setup, now, go, x, p, rows.nis)
    if rivals > 0:
        for lane in range(LANES):
            gain = rows.nis[lane] + np.log(now.determinant[lane])
            track.cost[which, lane] += gain if track.rival[lane] == 1 else 0.0


@inlined
def _measure_by_rows(which, setup, track, now, go, x, p, rows):
    """Update by uncorrelated scalar rows, all linearised at one point."""
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
    if not setup.robust:
        for lane in range(LANES):
            now.nis[lane] = rows.nis[lane]


@kernel
def turn_to_rivals(lanes, track, now):
    """Set the mark up for the second hypotheses of the lanes that have one; remember what the first ones made of it."""
    for lane in range(LANES):
        now.first_nis[lane] = now.nis[lane]
        now.first_scale[lane] = now.scale[lane]
        now.rival_go[lane] = now.go[lane] if lane < lanes and track.rival[lane] == 1 else 0.0
        for a in range(3):
            now.at[a, lane] = track.x[1, 3 * a, lane]


@kernel
def settle_rivals(lanes, track, now):
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
