"""Posterior Cramer-Rao bound of the filter's own model along a known track.

The covariance recursion of the filter with its Jacobians taken on the true track needs no data: it is what the filter
would claim if it knew where to linearise, and for nearly straight motion its physical limit.

References
----------
tichavsky1998; specification 8.1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.lanes import Setup
from algorithms.toolbox.kernels import LANES, kernel
from algorithms.toolbox.kernels.symmetric import pack, unpack
from algorithms.toolbox.kernels.unrolled import update_rows_9
from algorithms.toolbox.motion.jerk import predict_jerk
from algorithms.toolbox.sensors.altitude import altitude_row
from algorithms.toolbox.sensors.time_of_arrival import contrast_rows

Floats = NDArray[np.float64]


def posterior_covariance(
    time_s: Floats,
    truth_m: Floats,
    received: NDArray[np.bool_],
    decoded: NDArray[np.bool_],
    start: Floats,
    setup: Setup,
) -> Floats:
    """(M, 9, 9): covariance after each mark, linearised on the truth.

    Parameters
    ----------
    time_s : (M,) s; the first mark updates `start` without prediction
    truth_m : (M, 3) m
    received : (M, S), decoded : (M,)
        Which receptions and altitudes exist.
    start : (9, 9)
        Covariance before the first mark.
    """
    out = np.empty((len(time_s), 45))
    _recursion(time_s, truth_m, received.astype(float), decoded.astype(float), pack(start), setup, out)
    return unpack(out, axis=1)


@kernel
def _recursion(time, truth, received, decoded, start, setup, out):
    n_stations = setup.stations.shape[0]
    x = np.zeros((9, LANES))
    p = np.zeros((45, LANES))
    for k in range(45):
        p[k, :] = start[k]
    toa = np.zeros((n_stations, LANES))
    used = np.zeros((n_stations, LANES))
    at = np.zeros((3, LANES))
    h = np.empty((n_stations + 1, 3, LANES))
    nu = np.empty((n_stations + 1, LANES))
    var = np.empty((n_stations + 1, LANES))
    active = np.empty((n_stations + 1, LANES))
    t = np.zeros(LANES)
    nis = np.zeros(LANES)
    determinant = np.ones(LANES)
    altitude = np.zeros(LANES)
    for k in range(time.shape[0]):
        if k > 0:
            t[:] = time[k] - time[k - 1]
            predict_jerk(x, p, t, setup.sigma_jerk, setup.noise_form)
        for a in range(3):
            at[a, :] = truth[k, a]
            x[3 * a, :] = truth[k, a]
        for s in range(n_stations):
            used[s, :] = received[k, s]
        contrast_rows(toa, used, setup.stations, setup.variance, at, x, 3, h, nu, var, active)
        altitude_row(altitude, at, x, 3, setup.earth, h[n_stations], nu[n_stations])
        var[n_stations, :] = setup.altitude_variance
        active[n_stations, :] = decoded[k] if setup.use_altitude else 0.0
        nu[:, :] = 0.0
        update_rows_9(x, p, at, h, nu, var, active, nis, determinant)
        for i in range(45):
            out[k, i] = p[i, 0]
