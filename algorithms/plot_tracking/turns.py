"""Which turn of the antenna a plot belongs to, where the recording gives no number of the scan.

An antenna that turns once in T s looks in direction theta at the instants t0 + T (n + theta / 2 pi), so that
n = t / T - theta / 2 pi less a phase that changes slowly. The phase is followed plot by plot, because no period is
known so well that it could be counted on for an hour. Where all plots of a turn carry one instant there is nothing to
follow, and every instant is a scan.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Plots from which a period is estimated.
FEWEST_PLOTS = 12
# A slower growth of azimuth with time is a target that passes by: no antenna takes so long, s.
LONGEST_PERIOD_S = 40.0
# Length of the mean vector of the phases of an antenna that turns steadily; without turning it is near 0.
STEADY = 0.8
# Share of a plot's phase that goes into the phase that is followed.
FOLLOWED = 0.1
# Phases are looked at over so many plots, within which a period is known well enough.
LOOKED_AT = 200


def turning_period(time_s: Floats, azimuth_rad: Floats) -> float | None:
    """Return the period of the antenna in s, from how fast azimuth grows with time; None where it does not."""
    if time_s.size < FEWEST_PLOTS:
        return None
    dt = np.diff(time_s)
    turn = np.mod(np.diff(azimuth_rad), 2 * np.pi)
    # Neighbours in time of which the antenna has seen the second soon after the first.
    soon = (dt > 0) & (turn > 0.02) & (turn < 2.0)
    if int(soon.sum()) < FEWEST_PLOTS // 2:
        return None
    period = float(np.median(2 * np.pi * dt[soon] / turn[soon]))
    if period > LONGEST_PERIOD_S:
        return None
    first = slice(0, min(time_s.size, LOOKED_AT))
    phase = 2 * np.pi * time_s[first] / period - azimuth_rad[first]
    drift = np.angle(np.exp(1j * np.diff(phase)))
    return period if abs(np.exp(1j * drift).mean()) > STEADY else None


def turns_of(time_s: Floats, azimuth_rad: Floats, period_s: float) -> Ints:
    """Number of the turn of each plot, from 0; plots in the order of time."""
    out = np.zeros(time_s.size, np.int64)
    if not time_s.size:
        return out
    raw = (time_s - time_s[0]) / period_s - np.mod(azimuth_rad, 2 * np.pi) / (2 * np.pi)
    phase, followed = 0.0, raw.tolist()
    for i, value in enumerate(followed):
        if i == 0:
            phase = value
        number = round(value - phase)
        phase += FOLLOWED * (value - phase - number)
        out[i] = number
    first: Ints = out - out.min()
    return first
