"""Times of arrival at several stations as mutually uncorrelated scalar rows.

c TOA_i = r_i + c t_emit + n_i with unknown t_emit. Instead of differences against one reference station, whose noise
is correlated, *Helmert contrasts* are used: reception j against the weighted mean of the receptions before it,

    d_j = z_j - m_j,   h_j = u_j - mean(u),   var = sigma_j^2 + 1 / sum_{i<j} sigma_i^-2,

with u_i = (p - s_i) / r_i. The contrasts span the same space as the differences, are mutually uncorrelated, and the
choice of a reference disappears; a missing reception is a row with gain zero.

Differences from the paper: it uses differences against the last station with the full covariance
V = (c sigma)^2 (I + 1 1^T) (chugunov2023, eqs. (8), (17)); the update is algebraically the same.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import LANES, kernel

SPEED_OF_LIGHT_MPS = 299_792_458.0

# An emitter this near to a station has no direction from it: that reception is left out.
AT_STATION_M = 1e-3


@kernel
def contrast_rows(toa_m, used, stations, variance, at, x, n_axis, h, nu, var, active):
    """Build the rows of one mark for a block of trials.

    Parameters
    ----------
    toa_m : (S, LANES), c times the times of arrival, m
    used : (S, LANES), 1 where received
    stations : (S, 3), m
    variance : (S,), m^2
    at : (3, LANES), point of linearisation, m
    x : (n, LANES), state whose position (components 0, n_axis, 2 n_axis) the innovations refer to
    h : (S, 3, LANES), nu, var, active : (S, LANES)
        The rows; row 0 of a lane's first reception is inactive.
    """
    weight = np.zeros(LANES)
    mean_z = np.zeros(LANES)
    mean_r = np.zeros(LANES)
    mean_u = np.zeros((3, LANES))
    for s in range(stations.shape[0]):
        sx = stations[s, 0]
        sy = stations[s, 1]
        sz = stations[s, 2]
        v = variance[s]
        for lane in range(LANES):
            dx = at[0, lane] - sx
            dy = at[1, lane] - sy
            dz = at[2, lane] - sz
            r = np.sqrt(dx * dx + dy * dy + dz * dz)
            here = used[s, lane] if r > AT_STATION_M else 0.0
            safe = r if r > AT_STATION_M else 1.0
            dx /= safe
            dy /= safe
            dz /= safe
            z = toa_m[s, lane]
            before = weight[lane]
            row = here if before > 0.0 else 0.0
            h0 = dx - mean_u[0, lane]
            h1 = dy - mean_u[1, lane]
            h2 = dz - mean_u[2, lane]
            h[s, 0, lane] = h0
            h[s, 1, lane] = h1
            h[s, 2, lane] = h2
            moved = (
                h0 * (x[0, lane] - at[0, lane])
                + h1 * (x[n_axis, lane] - at[1, lane])
                + h2 * (x[2 * n_axis, lane] - at[2, lane])
            )
            nu[s, lane] = (z - mean_z[lane]) - (r - mean_r[lane]) - moved
            var[s, lane] = v + 1.0 / (before if before > 0.0 else 1.0)
            active[s, lane] = row
            gain = here / (v * before + 1.0)
            weight[lane] = before + here / v
            mean_z[lane] += gain * (z - mean_z[lane])
            mean_r[lane] += gain * (r - mean_r[lane])
            mean_u[0, lane] += gain * (dx - mean_u[0, lane])
            mean_u[1, lane] += gain * (dy - mean_u[1, lane])
            mean_u[2, lane] += gain * (dz - mean_u[2, lane])
