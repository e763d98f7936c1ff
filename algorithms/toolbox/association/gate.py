"""Chi-square gates: may two independent estimates of a point belong to the same target?

References
----------
barshalom2001, section 1.4.17; prosov2008, the test after eq. (4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from algorithms.errors import SingularGeometryError

Floats = NDArray[np.float64]

# Beyond this ratio of the axes' variances the inverse has no digits left in double precision.
LARGEST_CONDITION = 1e14


def gate_threshold(tail: float, dof: int) -> float:
    """Return the squared distance that a true pair exceeds with probability `tail` (two dimensions: -2 ln tail)."""
    return -2.0 * float(np.log(tail)) if dof == 2 else float(chi2.isf(tail, dof))


def squared_distances(difference: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Squared normalised distances S = d' C^(-1) d in the plane, and ln det C.

    Parameters
    ----------
    difference : (..., 2) m
    covariance : (..., 2, 2) m2, of the difference; for two independent points the sum of their covariances

    Returns
    -------
    statistic, log_determinant : (...), NaN where an input is

    Raises
    ------
    SingularGeometryError
        A covariance that has no inverse: both points are unknown along the same line only.
    """
    xx, yy, xy = covariance[..., 0, 0], covariance[..., 1, 1], covariance[..., 0, 1]
    determinant = xx * yy - xy * xy
    trace = xx + yy
    # For a small ratio of the eigenvalues their product over the square of their sum is that ratio.
    if (determinant * LARGEST_CONDITION <= trace * trace).any():
        raise SingularGeometryError(
            "The covariance of the difference of two points is singular.",
            remedy="Look at the accuracies of range and azimuth: one is many orders of magnitude from the other.",
        )
    dx, dy = difference[..., 0], difference[..., 1]
    return (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / determinant, np.log(determinant)
