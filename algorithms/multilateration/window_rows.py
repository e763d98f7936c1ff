"""Normal equations of a window of marks for a polynomial in time: the compiled part of `window_ml`."""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import strict


@strict
def window_normal(tau, toa, altitude, usable, window, theta, stations, weight, altitude_weight, earth, info, grad):
    """Information (3 n, 3 n) and gradient (3 n,) of one trial's window, filled; cost and count of the data.

    Parameters
    ----------
    tau : (J,) s, time since the newest mark; toa : (J, S) m, NaN = none; altitude : (J,) m; usable : (J,)
    window : s, how old a mark may be
    theta : (3 n,) position and derivatives on each axis
    weight : (S,) 1/m^2; altitude_weight : 1/m^2
    """
    size = theta.shape[0]
    n = size // 3
    m = stations.shape[0]
    f = np.ones(3)
    place = np.zeros(3)
    u = np.zeros((m, 3))
    e = np.zeros(m)
    a = np.zeros((3, 3))
    g = np.zeros(3)
    mean_u = np.zeros(3)
    for i in range(size):
        grad[i] = 0.0
        for j in range(size):
            info[i, j] = 0.0
    cost = 0.0
    count = 0
    for k in range(tau.shape[0]):
        if not usable[k] or -tau[k] > window:
            continue
        f[1] = tau[k]
        f[2] = 0.5 * tau[k] * tau[k]
        for axis in range(3):
            place[axis] = 0.0
            g[axis] = 0.0
            mean_u[axis] = 0.0
            for i in range(n):
                place[axis] += theta[axis * n + i] * f[i]
            for other in range(3):
                a[axis, other] = 0.0
        total = 0.0
        mean_e = 0.0
        heard = 0
        for s in range(m):
            if np.isfinite(toa[k, s]):
                dx = place[0] - stations[s, 0]
                dy = place[1] - stations[s, 1]
                dz = place[2] - stations[s, 2]
                r = max(np.sqrt(dx * dx + dy * dy + dz * dz), 1.0)
                u[s, 0] = dx / r
                u[s, 1] = dy / r
                u[s, 2] = dz / r
                e[s] = toa[k, s] - r
                total += weight[s]
                mean_e += weight[s] * e[s]
                for axis in range(3):
                    mean_u[axis] += weight[s] * u[s, axis]
                heard += 1
        for s in range(m):
            if np.isfinite(toa[k, s]):
                off = e[s] - mean_e / total
                cost += weight[s] * off * off
                for axis in range(3):
                    d = u[s, axis] - mean_u[axis] / total
                    g[axis] += weight[s] * d * off
                    for other in range(3):
                        a[axis, other] += weight[s] * d * (u[s, other] - mean_u[other] / total)
        count += heard - 1 if heard > 1 else 0
        if np.isfinite(altitude[k]):
            h, gx, gy, gz = height_and_up(place[0], place[1], place[2], earth)
            up = (gx, gy, gz)
            off = altitude[k] - h
            cost += altitude_weight * off * off
            for axis in range(3):
                g[axis] += altitude_weight * up[axis] * off
                for other in range(3):
                    a[axis, other] += altitude_weight * up[axis] * up[other]
            count += 1
        for axis in range(3):
            for i in range(n):
                grad[axis * n + i] += f[i] * g[axis]
                for other in range(3):
                    for j in range(n):
                        info[axis * n + i, other * n + j] += f[i] * f[j] * a[axis, other]
    return cost, count
