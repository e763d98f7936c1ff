"""Slant range and altitude to ground range, over a sphere that touches the radar's horizon plane.

A target at slant range r and altitude h above the radar stands z above the horizon plane of the radar and d away
from it in that plane. On a sphere of radius R through the radar, (R + z)^2 + d^2 = (R + h)^2 and d^2 + z^2 = r^2, so

    z = h + (h^2 - r^2) / (2 R),    d = sqrt(r^2 - z^2).

d is the distance in the plane of a local frame whose zero is the radar. The flat formula sqrt(r^2 - h^2) is wrong by
h r / (2 R) at far: 80 m at 100 km and 10 km height. Refraction is left out (a target at 100 km appears 0.2 mrad too
high, which neither range nor altitude notice).

References
----------
chugunov2023, eq. (1), solved for z.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.frames.earth import R_PAPER_M

Floats = NDArray[np.float64]


def ground_from_slant(
    slant_m: Floats, altitude_m: Floats, radar_altitude_m: Floats | float, radius_m: float = R_PAPER_M
) -> tuple[Floats, Floats]:
    """Distance in the radar's horizon plane and height above it, m.

    Parameters
    ----------
    slant_m, altitude_m : float, m; the altitude above the sphere of `radius_m`
    radar_altitude_m : float, m, above the same sphere

    Returns
    -------
    ground_m, up_m : float, m; the ground range is NaN where no point at that range has that altitude, and both are
        NaN where the altitude is.
    """
    h = altitude_m - radar_altitude_m
    z = h + (h * h - slant_m * slant_m) / (2.0 * (radius_m + radar_altitude_m))
    with np.errstate(invalid="ignore"):
        return np.sqrt((slant_m - z) * (slant_m + z)), z
