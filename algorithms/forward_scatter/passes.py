"""Cut a long recording into passes of one target each, by what the Dopplers show.

Within a pass every Doppler falls from plus to minus. A new pass begins

- after a silence: no value of any channel for longer than the gap;
- where all channels jump up across zero: the median of the five values before is negative, that of the five after
  positive, and they differ by more than the jump. Of neighbouring rows for which that holds the one is taken that has
  the most signs right on both sides;
- of magnitudes, where all channels turn from rising to falling: within a pass they fall to zero and rise again. Both
  slopes must show in the medians of five and five values; the cut lies where lines before and behind it fit best.

References
----------
specification 10 ("target never crosses"), 8.6 (magnitudes). Differences from the paper: it knows one target only.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import strict

NEIGHBOURS = 5
FEWEST_NEIGHBOURS = 3
JUMP_SIGMA = 30.0
# The difference of two medians of five has a standard deviation of 0.76 sigma.
TURN_SIGMA = 6.0
SILENCES, JUMPS, TURNS = range(3)


@strict
def _beside(time, f, c, k, step, first, stop, skip, t, values):
    """Up to five values of a channel from row k on in steps of +-1, after `skip` ones; return how many there are."""
    count = 0
    seen = 0
    i = k
    while first <= i < stop and count < NEIGHBOURS:
        if np.isfinite(f[i, c]):
            seen += 1
            if seen > skip:
                t[count] = time[i]
                values[count] = f[i, c]
                count += 1
        i += step
    return count


@strict
def _jump_at(time, f, k, first, stop, score):
    """By how much the channels jump up across zero at row k, Hz; 0 where one does not. score[0]: signs that are right.

    Of the rows first <= i < stop.
    """
    t = np.empty(NEIGHBOURS)
    values = np.empty(NEIGHBOURS)
    least = np.inf
    seen = False
    right = 0
    for c in range(f.shape[1]):
        count = _beside(time, f, c, k - 1, -1, first, stop, 0, t, values)
        if count < FEWEST_NEIGHBOURS:
            continue
        before = np.median(values[:count])
        right += int((values[:count] < 0.0).sum())
        count = _beside(time, f, c, k, 1, first, stop, 0, t, values)
        if count < FEWEST_NEIGHBOURS:
            continue
        after = np.median(values[:count])
        right += int((values[:count] > 0.0).sum())
        seen = True
        if not (before < 0.0 < after):
            return 0.0
        least = min(least, after - before)
    score[0] = right
    return least if seen else 0.0


@strict
def _line_beside(t, values, score):
    """Slope of the straight line through values at instants t; its squared residuals are taken off score[0]."""
    dt = t - t.mean()
    df = values - values.mean()
    square = (dt * dt).sum()
    if square <= 0.0:
        return 0.0
    slope = (dt * df).sum() / square
    rest = df - slope * dt
    score[0] -= (rest * rest).sum()
    return slope


@strict
def _turn_at(time, f, k, first, stop, score):
    """By how much the magnitudes rise before row k and fall from it on, Hz; 0 where they do not.

    score[0] is minus the residual of the lines.
    """
    t = np.empty(NEIGHBOURS)
    values = np.empty(NEIGHBOURS)
    least = np.inf
    score[0] = 0.0
    for c in range(f.shape[1]):
        for side in range(2):
            step = 1 if side else -1
            begin = k if side else k - 1
            count = _beside(time, f, c, begin, step, first, stop, NEIGHBOURS, t, values)
            if count < FEWEST_NEIGHBOURS:
                return 0.0
            far = np.median(values[:count])
            if _beside(time, f, c, begin, step, first, stop, 0, t, values) < NEIGHBOURS:
                return 0.0
            least = min(least, np.median(values) - far)
            if not _line_beside(t, values, score) * step < 0.0:
                return 0.0
    return least


@strict
def _cut_at(time, f, k, first, stop, how, score):
    if how == JUMPS:
        return _jump_at(time, f, k, first, stop, score)
    return _turn_at(time, f, k, first, stop, score)


@strict
def passes(time, f, sigma, gap, how, number):
    """Put the number of its pass (from 1; 0 = none) of every row into `number` (K, L).

    f is (K, C, L) Hz; `how` is SILENCES, or also JUMPS, or for magnitudes also TURNS.
    """
    rows, channels, lanes = f.shape
    one = np.empty((rows, channels))
    ends = np.empty(rows, np.int64)
    score = np.zeros(1)
    least = (JUMP_SIGMA if how == JUMPS else TURN_SIGMA) * sigma
    for lane in range(lanes):
        for k in range(rows):
            for c in range(channels):
                one[k, c] = f[k, c, lane]
        # Silences first: nothing is compared across one. `ends` is where the values of a row's piece stop.
        current = 0
        last = -np.inf
        begin = 0
        stop = 0
        for k in range(rows):
            there = False
            for c in range(channels):
                there = there or np.isfinite(one[k, c])
            if there:
                if current == 0 or time[k] - last > gap:
                    ends[begin:k] = stop
                    begin = k
                    current += 1
                last = time[k]
                stop = k + 1
            number[k, lane] = current if current > 0 and time[k] - last <= gap else 0
        ends[begin:] = stop
        if how == SILENCES:
            continue
        more = 0
        first = 0
        piece = 0
        k = 0
        while k < rows:
            if number[k, lane] == 0:
                k += 1
                continue
            if number[k, lane] != piece:
                piece = number[k, lane]
                first = k
            best = k
            highest = -np.inf
            i = k
            while i < ends[k]:
                size = _cut_at(time, one, i, first, ends[k], how, score)
                if size <= least:
                    break
                if score[0] >= highest:
                    highest = score[0]
                    best = i
                i += 1
            if i > k:
                # Rows from k to the cut belong to what was before it.
                for j in range(k, best):
                    number[j, lane] += more
                more += 1
                first = best
                k = best
                piece = number[k, lane]
            number[k, lane] += more
            k += 1


@strict
def signs(f, time, begin, stop):
    """Give unsigned Dopplers of the rows begin <= k < stop back their signs, in place: f (K, C, L).

    Of all places where the sign may switch from plus to minus the one is taken that gives the best falling line.
    """
    _, channels, lanes = f.shape
    for lane in range(lanes):
        for c in range(channels):
            n = 0.0
            st = 0.0
            stt = 0.0
            sff = 0.0
            # Sums with the signs as they would be with everything negative; a switch further on turns them one by one.
            sf = 0.0
            stf = 0.0
            for k in range(begin, stop):
                if np.isfinite(f[k, c, lane]):
                    v = abs(f[k, c, lane])
                    d = time[k] - time[begin]
                    n += 1.0
                    st += d
                    stt += d * d
                    sf -= v
                    stf -= d * v
                    sff += v * v
            spread = stt - st * st / max(n, 1.0)
            best = np.inf
            place = stop
            for switch in range(begin, stop + 1):
                if switch > begin and np.isfinite(f[switch - 1, c, lane]):
                    v = abs(f[switch - 1, c, lane])
                    sf += 2.0 * v
                    stf += 2.0 * (time[switch - 1] - time[begin]) * v
                if n < 3.0 or spread <= 0.0:
                    continue
                both = stf - st * sf / n
                if both >= 0.0:
                    continue
                rest = sff - sf * sf / n - both * both / spread
                if rest < best:
                    best = rest
                    place = switch
            for k in range(begin, stop):
                f[k, c, lane] = abs(f[k, c, lane]) if k < place else -abs(f[k, c, lane])
