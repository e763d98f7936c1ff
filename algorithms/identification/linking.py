"""Plots of one radar joined to tracks where the recording does not say which belong together.

Look by look the plots are assigned to the tracks so far, nearest to where a track goes on, no farther than the largest
speed allows. A track ends after `PATIENCE` looks without a plot.

References
----------
crouse2016, the assignment.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.association.assignment import most_likely_matching

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PATIENCE = 3
# Errors of the places allow for so many standard deviations.
SIGMAS = 4.0


def linked(looks: list[Ints], time_s: Floats, place: Floats, drms_m: Floats, max_speed_mps: float) -> list[Ints]:
    """Positions of the plots of each track, in the order of time.

    Parameters
    ----------
    looks : positions of the radar's plots at each look
    time_s, place, drms_m : (M,), (M, 2), (M,) of all plots; NaN places are left out
    """
    tracks: list[list[int]] = []
    quiet: list[int] = []
    for rows in looks:
        here = rows[np.isfinite(place[rows, 0])]
        open_tracks = [i for i, q in enumerate(quiet) if q < PATIENCE]
        score = np.full((len(open_tracks), here.size), -np.inf)
        for n, i in enumerate(open_tracks):
            score[n] = _scores(tracks[i], here, time_s, place, drms_m, max_speed_mps)
        partner = most_likely_matching(score)
        for n, i in enumerate(open_tracks):
            quiet[i] += 1
            if partner[n] >= 0:
                tracks[i].append(int(here[partner[n]]))
                quiet[i] = 0
        for j in np.setdiff1d(np.arange(here.size), partner):
            tracks.append([int(here[j])])
            quiet.append(0)
    return [np.array(t, np.int64) for t in tracks]


def _scores(
    track: list[int], here: Ints, time_s: Floats, place: Floats, drms_m: Floats, max_speed_mps: float
) -> Floats:
    """How well plots continue a track: positive where they are within reach, larger where nearer."""
    last = track[-1]
    elapsed = time_s[here] - time_s[last]
    where = np.broadcast_to(place[last], (here.size, 2))
    blur = np.hypot(drms_m[last], drms_m[here])
    reach = max_speed_mps * np.maximum(elapsed, 0.0) + SIGMAS * blur
    if len(track) > 1:
        first = track[max(len(track) - 5, 0)]
        velocity = (place[last] - place[first]) / max(time_s[last] - time_s[first], 1e-9)
        speed = float(np.hypot(*velocity))
        velocity = velocity * min(1.0, max_speed_mps / max(speed, 1e-9))
        where = where + velocity * elapsed[:, None]
    miss = np.hypot(*(place[here] - where).T)
    return np.where(miss <= reach, 1.0 - miss / np.maximum(reach, 1e-9) + 1e-6, -np.inf)
