"""Plots of one radar joined to tracks where the recording does not say which belong together.

Look by look the plots are assigned to the tracks so far, by the squared distance to where a track goes on: its
covariance is that of both plots and, for what a track may do in between, of a speed of a third of the largest one in
every direction. A track ends after `PATIENCE` looks without a plot.

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
# Beyond this squared distance a plot does not continue a track.
FARTHEST = 25.0


def linked(looks: list[Ints], time_s: Floats, place: Floats, covariance: Floats, max_speed_mps: float) -> list[Ints]:
    """Positions of the plots of each track, in the order of time.

    Parameters
    ----------
    looks : positions of the radar's plots at each look
    time_s, place, covariance : (M,), (M, 2), (M, 3) xx yy xy of all plots; NaN places are left out
    """
    tracks: list[list[int]] = []
    quiet: list[int] = []
    for rows in looks:
        here = rows[np.isfinite(place[rows, 0])]
        open_tracks = [i for i, q in enumerate(quiet) if q < PATIENCE]
        score = np.full((len(open_tracks), here.size), -np.inf)
        for n, i in enumerate(open_tracks):
            score[n] = _scores(tracks[i], here, time_s, place, covariance, max_speed_mps)
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
    track: list[int], here: Ints, time_s: Floats, place: Floats, covariance: Floats, max_speed_mps: float
) -> Floats:
    """How well plots continue a track: positive where they may, larger where nearer."""
    last = track[-1]
    elapsed = np.maximum(time_s[here] - time_s[last], 0.0)
    where = np.broadcast_to(place[last], (here.size, 2))
    if len(track) > 1:
        first = track[max(len(track) - 5, 0)]
        velocity = (place[last] - place[first]) / max(time_s[last] - time_s[first], 1e-9)
        velocity = velocity * min(1.0, max_speed_mps / max(float(np.hypot(*velocity)), 1e-9))
        where = where + velocity * elapsed[:, None]
    xx, yy, xy = (covariance[here] + covariance[last]).T
    free = (max_speed_mps * elapsed / 3) ** 2
    xx, yy = xx + free, yy + free
    dx, dy = (place[here] - where).T
    distance = (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy)
    return np.where(distance <= FARTHEST, FARTHEST + 1 - distance, -np.inf)
