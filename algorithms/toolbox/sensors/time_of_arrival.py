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
def contrast_rows(toa_m, used, stations, variance, at, x, n_axis, h, nu, var, active, sums):
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
    sums : (6 LANES,)
        Workspace.
    """
    # Flat views and one row of sums: with known row lengths the compiler sees what does not overlap, and vectorises.
    for i in range(6 * LANES):
        sums[i] = 0.0  # weight, then the means of z, r, u
    z = toa_m.reshape(toa_m.size)
    here = used.reshape(used.size)
    point = at.reshape(at.size)
    state = x.reshape(x.size)
    rows = h.reshape(h.size)
    out_nu = nu.reshape(nu.size)
    out_var = var.reshape(var.size)
    out_active = active.reshape(active.size)
    y = n_axis * LANES
    for s in range(stations.shape[0]):
        sx = stations[s, 0]
        sy = stations[s, 1]
        sz = stations[s, 2]
        v = variance[s]
        first = s * LANES
        for lane in range(LANES):
            px = point[lane]
            py = point[LANES + lane]
            pz = point[2 * LANES + lane]
            dx = px - sx
            dy = py - sy
            dz = pz - sz
            r = np.sqrt(dx * dx + dy * dy + dz * dz)
            apart = r > AT_STATION_M
            per_r = 1.0 / (r if apart else 1.0)
            dx *= per_r
            dy *= per_r
            dz *= per_r
            received = here[first + lane] if apart else 0.0
            before = sums[lane]
            h0 = dx - sums[3 * LANES + lane]
            h1 = dy - sums[4 * LANES + lane]
            h2 = dz - sums[5 * LANES + lane]
            dz_ = z[first + lane] - sums[LANES + lane]
            dr = r - sums[2 * LANES + lane]
            rows[3 * first + lane] = h0
            rows[3 * first + LANES + lane] = h1
            rows[3 * first + 2 * LANES + lane] = h2
            moved = h0 * (state[lane] - px) + h1 * (state[y + lane] - py) + h2 * (state[2 * y + lane] - pz)
            out_nu[first + lane] = dz_ - dr - moved
            out_var[first + lane] = v + 1.0 / (before if before > 0.0 else 1.0)
            out_active[first + lane] = received if before > 0.0 else 0.0
            gain = received / (v * before + 1.0)
            sums[lane] = before + received / v
            sums[LANES + lane] += gain * dz_
            sums[2 * LANES + lane] += gain * dr
            sums[3 * LANES + lane] += gain * h0
            sums[4 * LANES + lane] += gain * h1
            sums[5 * LANES + lane] += gain * h2
