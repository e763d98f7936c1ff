"""Altitude above the Earth as one scalar row, uncorrelated with the times of arrival.

chugunov2023, eqs. (24)-(26). Differences from the paper: see `algorithms.toolbox.frames.earth`.
"""

from __future__ import annotations

from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import LANES, kernel


@kernel
def altitude_row(altitude, at, x, n_axis, earth, h, nu):
    """Build the altitude row of one mark for a block of trials: h (3, LANES), nu (LANES,).

    `altitude` (LANES,) is in m, `at` (3, LANES) the point of linearisation, `x` the state to which nu refers.
    """
    for lane in range(LANES):
        value, gx, gy, gz = height_and_up(at[0, lane], at[1, lane], at[2, lane], earth)
        h[0, lane] = gx
        h[1, lane] = gy
        h[2, lane] = gz
        moved = (
            gx * (x[0, lane] - at[0, lane])
            + gy * (x[n_axis, lane] - at[1, lane])
            + gz * (x[2 * n_axis, lane] - at[2, lane])
        )
        nu[lane] = altitude[lane] - value - moved
