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

from algorithms.multilateration.conditions import conditions_of, toa_of
from algorithms.multilateration.lanes import START_ACCELERATION_SD_MPS2, START_VELOCITY_SD_MPS, Setup
from algorithms.multilateration.parameters import FilterParameters
from algorithms.multilateration.tracker import filter_setup, start_covariance
from algorithms.recording import ToaMarks
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
    """(M, 9, 9, L): covariance after each mark, linearised on the truth, of L <= LANES patterns of receptions.

    Parameters
    ----------
    time_s : (M,) s; the first mark updates `start` without prediction
    truth_m : (M, 3) m
    received : (M, S, L), decoded : (M, L)
        Which receptions and altitudes exist.
    start : (9, 9)
        Covariance before the first mark.
    """
    lanes = decoded.shape[1]
    out = np.empty((len(time_s), 45, LANES))
    pattern = np.zeros((*received.shape[:2], LANES))
    pattern[:, :, :lanes] = received
    heights = np.zeros((len(time_s), LANES))
    heights[:, :lanes] = decoded
    _recursion(time_s, truth_m, pattern, heights, pack(start), setup, out)
    return unpack(out[:, :, :lanes], axis=1)


def horizontal_bound(recording: ToaMarks, parameters: FilterParameters, *, altitude: bool) -> Floats:
    """(M,) m: bound of the rms horizontal error at each mark, over the reception patterns of up to 16 trials.

    The bound of a pattern holds for the mean square error of the trials with that pattern, so mean squares are
    averaged. A filter that starts by itself is given a prior that says next to nothing (100 km).
    """
    conditions = conditions_of(recording, parameters, profile=parameters.profile, with_altitude=altitude)
    setup = filter_setup(recording, parameters, conditions, altitude=altitude)
    start = start_covariance(parameters.start) if parameters.start.mode != "auto" else np.diag(_NOTHING_KNOWN)
    received = np.isfinite(toa_of(recording, conditions))[:, :, :LANES]
    decoded = np.isfinite(recording.altitude_m)[:, :LANES]
    out = np.full(len(recording), np.nan)
    for target in range(len(recording.targets)):
        rows = recording.rows_of(target)
        if rows.size:
            p = posterior_covariance(
                recording.time_s[rows], recording.truth_m[rows], received[rows], decoded[rows], start, setup
            )
            out[rows] = np.sqrt((p[:, 0, 0] + p[:, 3, 3]).mean(axis=1))
    return out


_NOTHING_KNOWN = np.square(np.tile([1e5, START_VELOCITY_SD_MPS, START_ACCELERATION_SD_MPS2], 3))


@kernel
def _recursion(time, truth, received, decoded, start, setup, out):
    n_stations = setup.stations.shape[0]
    x = np.zeros((9, LANES))
    p = np.zeros((45, LANES))
    for k in range(45):
        p[k, :] = start[k]
    toa = np.zeros((n_stations, LANES))
    at = np.zeros((3, LANES))
    h = np.empty((n_stations + 1, 3, LANES))
    nu = np.empty((n_stations + 1, LANES))
    var = np.empty((n_stations + 1, LANES))
    active = np.empty((n_stations + 1, LANES))
    sums = np.zeros(6 * LANES)
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
        contrast_rows(toa, received[k], setup.stations, setup.variance, at, x, 3, h, nu, var, active, sums)
        altitude_row(altitude, at, x, 3, setup.earth, h[n_stations], nu[n_stations])
        var[n_stations, :] = setup.altitude_variance
        for lane in range(LANES):
            active[n_stations, lane] = decoded[k, lane] if setup.use_altitude else 0.0
        nu[:, :] = 0.0
        update_rows_9(x, p, at, h, nu, var, active, nis, determinant)
        for i in range(45):
            for lane in range(LANES):
                out[k, i, lane] = p[i, lane]
