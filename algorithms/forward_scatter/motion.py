"""Motion past the base line, theta = (tau, s, v_y, v_x, a_y), and the Doppler frequencies that it gives.

With d = t - tau:  x = s + v_x d,  y = v_y d + a_y d^2 / 2,  z = H. By theta, with the derivatives of the sensor:

    d/dtau = -df/dp v - df/dv (0, a_y, 0),   d/ds = df/dp_x,   d/dv_y = d df/dp_y + df/dv_y,
    d/dv_x = d df/dp_x + df/dv_x,            d/da_y = d^2/2 df/dp_y + d df/dv_y.

References
----------
scatter2014; specification 2, 3, 5. Differences from the paper: it knows tau, s and v_y only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import strict
from algorithms.toolbox.sensors.doppler import doppler, doppler_gradient

Floats = NDArray[np.float64]

UNKNOWNS = 5
"""tau, s, v_y, v_x, a_y, in this order everywhere."""

# Beyond this condition number of the scaled information nothing is said about the bound.
LARGEST_CONDITION = 1e13


@strict
def model(t, theta, altitude, feet, wavelength):
    """Doppler at instant t, Hz."""
    d = t - theta[0]
    x = theta[1] + theta[3] * d
    y = theta[2] * d + 0.5 * theta[4] * d * d
    return doppler(x, y, altitude, theta[3], theta[2] + theta[4] * d, 0.0, feet, wavelength)


@strict
def model_gradient(t, theta, altitude, feet, wavelength, work, gradient):
    """Doppler at instant t, and its derivatives by theta into `gradient` (5,); `work` is (6,)."""
    d = t - theta[0]
    x = theta[1] + theta[3] * d
    y = theta[2] * d + 0.5 * theta[4] * d * d
    vy = theta[2] + theta[4] * d
    f = doppler_gradient(x, y, altitude, theta[3], vy, 0.0, feet, wavelength, work)
    gradient[0] = -work[0] * theta[3] - work[1] * vy - work[4] * theta[4]
    gradient[1] = work[0]
    gradient[2] = d * work[1] + work[4]
    gradient[3] = d * work[0] + work[3]
    gradient[4] = 0.5 * d * d * work[1] + d * work[4]
    return f


@strict
def _rows(time, theta, altitude, feet, wavelength, value, rows):
    work = np.empty(6)
    for c in range(feet.shape[0]):
        for k in range(time.shape[0]):
            value[c, k] = model_gradient(time[k], theta, altitude, feet[c], wavelength, work, rows[c, k])


def doppler_rows(
    time_s: Floats, theta: Floats, feet_m: Floats, wavelength_m: float, altitude_m: float = 0.0
) -> tuple[Floats, Floats]:
    """Return Dopplers (C, K) Hz and their derivatives (C, K, 5) by theta for the channels' feet (C, 2, 3) m."""
    value = np.empty((len(feet_m), len(time_s)))
    rows = np.empty((*value.shape, UNKNOWNS))
    _rows(np.ascontiguousarray(time_s, np.float64), theta, altitude_m, feet_m, wavelength_m, value, rows)
    return value, rows


def crossing_bound(
    rows: Floats, measured: NDArray[np.bool_], sigma_hz: float, unknowns: int, extra: Floats | None = None
) -> Floats:
    """Cramer-Rao bound (K, unknowns) of the standard deviations after each instant; NaN where it is not available.

    Parameters
    ----------
    rows : (C, K, 5) derivatives of the Dopplers by theta, of which the first `unknowns` are unknown
    measured : (C, K) which Dopplers there are
    extra : (K, 5, 5) information of other measurements at each instant, such as angles
    """
    k, p = rows.shape[1], unknowns
    g = np.where(measured[:, :, None], rows[:, :, :p], 0.0)
    info = np.einsum("cki,ckj->kij", g, g) / sigma_hz**2
    if extra is not None:
        info += extra[:, :p, :p]
    info = np.cumsum(info, axis=0)
    out = np.full((k, p), np.nan)
    for i in range(k):
        scale = np.sqrt(np.diagonal(info[i]))
        if not (scale > 0).all():
            continue
        scaled = info[i] / np.outer(scale, scale)
        if np.linalg.cond(scaled) < LARGEST_CONDITION:
            out[i] = np.sqrt(np.diagonal(np.linalg.inv(scaled))) / scale
    return out
