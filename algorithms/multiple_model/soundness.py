"""Whether what the filter reports still means something: predictions that are no numbers, covariances that are none."""

from __future__ import annotations

import numpy as np

from algorithms.multiple_model.states import Report
from algorithms.result import Note
from algorithms.toolbox.kernels.symmetric import unpack

LARGEST_NEGATIVE = 1e-9
"""Of the largest eigenvalue: what lies further below zero is no rounding any more."""
AT_ONCE = 20_000


def drop_lost(report: Report) -> list[Note]:
    """Leave out predictions without a measurement that are no numbers (an estimate gone astray, in free fall)."""
    sound = np.isfinite(report.state).all(axis=1) & np.isfinite(report.covariance).all(axis=1)
    lost = (report.track > 0) & ~sound
    count = int(lost.sum())
    if not count:
        return []
    report.track[lost] = 0
    for array in (report.state, report.covariance, report.probability):
        np.moveaxis(array, 1, 2)[lost] = np.nan
    return [Note("prediction_lost", "predictions that were no numbers were left out", count)]


def indefinite(report: Report) -> list[Note]:
    """Count covariances with an eigenvalue below -1e-9 of the largest one; they stay as they are.

    Triangles alone are kept, so a covariance is symmetric. Most are settled by the factor of the matrix with that much
    on its diagonal (a constant-velocity model has rows of zeros, so it has none by itself).
    """
    known = np.moveaxis(report.covariance, 1, 2)
    known = known[np.isfinite(known).all(axis=-1)]
    count = 0
    for first in range(0, len(known), AT_ONCE):
        full = unpack(known[first : first + AT_ONCE], axis=1)
        n = full.shape[-1]
        # The trace is at most n times the largest eigenvalue: this raises each by no more than what is allowed.
        slack = LARGEST_NEGATIVE / n * np.maximum(np.trace(full, axis1=1, axis2=2), 1e-300)
        try:
            np.linalg.cholesky(full + slack[:, None, None] * np.eye(n))
        except np.linalg.LinAlgError:
            values = np.linalg.eigvalsh(full)
            count += int((values[:, 0] < -LARGEST_NEGATIVE * np.abs(values).max(axis=1)).sum())
    if not count:
        return []
    return [Note("covariance_indefinite", "covariances had an eigenvalue below zero by more than rounding", count)]
