"""Quantiles of the chi-square law."""

from __future__ import annotations

import numpy as np
from scipy.special import gammaincinv

from backend.charts.columns import Floats


def chi_square_band(dof: Floats, probability: float = 0.95) -> tuple[Floats, Floats]:
    """Limits that hold a chi-square variable of `dof` degrees of freedom with the given probability, tails equal.

    The law is a gamma law of shape dof/2 and scale 2, so a quantile is twice the inverse of the regularised lower
    incomplete gamma function.
    """
    # A million marks have a handful of different degrees of freedom.
    distinct, place = np.unique(np.asarray(dof, np.float64), return_inverse=True)
    tail = (1 - probability) / 2
    return 2 * gammaincinv(distinct / 2, tail)[place], 2 * gammaincinv(distinct / 2, 1 - tail)[place]
