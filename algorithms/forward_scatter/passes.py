"""Cut a long recording into passes of one target each, by what the Dopplers show.

Within a pass every Doppler falls from plus to minus. A new pass begins

- after a silence: no value of any channel for longer than the gap;
- where all channels jump up across zero: the median of the five values before is negative, that of the five after
  positive, and they differ by more than the jump.

References
----------
specification 10 ("target never crosses"), issue: several targets one after another. Differences from the paper: it
knows one target only.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import strict

NEIGHBOURS = 5
FEWEST_NEIGHBOURS = 3
JUMP_SIGMA = 30.0


@strict
def _median_beside(f, c, k, ahead):
    """Median of up to five values of a channel before row k, or from it on; NaN where there are fewer than three."""
    values = np.empty(NEIGHBOURS)
    count = 0
    i = k if ahead else k - 1
    while 0 <= i < f.shape[0] and count < NEIGHBOURS:
        if np.isfinite(f[i, c]):
            values[count] = f[i, c]
            count += 1
        i += 1 if ahead else -1
    return np.median(values[:count]) if count >= FEWEST_NEIGHBOURS else np.nan


@strict
def _jump_at(f, k, first):
    """By how much the channels jump up across zero at row k, Hz; 0 where one of them does not."""
    least = np.inf
    seen = False
    for c in range(f.shape[1]):
        before = _median_beside(f[first:], c, k - first, False)
        after = _median_beside(f[first:], c, k - first, True)
        if np.isnan(before) or np.isnan(after):
            continue
        seen = True
        if not (before < 0.0 < after):
            return 0.0
        least = min(least, after - before)
    return least if seen else 0.0


@strict
def passes(time, f, sigma, gap, jumps, number):
    """Put the number of its pass (from 1; 0 = none) of every row into `number` (K, L); f is (K, C, L) Hz."""
    rows, channels, lanes = f.shape
    one = np.empty((rows, channels))
    for lane in range(lanes):
        for k in range(rows):
            for c in range(channels):
                one[k, c] = f[k, c, lane]
        current = 0
        last = -np.inf
        first = 0
        best = 0.0
        for k in range(rows):
            there = False
            for c in range(channels):
                there = there or np.isfinite(one[k, c])
            if there:
                if current == 0 or time[k] - last > gap:
                    current += 1
                    first = k
                elif jumps:
                    here = _jump_at(one, k, first)
                    if here > JUMP_SIGMA * sigma:
                        # The jump is where the medians differ most; of equals the last.
                        best = here
                        following = _jump_at(one, k + 1, first) if k + 1 < rows else 0.0
                        if following < best or following == 0.0:
                            current += 1
                            first = k
                last = time[k]
            number[k, lane] = current if current > 0 and time[k] - last <= gap else 0


@strict
def signs(f, time, begin, stop):
    """Give unsigned Dopplers of the rows begin <= k < stop back their signs, in place: f (K, C, L).

    Of all places where the sign may switch from plus to minus the one is taken that gives the best falling line.
    """
    _, channels, lanes = f.shape
    for lane in range(lanes):
        for c in range(channels):
            best = np.inf
            place = stop
            for switch in range(begin, stop + 1):
                n = 0.0
                t0 = time[begin]
                st = 0.0
                sf = 0.0
                stt = 0.0
                stf = 0.0
                sff = 0.0
                for k in range(begin, stop):
                    if np.isfinite(f[k, c, lane]):
                        v = abs(f[k, c, lane]) if k < switch else -abs(f[k, c, lane])
                        d = time[k] - t0
                        n += 1.0
                        st += d
                        sf += v
                        stt += d * d
                        stf += d * v
                        sff += v * v
                if n < 3.0:
                    continue
                spread = stt - st * st / n
                both = stf - st * sf / n
                if spread <= 0.0 or both >= 0.0:
                    continue
                rest = sff - sf * sf / n - both * both / spread
                if rest < best:
                    best = rest
                    place = switch
            for k in range(begin, stop):
                f[k, c, lane] = abs(f[k, c, lane]) if k < place else -abs(f[k, c, lane])
