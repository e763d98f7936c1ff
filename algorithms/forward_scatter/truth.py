"""Where and when the true target crosses the base line, for each row of a recording with truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import DopplerPairs
from algorithms.toolbox.frames.forward_scatter import ScatterFrame

Floats = NDArray[np.float64]

# True places that differ by more than this from the flight before them belong to another target.
SAME_FLIGHT_M = 20.0
SAME_FLIGHT_SHARE = 0.2


def true_crossings(recording: DopplerPairs, frame: ScatterFrame) -> Floats:
    """(M, 2): crossing time, s, and distance, m, of the flight that each row belongs to; NaN without truth.

    From the row nearest to the base line by the velocity there: exact for a straight flight, and to 1e-3 s for one
    with an acceleration.
    """
    out = np.full((len(recording), 2), np.nan)
    place = frame.from_enu(recording.truth_m)
    speed = frame.turned_from_enu(recording.truth_velocity_mps)
    for target in range(len(recording.targets)):
        rows = recording.rows_of(target)
        rows = rows[np.isfinite(place[rows]).all(axis=1) & np.isfinite(speed[rows]).all(axis=1)]
        if not rows.size:
            continue
        dt = np.diff(recording.time_s[rows])[:, None]
        moved = np.diff(place[rows], axis=0)
        expected = 0.5 * (speed[rows][1:] + speed[rows][:-1]) * dt
        off = np.linalg.norm(moved - expected, axis=1)
        allowed = SAME_FLIGHT_M + SAME_FLIGHT_SHARE * np.linalg.norm(expected, axis=1)
        for flight in np.split(rows, np.flatnonzero(off > allowed) + 1):
            nearest = flight[np.argmin(np.abs(place[flight, 1]))]
            vx, vy, _ = speed[nearest]
            if vy == 0.0:
                continue
            back = place[nearest, 1] / vy
            out[flight, 0] = recording.time_s[nearest] - back
            out[flight, 1] = place[nearest, 0] - vx * back
    return out
