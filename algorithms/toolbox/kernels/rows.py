"""The measurement update of a block of trials by one scalar row.

A row says z = h . p + noise of variance R, where p is the position part of the state (components 0, n_axis,
2 n_axis). Its update needs no inverse: with w = P h and S = h . w + R,

    x += w nu / S,   P -= w w^T / S,   NIS += nu^2 / S,   ln L -= (nu^2 / S + ln 2 pi S) / 2.

Rows must be mutually uncorrelated; they then may be applied one after another, in any order, and the sequence is
exactly the joint update when all rows are linearised at the same point: the innovation of a row subtracts h times
the movement that earlier rows made. P stays symmetric because only its lower triangle exists.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import LANES, kernel

LN_2PI = float(np.log(2.0 * np.pi))


@kernel
def update_row(x, p, start, h, nu, variance, active, n_axis, w, nis, log_likelihood):
    """Update a block by one scalar row, in place.

    Parameters
    ----------
    x : (n, LANES), p : (n (n + 1) / 2, LANES)
        State and packed covariance.
    start : (3, LANES)
        Position against which `nu` was computed.
    h : (3, LANES), nu, variance, active : (LANES,)
        The row; `active` is 1 where the lane has this row and 0 where it has not (gain zero, no branch).
    n_axis : int
        Components per axis (3 for position, velocity, acceleration; 1 for a bare position).
    w : (n, LANES)
        Workspace.
    nis, log_likelihood : (LANES,)
        Sums, added to.
    """
    n = x.shape[0]
    s = np.empty(LANES)
    e = np.empty(LANES)
    g = np.empty(LANES)
    for i in range(n):
        for lane in range(LANES):
            w[i, lane] = 0.0
        for a in range(3):
            j = a * n_axis
            k = i * (i + 1) // 2 + j if i >= j else j * (j + 1) // 2 + i
            for lane in range(LANES):
                w[i, lane] += p[k, lane] * h[a, lane]
    for lane in range(LANES):
        s[lane] = variance[lane]
        e[lane] = nu[lane]
    for a in range(3):
        j = a * n_axis
        for lane in range(LANES):
            s[lane] += h[a, lane] * w[j, lane]
            e[lane] -= h[a, lane] * (x[j, lane] - start[a, lane])
    for lane in range(LANES):
        # S <= 0 can only come from a covariance that is no longer one; the lane is left as it is and reported.
        ok = active[lane] > 0.0 and s[lane] > 0.0
        safe = s[lane] if ok else 1.0
        g[lane] = 1.0 / safe if ok else 0.0
        d = e[lane] * e[lane] * g[lane]
        nis[lane] += d
        log_likelihood[lane] -= 0.5 * (d + (LN_2PI + np.log(safe) if ok else 0.0))
    k = 0
    for i in range(n):
        for lane in range(LANES):
            x[i, lane] += w[i, lane] * e[lane] * g[lane]
        for j in range(i + 1):
            for lane in range(LANES):
                p[k, lane] -= w[i, lane] * w[j, lane] * g[lane]
            k += 1
