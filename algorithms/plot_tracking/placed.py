"""Covariances of fitted trajectories, in the words of a track: east, north and their velocities."""

from __future__ import annotations

import numpy as np

from algorithms.plot_tracking.window import covariance_of
from algorithms.toolbox.motion.curvature import Floats


def covariances_of(information: Floats) -> Floats:
    """(6, 6, E); a line knows nothing of acceleration and curvature, and its rows of them are zero."""
    out = np.zeros_like(information)
    straight = information[5, 5] == 0
    line, curved = np.flatnonzero(straight), np.flatnonzero(~straight)
    out[:4, :4, line] = covariance_of(information[:4, :4, line])
    out[:, :, curved] = covariance_of(information[:, :, curved])
    return out


def placed(covariance: Floats, p: Floats, ahead: Floats) -> Floats:
    """(E, 4, 4) of east, north and their velocities; while coasting the uncertain velocity widens it."""
    course, speed = p[2], p[3]
    sin, cos = np.sin(course), np.cos(course)
    to = np.zeros((4, 6, ahead.size))
    to[0, 1] = to[1, 0] = 1.0
    to[0, 2], to[1, 2] = ahead * speed * cos, -ahead * speed * sin
    to[0, 3], to[1, 3] = ahead * sin, ahead * cos
    to[2, 2], to[3, 2] = speed * cos, -speed * sin
    to[2, 3], to[3, 3] = sin, cos
    out: Floats = np.einsum("ime,mne,jne->eij", to, covariance, to)
    return out
