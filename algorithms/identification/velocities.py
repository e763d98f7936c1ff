"""Velocities of targets from a sequence of uncertain positions: what a wrong clock shifts targets along.

Each position gets the velocity of the straight line through all positions of its track, or, where the track turns,
through those before and after it, weighted with their information. A line that the positions do not follow gives none.

References
----------
barshalom2001, section 3.4 (weighted least squares).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.linking import linked

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Fewer positions leave a line nothing to be tested by.
FEWEST = 4
# So many positions make one line where the whole track is none: targets turn in the long run.
WINDOWS = (15, 9, 5)
# Positions are on a line where their squared residuals are at most so many times what their covariances say.
ON_A_LINE = 4.0
# Linking takes long where there are very many.
MOST_POSITIONS = 4000


@dataclass(frozen=True)
class Lines:
    """The straight line through each of M positions and its neighbours; NaN where there is none.

    Attributes
    ----------
    velocity : (M, 2) m/s
    covariance : (M, 2, 2) m2/s2 of the velocity
    with_place : (M, 2, 2) m2/s covariance of the position itself (rows) and the velocity: the line goes through it too
    """

    velocity: Floats
    covariance: Floats
    with_place: Floats

    def put(self, own: Ints, window: Ints, found: tuple[Floats, Floats] | None, time_s: Floats) -> None:
        """Give positions `own` the line that was found through those of the window."""
        if found is None:
            return
        velocity, normal = found
        spread = np.linalg.inv(normal)
        self.velocity[own] = velocity
        self.covariance[own] = spread[2:, 2:]
        # v = sum G_j z_j with G_i = (C_vx + tau_i C_vv) R_i^-1, so that cov(z_i, v) = R_i G_i' = C_xv + tau_i C_vv.
        tau = time_s[own] - time_s[window].mean()
        self.with_place[own] = spread[:2, 2:] + tau[:, None, None] * spread[2:, 2:]


def joined_tracks(
    looks: list[Ints], named: Ints, time_s: Floats, place: Floats, covariance: Floats, max_speed_mps: float
) -> list[Ints]:
    """Positions that belong to one target each, in the order of time.

    Parameters
    ----------
    looks : positions at each look, in the order of time
    named : (M,) number of the target of each position, -1 = not known; positions with a number are not linked
    time_s, place, covariance : (M,), (M, 2), (M, 3) xx yy xy
    """
    tracks = [np.flatnonzero(named == k) for k in np.unique(named[named >= 0])]
    free = [rows[named[rows] < 0] for rows in looks]
    if any(rows.size for rows in free):
        tracks += linked(free, time_s, place, covariance, max_speed_mps)
    return [rows[np.argsort(time_s[rows], kind="stable")] for rows in tracks]


def velocities(tracks: list[Ints], time_s: Floats, place: Floats, covariance: Floats) -> Floats:
    """(M, 2) m/s of each position, NaN where no line goes through it and its neighbours."""
    return lines(tracks, time_s, place, covariance).velocity


def lines(tracks: list[Ints], time_s: Floats, place: Floats, covariance: Floats) -> Lines:
    """Lines through each position and its neighbours; NaN where there is none."""
    marks = len(place)
    out = Lines(np.full((marks, 2), np.nan), np.full((marks, 2, 2), np.nan), np.full((marks, 2, 2), np.nan))
    for rows in tracks:
        if rows.size < FEWEST:
            continue
        # The longer the line the better the velocity, so a whole straight flight is one.
        out.put(rows, rows, _line(time_s[rows], place[rows], covariance[rows]), time_s)
        for width in WINDOWS:
            if np.isfinite(out.velocity[rows, 0]).all():
                break
            first = np.clip(np.arange(rows.size) - width // 2, 0, max(rows.size - width, 0))
            for begin in np.unique(first[~np.isfinite(out.velocity[rows, 0])]):
                window = rows[begin : begin + width]
                own = rows[first == begin]
                own = own[~np.isfinite(out.velocity[own, 0])]
                out.put(own, window, _line(time_s[window], place[window], covariance[window]), time_s)
    return out


def _line(time_s: Floats, place: Floats, covariance: Floats) -> tuple[Floats, Floats] | None:
    """(2,) velocity of the line through the positions, and its normal matrix (4, 4); None where they do not follow it.

    The normal matrix is that of the place at the mean instant and the velocity.
    """
    tau = time_s - time_s.mean()
    if np.unique(time_s).size < FEWEST:
        return None
    xx, yy, xy = covariance.T
    determinant = xx * yy - xy * xy
    weight = np.stack([np.stack([yy, -xy], axis=1), np.stack([-xy, xx], axis=1)], axis=1) / determinant[:, None, None]
    middle = place - place.mean(axis=0)
    pull = (weight @ middle[:, :, None])[:, :, 0]
    normal = np.block(
        [
            [weight.sum(axis=0), (tau[:, None, None] * weight).sum(axis=0)],
            [(tau[:, None, None] * weight).sum(axis=0), (tau[:, None, None] ** 2 * weight).sum(axis=0)],
        ]
    )
    right = np.concatenate([pull.sum(axis=0), (tau[:, None] * pull).sum(axis=0)])
    theta = np.linalg.solve(normal, right)
    rest = float((middle * pull).sum() - right @ theta)
    if rest > ON_A_LINE * (2 * time_s.size - 4):
        return None
    return theta[2:], normal
