"""The compiled multiple-model filter: a block of trials through a range of groups of measurements.

A group is one measurement, or the plots of one scan among which at most one is the target's. It goes through

1. `_begin`     which lanes start, coast, reject or take a measurement (specification 8); where all of them take the
                one there is (`_together`) nothing is decided, filled or reported lane by lane;
2. `_choose`    with a gate: the plot nearest to the prediction, in each lane;
3. `_move`      all hypotheses to its time, in one step or, over a long gap, in steps of the base interval;
4. rows for each hypothesis, `absorb`, `conclude` (`toolbox.filters.multiple_model`);
5. `finish`     what became of each row; the manoeuvre detector; `write` the report (`filter_report`).

Nothing here creates an array: the compiler then counts no references, which would cost a third of the time.
"""

from __future__ import annotations

import numpy as np

from algorithms.multiple_model.filter_report import all_usual, finish, start, write, write_together
from algorithms.multiple_model.states import (
    COASTING,
    OUTSIDE_GATE,
    R_DOMAIN,
    R_DOUBTFUL,
    R_EQUAL,
    R_FIRST,
    R_GAP,
    R_NONE,
    R_OUTSIDE,
    REJECTED,
    STARTED,
    UPDATED,
    WAITING,
)
from algorithms.toolbox.filters.merging import MOMENT, merge_moments, merge_weights
from algorithms.toolbox.filters.multiple_model import (
    GPB2,
    absorb,
    advance,
    advance_here,
    conclude,
    conclude_here,
    place,
    settle_start,
)
from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.flat import woven
from algorithms.toolbox.kernels.symmetric import solve3
from algorithms.toolbox.sensors.position_rows import PositionMark, linearised


@bare
def region_of(setup, x, y, z):
    """Number of the first region that holds a point; the count of regions where none does."""
    count = setup.heights.shape[0]
    for c in range(count):
        if z < setup.heights[c, 0] or z > setup.heights[c, 1]:
            continue
        first, stop = setup.first_corner[c], setup.first_corner[c + 1]
        inside = stop == first
        k = stop - 1
        for i in range(first, stop):
            yi, yk = setup.corners[i, 1], setup.corners[k, 1]
            if (yi > y) != (yk > y):
                cut = setup.corners[i, 0] + (y - yi) / (yk - yi) * (setup.corners[k, 0] - setup.corners[i, 0])
                if x < cut:
                    inside = not inside
            k = i
        if inside:
            return c
    return count


@woven
def _together(k, stop, lanes, marks, setup, state, now):
    """Whether the group is one row that every lane takes; then say so."""
    if stop != k + 1:
        return False
    valid, live, last, time = marks.valid[k], state.live, state.time, marks.time[k]
    ready = 0
    for lane in range(lanes):
        dt = time - last[lane]
        ready += 1 if valid[lane] == 1 and live[lane] == 1 and dt > 0.0 and dt <= setup.timeout_s else 0
    if ready < lanes:
        return False
    dt, go, fresh, shown, status, reason, chosen = (
        now.dt, now.go, now.fresh, now.shown, now.status, now.reason, now.chosen
    )  # fmt: skip
    for lane in range(lanes):
        dt[lane] = time - last[lane]
    for lane in range(lanes):
        go[lane] = 1.0
    for lane in range(lanes):
        fresh[lane] = 0.0
    for lane in range(lanes):
        shown[lane] = 1
    for lane in range(lanes):
        status[lane] = UPDATED
    for lane in range(lanes):
        reason[lane] = R_NONE
    for lane in range(lanes):
        chosen[lane] = k
    return True


@bare
def _begin(k, stop, lanes, marks, setup, bank, track, state, now, rows):
    """Decide what each lane does with the rows k to stop; start the lanes that have no track."""
    fresh = 0
    for lane in range(LANES):
        now.go[lane] = 0.0
        now.fresh[lane] = 0.0
        now.shown[lane] = 0
        now.status[lane] = WAITING
        now.reason[lane] = R_NONE
        now.chosen[lane] = k
        now.dt[lane] = 0.0
    for lane in range(lanes):
        row = -1
        for r in range(k, stop):
            if marks.valid[r, lane] == 1:
                row = r
                break
        if row < 0:
            now.reason[lane] = R_DOMAIN
            now.status[lane] = COASTING if state.live[lane] == 1 else REJECTED
            if state.live[lane] == 1:
                now.dt[lane] = marks.time[k] - state.time[lane]
                now.shown[lane] = 1
            continue
        now.chosen[lane] = row
        dt = marks.time[row] - state.time[lane]
        if state.live[lane] == 1 and dt <= setup.timeout_s:
            if dt < 0.0 or (dt == 0.0 and marks.sensor[row] == state.sensor[lane]):
                now.status[lane] = REJECTED
                now.reason[lane] = R_EQUAL
                continue
            now.dt[lane] = dt
            now.go[lane] = 1.0
            now.shown[lane] = 1
            now.status[lane] = UPDATED
            continue
        now.status[lane] = STARTED
        now.reason[lane] = R_GAP if state.live[lane] == 1 else R_FIRST
        start(row, lane, marks, setup, bank, track, state, now, rows)
        fresh += 1
    return fresh


@bare
def _fill(row, lane_row, lanes, marks, now):
    """Copy rows into the lanes: row `row`, or each lane's own of `lane_row` where `row` < 0."""
    for a in range(3):
        for lane in range(lanes):
            r = row if row >= 0 else lane_row[lane]
            good = marks.valid[r, lane] == 1
            now.z[a, lane] = marks.z[r, a, lane] if good else 0.0
            now.y[a, lane] = marks.y[r, a, lane] if good else 0.0
            now.sd[a, lane] = marks.sd[r, a] if good else 1.0


@woven
def _fill_together(row, lanes, marks, now):
    """The same where every lane has the row."""
    for a in range(3):
        z, y, sd, from_z, from_y = now.z[a], now.y[a], now.sd[a], marks.z[row, a], marks.y[row, a]
        value = marks.sd[row, a]
        for lane in range(lanes):
            z[lane] = from_z[lane]
        for lane in range(lanes):
            y[lane] = from_y[lane]
        for lane in range(lanes):
            sd[lane] = value


@woven
def _move(bank, setup, track, work, state, now):
    """Move all hypotheses over `now.dt`; long gaps in steps where they are asked for."""
    if setup.substep_above_s == np.inf:
        clip = advance_here(bank, track, work, now.dt, now.region)
        state.clip[0] = clip if np.isnan(clip) else max(state.clip[0], clip)
        return
    for lane in range(LANES):
        long = now.go[lane] > 0.0 and now.dt[lane] > setup.substep_above_s
        now.left[lane] = now.dt[lane] if long else 0.0
    again = True
    while again:
        again = False
        for lane in range(LANES):
            # The last step, of what remains, is made with all the other lanes.
            here = now.left[lane] > 1.5 * bank.chains.step_s
            now.stepping[lane] = 1.0 if here else 0.0
            again = again or here
        for lane in range(LANES):
            if again:
                now.step[lane] = bank.chains.step_s if now.stepping[lane] > 0.0 else 0.0
                now.left[lane] -= now.step[lane]
            else:
                now.step[lane] = now.left[lane] if now.left[lane] > 0.0 else now.dt[lane]
        clip = advance(bank, track, work, now.step, now.region)
        state.clip[0] = clip if np.isnan(clip) else max(state.clip[0], clip)
        if again:
            conclude(bank, track, work, work.s, now.stepping)


@bare
def predicted(work, now):
    """Moments of the predicted hypotheses in `work`."""
    merge_weights(work.log, -1, MOMENT, now.weight, now.total, work.spare)
    merge_moments(work.s, now.weight, now.predicted)


@bare
def _distances(lanes, mark, setup, now, work, rows):
    """Squared distance of the mark from the predicted mixture in each lane."""
    predicted(work, now)
    linearised(mark, 1 if setup.way > 1 else setup.way, now.go, now.predicted, rows)
    s, nu, out = now.small[0], now.small[1], now.small[2]
    for lane in range(lanes):
        now.distance[lane] = np.inf
        if now.go[lane] == 0.0:
            continue
        for i in range(3):
            nu[i] = rows.r[9 + i, lane]
            for j in range(i + 1):
                total_ = rows.r[12 + i, lane] if i == j else 0.0
                for a in range(3):
                    for b in range(3):
                        u, v = max(3 * a, 3 * b), min(3 * a, 3 * b)
                        total_ += rows.r[3 * i + a, lane] * now.predicted[place(u, v), lane] * rows.r[3 * j + b, lane]
                s[i * (i + 1) // 2 + j] = total_
        if solve3(s, nu, out):
            now.distance[lane] = nu[0] * out[0] + nu[1] * out[1] + nu[2] * out[2]


@bare
def _choose(k, stop, lanes, marks, setup, bank, track, state, work, rows, now, report):
    """In each lane that takes a measurement choose the nearest row within the gate, or none."""
    keep = now.keep
    for lane in range(lanes):
        keep[lane] = now.go[lane]
        now.best[lane] = np.inf
        wide = setup.widen if now.dt[lane] > setup.widen_after_s else 1.0
        now.limit[lane] = setup.gate * wide * wide
    for r in range(k, stop):
        for lane in range(lanes):
            here = keep[lane] > 0.0 and marks.valid[r, lane] == 1
            now.go[lane] = 1.0 if here else 0.0
            now.dt[lane] = max(marks.time[r] - state.time[lane], 0.0) if keep[lane] > 0.0 else now.dt[lane]
        _fill(r, now.chosen, lanes, marks, now)
        mark = PositionMark(marks.kind[r], marks.axes[marks.sensor[r]], marks.origin[r], now.sd, now.z, now.y)
        clip = advance(bank, track, work, now.dt, now.region)
        state.clip[0] = clip if np.isnan(clip) else max(state.clip[0], clip)
        _distances(lanes, mark, setup, now, work, rows)
        for lane in range(lanes):
            if keep[lane] > 0.0 and report.distance.shape[0] > 0 and now.go[lane] > 0.0:
                report.distance[r, lane] = np.sqrt(now.distance[lane])
                report.limit[r, lane] = np.sqrt(now.limit[lane])
            if now.go[lane] > 0.0 and now.distance[lane] < now.best[lane]:
                now.best[lane] = now.distance[lane]
                now.chosen[lane] = r
    for lane in range(lanes):
        inside = keep[lane] > 0.0 and now.best[lane] <= now.limit[lane]
        now.go[lane] = 1.0 if inside else 0.0
        if keep[lane] > 0.0:
            now.dt[lane] = max(marks.time[now.chosen[lane]] - state.time[lane], 0.0)
            if not inside:
                now.status[lane] = OUTSIDE_GATE
                now.reason[lane] = R_OUTSIDE
            elif now.dt[lane] > setup.widen_after_s:
                now.reason[lane] = R_DOUBTFUL


@bare
def filter_groups(marks, setup, bank, track, state, work, rows, now, report, first, last):
    """Filter the groups first <= g < last in all lanes."""
    lanes = marks.valid.shape[1]
    hypotheses = work.s.shape[0]
    for g in range(first, last):
        k, stop = marks.group[g], marks.group[g + 1]
        together = _together(k, stop, lanes, marks, setup, state, now)
        if not together and _begin(k, stop, lanes, marks, setup, bank, track, state, now, rows) > 0:
            settle_start(bank, track, work, now.fresh)
        if setup.heights.shape[0] > 0:
            for lane in range(lanes):
                now.region[lane] = region_of(setup, track.common[0, lane], track.common[3, lane], track.common[6, lane])
        if np.isfinite(setup.gate):
            together = False
            _choose(k, stop, lanes, marks, setup, bank, track, state, work, rows, now, report)
        if together:
            _fill_together(k, lanes, marks, now)
        else:
            _fill(-1, now.chosen, lanes, marks, now)
        if marks.boost.shape[0] > 0:
            for lane in range(lanes):
                track.boost[lane] = marks.boost[now.chosen[lane], lane]
        _move(bank, setup, track, work, state, now)
        row = now.chosen[0]
        mark = PositionMark(marks.kind[row], marks.axes[marks.sensor[row]], marks.origin[row], now.sd, now.z, now.y)
        # Where every lane goes, updated states are written where they belong.
        taken = together and lanes == LANES and bank.structure != GPB2
        updated = track.s if taken else work.updated
        for h in range(hypotheses):
            if h == 0 or setup.way > 0:
                linearised(mark, setup.way, now.go, work.s[h], rows)
            else:
                _same_rows(now.y, now.go, work.s[h], rows.r)
            absorb(bank, work, h, rows.r, rows.log_volume, updated[h])
        conclude_here(bank, track, work, updated, now.go, taken)
        if together and all_usual(lanes, marks, setup, bank, track, state, work, now, report):
            write_together(k, lanes, setup, bank, track, work, state, now, report)
            continue
        if finish(lanes, marks, setup, bank, track, state, work, now, report, rows) > 0:
            settle_start(bank, track, work, now.fresh)
        coasting = 0
        for lane in range(lanes):
            if now.shown[lane] == 1 and now.go[lane] == 0.0 and now.fresh[lane] == 0.0:
                coasting += 1
        if coasting > 0:
            predicted(work, now)
        write(k, stop, lanes, coasting, setup, bank, track, work, state, now, report)


@woven
def _same_rows(y, go, x, rows):
    """Innovations of another hypothesis by the rows that all share."""
    for i in range(3):
        h0, h1, h2, nu = rows[3 * i], rows[3 * i + 1], rows[3 * i + 2], rows[9 + i]
        for lane in range(LANES):
            dx, dy, dz = y[0, lane] - x[0, lane], y[1, lane] - x[3, lane], y[2, lane] - x[6, lane]
            nu[lane] = h0[lane] * dx + h1[lane] * dy + h2[lane] * dz if go[lane] > 0.0 else 0.0
