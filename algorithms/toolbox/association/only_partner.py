"""The threshold rule: a measurement is decided where exactly one partner lies inside the gate.

With two targets this is the test of the paper: the own partner inside and the other outside is correct, the reverse is
wrong, and both inside or both outside leave the measurement undecided. Which side's measurements look for a partner is
the *reading*: A = the first radar's, B = the second's (the columns; transpose the statistics).

References
----------
prosov2008, the decision before table 1.

Differences from the paper
--------------------------
The two kinds of "undecided" are told apart: no partner is a gate too narrow, several are targets too close.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NOBODY = -1
SEVERAL = -2


def only_partners(statistic: Floats, threshold: float) -> Ints:
    """Column of the only partner inside the gate, or `NOBODY`, or `SEVERAL`.

    Parameters
    ----------
    statistic : (n, m, ...) squared distances of n measurements to m others; NaN lies outside
    threshold : from `gate.gate_threshold`; on the threshold is inside

    Returns
    -------
    partner : (n, ...)
    """
    inside = statistic <= threshold
    count = inside.sum(axis=1)
    if not statistic.shape[1]:
        return np.full(count.shape, NOBODY)
    return np.where(count == 1, inside.argmax(axis=1), np.where(count == 0, NOBODY, SEVERAL))
