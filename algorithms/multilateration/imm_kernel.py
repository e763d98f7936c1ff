"""The compiled filter of two interacting models over marks: a block of trials, or of targets.

Tracks start, restart and end as the single filter's do (`begin`, `concluding`): what these see is the merged estimate.
While two positions explain the data (`rival`), the single filter carries both; when one is left the bank takes over.
"""

from __future__ import annotations

import numpy as np

from algorithms.multilateration.bank import SMALLEST_WEIGHT, merge_bank, predict_bank, take_over
from algorithms.multilateration.begin import count_followed, decide
from algorithms.multilateration.bias_prior import weigh_biases
from algorithms.multilateration.concluding import conclude
from algorithms.multilateration.lanes import (
    INITIALISED,
    R_LEFT_ALTITUDE,
    R_LEFT_RECEPTION,
    R_REPAIRED,
    REINITIALISED,
    RELINEARISATIONS,
    SCALE_FROM_SIGMA,
    UPDATED,
)
from algorithms.multilateration.leave_out import leave_one_out
from algorithms.multilateration.mark_at_hand import elapse_to_emission, read_mark
from algorithms.multilateration.measuring import measure, settle_rivals, turn_to_rivals
from algorithms.multilateration.reporting import (
    copy_row,
    copy_shown,
    look_at,
    write_more,
    write_rivals,
    write_scores,
    write_state,
)
from algorithms.toolbox.kernels import LANES, strict
from algorithms.toolbox.kernels.unrolled import update_rows_4, update_rows_10
from algorithms.toolbox.motion.jerk import predict_jerk
from algorithms.toolbox.sensors.altitude import altitude_row
from algorithms.toolbox.sensors.time_of_arrival import contrast_rows


@strict
def filter_marks_by_models(marks, setup, choice, track, bank, now, rows, report, first, stop):
    """Run marks first <= k < stop of every lane through both models.

    Parameters
    ----------
    marks : Marks, L <= LANES lanes, each with its own times
    setup : Setup, of the single filter that starts the tracks; its altitude noise includes the bias
    choice : Choice
    track : Track, bank : Bank, changed in place
    now, rows : Now, Rows
        Workspace.
    report : Report, filled for these marks
    first, stop : int
    """
    lanes = marks.toa.shape[2]
    x = track.x[0]
    p = track.p[0]
    single = np.zeros(LANES)
    single_go = np.zeros(LANES)
    for k in range(first, stop):
        read_mark(k, marks, setup, track, now)
        elapse_to_emission(lanes, marks.time[k], setup, track, now)
        singles = 0
        rivals = 0
        for lane in range(LANES):
            bank.on[lane] = bank.on[lane] if track.live[lane] == 1 else 0
            bank.t[lane] = now.elapsed[lane] if bank.on[lane] == 1 else 0.0
            single[lane] = now.elapsed[lane] - bank.t[lane]
            bank.left[lane] = 0
            singles += 1 if track.live[lane] == 1 and bank.on[lane] == 0 else 0
            rivals += track.rival[lane]
        if singles > 0:
            predict_jerk(x, p, single, setup.sigma_jerk, setup.noise_form)
        if rivals > 0:
            predict_jerk(track.x[1], track.p[1], single, setup.sigma_jerk, setup.noise_form)
        predict_bank(choice, bank)
        merge_bank(bank, x, p)
        for lane in range(LANES):
            track.time[lane] += now.elapsed[lane]
        for a in range(3):
            for lane in range(LANES):
                now.at[a, lane] = x[3 * a, lane]
        followed = count_followed(
            lanes, True, p, track.time, track.last_update, track.suspect, track.live, now.status, now.possible,
            now.receptions, now.has_altitude,
        )  # fmt: skip
        if followed == lanes:
            for lane in range(lanes):
                now.go[lane] = 1.0
        else:
            decide(lanes, marks.time[k], setup, track, now)
        alone = 0
        banked = 0
        for lane in range(LANES):
            # What this mark has started anew is the single filter's again.
            anew = now.status[lane] == INITIALISED or now.status[lane] == REINITIALISED
            bank.on[lane] = bank.on[lane] if track.live[lane] == 1 and not anew else 0
            bank.go[lane] = now.go[lane] if bank.on[lane] == 1 else 0.0
            single_go[lane] = now.go[lane] - bank.go[lane]
            alone += 1 if single_go[lane] > 0.0 else 0
            banked += 1 if bank.go[lane] > 0.0 else 0
        if alone > 0 or banked == 0:
            _measure_alone(lanes, rivals, setup, track, now, single_go, rows)
        if banked > 0:
            _measure_bank(lanes, setup, choice, track, bank, now, rows)
            merge_bank(bank, x, p)
        if choice.bias_variance > 0.0:
            weigh_biases(choice.bias_variance, bank, x, p)
        conclude(lanes, setup, track, now)
        _settle(lanes, setup, choice, track, bank, now)
        look_at(lanes, track.live, now.status, now.go, now.shown, now.took)
        copy_row(k, lanes, now.status, report.status)
        copy_row(k, lanes, now.reason, report.reason)
        copy_shown(k, lanes, track.number, now.shown, report.track)
        copy_shown(k, lanes, now.dof, now.shown, report.dof)
        write_scores(
            k, lanes, track.time, now.nis, now.dof, now.took, now.has_altitude, now.shown, report.time, report.nis,
            report.altitude_used,
        )  # fmt: skip
        write_state(k, lanes, x, p, now.shown, report.state, report.covariance)
        if followed < lanes or rivals > 0:
            write_rivals(k, lanes, track, now.shown, report.covariance)
        if report.residual.shape[0] > 0:
            write_more(k, lanes, setup, track, now, report)
        if report.probability.shape[0] > 0:
            _write_models(k, lanes, bank, now, report)


@strict
def _measure_alone(lanes, rivals, setup, track, now, go, rows):
    """Update the lanes that the bank does not have yet, as the single filter does; the others find all as it was."""
    keep = now.go.copy()
    at = now.at.copy()
    for lane in range(LANES):
        now.go[lane] = go[lane]
    for which in range(2 if rivals > 0 else 1):
        if which == 1:
            turn_to_rivals(lanes, track, now)
        measure(which, rivals, setup, track, now, now.go if which == 0 else now.rival_go, rows)
    if rivals > 0:
        settle_rivals(lanes, track, now)
    for lane in range(LANES):
        now.go[lane] = keep[lane]
        for a in range(3):
            now.at[a, lane] = at[a, lane]


@strict
def _build(m, setup, choice, now, bank, rows):
    """Rows of the mark for model m at `bank.at`."""
    n = setup.stations.shape[0]
    x = bank.x[m]
    contrast_rows(
        now.toa, now.used, setup.stations, setup.variance, bank.at[m], x, 3, bank.h[m], bank.nu[m], bank.variance[m],
        bank.active[m], rows.sums,
    )  # fmt: skip
    altitude_row(now.altitude, bank.at[m], x, 3, setup.earth, bank.h[m, n], bank.nu[m, n])
    for lane in range(LANES):
        # What stands in for a decoded altitude need not have its bias.
        bank.along[n, lane] = now.altitude_biased[lane]
        bank.nu[m, n, lane] -= now.altitude_biased[lane] * x[9, lane]
        bank.variance[m, n, lane] = choice.altitude_variance + now.altitude_extra[lane]
        bank.active[m, n, lane] = now.has_altitude[lane]
    for r in range(n + 1):
        for lane in range(LANES):
            bank.active[m, r, lane] *= bank.go[lane]


@strict
def _learn(m, setup, choice, now, bank, rows, again):
    """NIS of the mark for model m, from an update of position and bias alone; linearise again where asked."""
    places = (0, 3, 6, 9)
    p = bank.p[m]
    for step in range(RELINEARISATIONS if again > 0 else 1):
        _build(m, setup, choice, now, bank, rows)
        for a in range(4):
            for b in range(a + 1):
                i = places[a] * (places[a] + 1) // 2 + places[b]
                for lane in range(LANES):
                    bank.small_p[a * (a + 1) // 2 + b, lane] = p[i, lane]
            for lane in range(LANES):
                bank.small_x[a, lane] = bank.start[m, a, lane]
        for lane in range(LANES):
            bank.nis[m, lane] = 0.0
        update_rows_4(
            bank.small_x, bank.small_p, bank.start[m], bank.h[m], bank.along, bank.nu[m], bank.variance[m],
            bank.active[m], bank.nis[m], bank.waste,
        )  # fmt: skip
        if step + 1 < RELINEARISATIONS:
            for a in range(3):
                for lane in range(LANES):
                    moves = now.iterate[lane] == 1
                    bank.at[m, a, lane] = bank.small_x[a, lane] if moves else bank.at[m, a, lane]


@strict
def _measure_bank(lanes, setup, choice, track, bank, now, rows):
    """Update both models with the mark, and their weights."""
    n_rows = bank.nu.shape[1]
    x = track.x[0]
    again = 0
    for lane in range(LANES):
        again += now.iterate[lane]
        bank.waste[lane] = 1.0
    for m in range(2):
        for a in range(3):
            for lane in range(LANES):
                # Where the mark's own fix was taken for the point of linearisation, both models take it.
                fixed = now.at[a, lane] != x[3 * a, lane]
                bank.start[m, a, lane] = bank.x[m, 3 * a, lane]
                bank.at[m, a, lane] = now.at[a, lane] if fixed else bank.x[m, 3 * a, lane]
        for lane in range(LANES):
            bank.start[m, 3, lane] = bank.x[m, 9, lane]
        _learn(m, setup, choice, now, bank, rows, again)
    changed = 0
    for lane in range(lanes):
        if bank.go[lane] == 0.0:
            continue
        now.scale[lane] = 1.0
        known = 1 if now.has_altitude[lane] > 0.0 else 0
        dof = max(now.receptions[lane] - 1, 0) + known
        nis = min(bank.nis[0, lane], bank.nis[1, lane])
        if dof > 0 and nis > choice.limits[dof]:
            if leave_one_out(lane, setup, choice, now, bank):
                changed += 1
            else:
                now.scale[lane] = max(1.0, nis / (SCALE_FROM_SIGMA**2 * dof))
    for m in range(2):
        if changed > 0:
            _learn(m, setup, choice, now, bank, rows, 0)
        for lane in range(LANES):
            bank.score[m, lane] = 0.0
            bank.determinant[m, lane] = 1.0
            bank.waste[lane] = 1.0
        for r in range(n_rows):
            for lane in range(LANES):
                bank.variance[m, r, lane] *= now.scale[lane] if bank.go[lane] > 0.0 else 1.0
        update_rows_10(
            bank.x[m], bank.p[m], bank.start[m], bank.h[m], bank.along, bank.nu[m], bank.variance[m], bank.active[m],
            bank.score[m], bank.determinant[m],
        )  # fmt: skip
    for lane in range(lanes):
        if bank.go[lane] > 0.0:
            # Minus twice the logarithm of the likelihoods' ratio.
            ratio = bank.score[1, lane] - bank.score[0, lane]
            ratio += np.log(bank.determinant[1, lane] / bank.determinant[0, lane])
            odds = bank.weight[1, lane] / bank.weight[0, lane] * np.exp(-0.5 * min(max(ratio, -600.0), 600.0))
            w = min(max(odds / (1.0 + odds), SMALLEST_WEIGHT), 1.0 - SMALLEST_WEIGHT)
            bank.weight[1, lane] = w
            bank.weight[0, lane] = 1.0 - w
            now.nis[lane] = (1.0 - w) * bank.nis[0, lane] + w * bank.nis[1, lane]


@strict
def _settle(lanes, setup, choice, track, bank, now):
    """Say what was left out; take over the tracks that the bank can carry; let go of the others."""
    for lane in range(lanes):
        if track.live[lane] == 0 or (bank.on[lane] == 1 and now.reason[lane] == R_REPAIRED):
            bank.on[lane] = 0
        if bank.on[lane] == 1 and now.status[lane] == UPDATED and bank.left[lane] != 0:
            now.reason[lane] = R_LEFT_ALTITUDE if bank.left[lane] < 0 else R_LEFT_RECEPTION
        if track.live[lane] == 1 and bank.on[lane] == 0 and track.rival[lane] == 0:
            decoded = now.has_altitude[lane] > 0.0 and now.altitude_extra[lane] == 0.0
            take_over(lane, setup, choice, track, bank, now.altitude[lane], decoded)


@strict
def _write_models(k, lanes, bank, now, report):
    """Weights of the models, the bias and its standard deviation."""
    for lane in range(lanes):
        carried = now.shown[lane] if bank.on[lane] == 1 else np.nan
        report.probability[k, 0, lane] = bank.weight[0, lane] * carried
        report.probability[k, 1, lane] = bank.weight[1, lane] * carried
        report.bias[k, 0, lane] = bank.bias[0, lane] * carried
        report.bias[k, 1, lane] = np.sqrt(max(bank.bias[1, lane], 0.0)) * carried
