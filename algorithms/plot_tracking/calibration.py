"""In which of the three ellipses of its tracking gate each plot lay: with right accuracies 65, 30 and 5 % of them.

`curvature_tracker` decides by these ellipses. `imm_tracker` has one gate; its plots are put into the ellipses by their
distances, which are those of a two-dimensional Gaussian where the filter is honest.

References
----------
Specification 5, 10.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.gates import radius_of
from algorithms.plot_tracking.outputs import MANOEUVRE, MIDDLE, TRACKING_GATE, UPDATED

Ints = NDArray[np.int64]

NO_CLASS, INNER, MIDDLE_ONE, OUTER = -1, 0, 1, 2


def gate_classes(arrays: dict[str, Any]) -> Ints:
    """(M, L) the ellipse of each plot that one track took in its tracking gate; -1 of all others."""
    decision = arrays["decision"]
    of_one = np.isin(decision, (UPDATED, MIDDLE, MANOEUVRE)) & (arrays["gate"] == TRACKING_GATE)
    if "estimate_weights" in arrays:
        found = np.searchsorted(radius_of(np.array([0.65, 0.95])), arrays["distance"])
    else:
        found = np.where(decision == UPDATED, INNER, np.where(decision == MIDDLE, MIDDLE_ONE, OUTER))
    return np.where(of_one, found, NO_CLASS)
