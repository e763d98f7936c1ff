"""Doppler frequency of what a moving target scatters from a transmitter to a receiver, and its derivatives.

    f = -(1 / lambda) [ (p - TX) v / |p - TX| + (p - RX) v / |p - RX| ],

positive while the sum of the ranges shrinks. For each foot A with q = p - A, r = |q|:

    df/dp = -(1 / lambda) sum [ v / r - (q v) q / r^3 ],   df/dv = -(1 / lambda) sum q / r.

References
----------
scatter2014; specification 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import strict

Floats = NDArray[np.float64]

# A target at a foot has no direction from it; it is taken to be this far away.
AT_FOOT_M = 1e-3


def doppler_hz(
    position_m: Floats, velocity_mps: Floats, transmitter_m: Floats, receiver_m: Floats, wavelength_m: float
) -> Floats:
    """Doppler frequencies (...,) of positions and velocities (..., 3), m and m/s, between two feet (3,)."""
    rate = np.zeros(position_m.shape[:-1], position_m.dtype)
    for foot in (transmitter_m, receiver_m):
        q = position_m - foot
        r = np.sqrt((q * q).sum(axis=-1))
        rate = rate + (q * velocity_mps).sum(axis=-1) / np.where(abs(r) < AT_FOOT_M, AT_FOOT_M, r)
    return np.asarray(-rate / wavelength_m)


@strict
def doppler(x, y, z, vx, vy, vz, feet, wavelength):
    """Doppler of one target, Hz; `feet` (2, 3) m are transmitter and receiver."""
    rate = 0.0
    for i in range(2):
        qx = x - feet[i, 0]
        qy = y - feet[i, 1]
        qz = z - feet[i, 2]
        r = max(np.sqrt(qx * qx + qy * qy + qz * qz), AT_FOOT_M)
        rate += (qx * vx + qy * vy + qz * vz) / r
    return -rate / wavelength


@strict
def doppler_gradient(x, y, z, vx, vy, vz, feet, wavelength, gradient):
    """Doppler of one target, and its derivatives by x, y, z, vx, vy, vz into `gradient` (6,)."""
    rate = 0.0
    for i in range(6):
        gradient[i] = 0.0
    for i in range(2):
        qx = x - feet[i, 0]
        qy = y - feet[i, 1]
        qz = z - feet[i, 2]
        r = max(np.sqrt(qx * qx + qy * qy + qz * qz), AT_FOOT_M)
        qv = qx * vx + qy * vy + qz * vz
        rate += qv / r
        per = 1.0 / (wavelength * r)
        along = qv / (r * r)
        gradient[0] -= per * (vx - along * qx)
        gradient[1] -= per * (vy - along * qy)
        gradient[2] -= per * (vz - along * qz)
        gradient[3] -= per * qx
        gradient[4] -= per * qy
        gradient[5] -= per * qz
    return -rate / wavelength
