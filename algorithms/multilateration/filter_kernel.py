"""The compiled range-difference filter: a block of trials, or of targets, through a range of marks.

One mark goes through these steps (specification 4, 5, 6.4(b)):

1. `read_mark`       receptions and altitude that are finite; impossible spreads.
2. `elapse_to_...`  time since the state, from the gate or from the estimated emission; gaps close a track.
3. `predict_jerk`    the block, lanes without a track standing still.
4. `decide` per lane: start a track from a one-mark fix, or from several marks together; with an unknown velocity or
                     after 20 s take the fix as point of linearisation, and restart where prediction and fix differ by
                     more than five sigma.
5. `measure`         rows of the mark; in the robust profile their noise is scaled where the innovation is too large.
6. `conclude`        status, consistency over twenty marks, tracks that have lost their way; the report.
"""

from __future__ import annotations

from algorithms.multilateration.begin import count_followed, decide
from algorithms.multilateration.concluding import conclude, conclude_plainly, count_sound
from algorithms.multilateration.mark_at_hand import elapse_to_emission, elapse_to_gate, read_mark
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
from algorithms.toolbox.kernels import LANES, kernel
from algorithms.toolbox.motion.jerk import predict_jerk


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
    # What every mark needs is taken out of its tuple once: each time costs more than a row of arithmetic.
    x, p = track.x[0], track.p[0]
    gates, times, live, rival, suspect = track.gate, track.time, track.live, track.rival, track.suspect
    last_update, number = track.last_update, track.number
    elapsed, status, reason, at, go = now.elapsed, now.status, now.reason, now.at, now.go
    receptions, possible, has_altitude, dof, nis = now.receptions, now.possible, now.has_altitude, now.dof, now.nis
    shown, took = now.shown, now.took
    robust = setup.robust
    for k in range(first, stop):
        gate = marks.time[k]
        read_mark(k, marks, setup, track, now)
        if robust:
            elapse_to_emission(lanes, gate, setup, track, now)
        else:
            elapse_to_gate(k, lanes, marks.time, gates, times, live, elapsed, status, reason)
        rivals = 0
        for lane in range(lanes):
            rivals += rival[lane]
        predict_jerk(x, p, elapsed, setup.sigma_jerk, setup.noise_form)
        if rivals > 0:
            predict_jerk(track.x[1], track.p[1], elapsed, setup.sigma_jerk, setup.noise_form)
        for lane in range(LANES):
            times[lane] += elapsed[lane]
        for a in range(3):
            for lane in range(LANES):
                at[a, lane] = x[3 * a, lane]
        followed = count_followed(
            lanes, robust, p, times, last_update, suspect, live, status, possible, receptions, has_altitude
        )
        if followed == lanes:
            for lane in range(lanes):
                go[lane] = 1.0
        else:
            decide(lanes, gate, setup, track, now)
        # One place that measures, so that it is compiled once: first the tracks, then their rivals.
        for which in range(2 if rivals > 0 else 1):
            if which == 1:
                turn_to_rivals(lanes, track, now)
            measure(which, rivals, setup, track, now, go if which == 0 else now.rival_go, rows)
        if rivals > 0:
            settle_rivals(lanes, track, now)
        if not robust and count_sound(lanes, x, p, go, rival) == lanes:
            conclude_plainly(lanes, receptions, has_altitude, times, dof, last_update, status, reason)
        else:
            conclude(lanes, setup, track, now)
        look_at(lanes, live, status, go, shown, took)
        copy_row(k, lanes, status, report.status)
        copy_row(k, lanes, reason, report.reason)
        copy_shown(k, lanes, number, shown, report.track)
        copy_shown(k, lanes, dof, shown, report.dof)
        write_scores(
            k, lanes, times, nis, dof, took, has_altitude, shown, report.time, report.nis, report.altitude_used
        )
        write_state(k, lanes, x, p, shown, report.state, report.covariance)
        if followed < lanes or rivals > 0:
            write_rivals(k, lanes, track, shown, report.covariance)
        if report.residual.shape[0] > 0:
            write_more(k, lanes, setup, track, now, report)
