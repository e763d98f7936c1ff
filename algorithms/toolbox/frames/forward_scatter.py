"""The frame of a forward-scatter site: from the receivers towards the transmitter, and along the receivers.

Origin O = middle of the receivers, x horizontal from O towards the middle of the transmitters, y to the left of it, z
up. From East-North-Up with the bearing alpha of the x axis:

    x = E cos alpha + N sin alpha,   y = -E sin alpha + N cos alpha,   z = U   (each counted from O).

References
----------
scatter2014; specification 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import FrameError

Floats = NDArray[np.float64]

# A base shorter than this is no base: the places were given twice.
LEAST_BASE_M = 1.0


@dataclass(frozen=True)
class ScatterFrame:
    """Place and direction of the frame in the local ENU frame."""

    origin_m: Floats
    """(3,) m: middle of the receivers."""
    cosine: float
    sine: float

    def from_enu(self, points_m: Floats) -> Floats:
        """Turn points (..., 3) m from ENU into x, y, z."""
        return self.turned_from_enu(points_m - self.origin_m)

    def to_enu(self, points_m: Floats) -> Floats:
        """Turn points (..., 3) m from x, y, z into ENU."""
        return self.turned_to_enu(points_m) + self.origin_m

    def turned_from_enu(self, vectors: Floats) -> Floats:
        """Turn vectors (..., 3), such as velocities, from ENU into x, y, z."""
        e, n, u = vectors[..., 0], vectors[..., 1], vectors[..., 2]
        return np.stack([self.cosine * e + self.sine * n, self.cosine * n - self.sine * e, u], axis=-1)

    def turned_to_enu(self, vectors: Floats) -> Floats:
        """Turn vectors (..., 3) from x, y, z into ENU."""
        x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
        return np.stack([self.cosine * x - self.sine * y, self.sine * x + self.cosine * y, z], axis=-1)


def scatter_frame(transmitters_m: Floats, receivers_m: Floats) -> ScatterFrame:
    """Return the frame of a site whose transmitters (T, 3) and receivers (R, 3) stand in ENU, m.

    Raises
    ------
    FrameError
        Transmitters and receivers stand at the same place in the plan.
    """
    origin = receivers_m.mean(axis=0)
    east, north, _ = transmitters_m.mean(axis=0) - origin
    base = float(np.hypot(east, north))
    if base < LEAST_BASE_M:
        raise FrameError(
            "Transmitters and receivers stand at the same place, so there is no base line.",
            pointer="/site",
            remedy="Give their true places.",
            code="no_base_line",
        )
    return ScatterFrame(origin, float(east / base), float(north / base))
