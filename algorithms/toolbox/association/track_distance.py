"""How far two tracks are from each other, in their own errors: may they be one target?

S = d' C^-1 d with d = x1 - x2 in place and velocity, four degrees of freedom; C = P1 + P2, less P12 + P12' where it is
known how their errors hang together.

References
----------
barshalom2001, section 8.4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DOF = 4


def track_distances(difference: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Squared normalised distances (N,) of pairs of tracks, and ln det C.

    Parameters
    ----------
    difference : (N, 4) m, m/s
    covariance : (N, 4, 4) of the difference, m2, m2/s, m2/s2; must have an inverse
    """
    d = difference
    solved = np.linalg.solve(covariance, d[:, :, None])[:, :, 0]
    statistic = d[:, 0] * solved[:, 0] + d[:, 1] * solved[:, 1] + d[:, 2] * solved[:, 2] + d[:, 3] * solved[:, 3]
    _, log_determinant = np.linalg.slogdet(covariance)
    return statistic, log_determinant
