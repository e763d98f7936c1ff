"""Which single reception, or the altitude, makes a mark impossible: the gate that leaves one out (specification 6.4).

Plain gating loses every track in its first turn; here a mark that fails for both models is tried without each of its
parts, and the best subset that passes its own gate is used.
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.frames.earth import height_and_up
from algorithms.toolbox.kernels import strict

# Receptions that must be left for a reception to be left out.
FEWEST = 3


@strict
def _nis_without(lane, m, skip, setup, choice, now, bank, rows, s):
    """NIS of a lane's mark for model m without station `skip` (-1: without the altitude, -2: with all).

    The unknown emission time is a parameter without prior: with A the covariance of the residuals r and e their ones,
    NIS = r' A^-1 r - (e' A^-1 r)^2 / (e' A^-1 e). `rows` (n, 6) holds h, bias, residual, one; `s` (n, n).
    """
    n = 0
    at = bank.at[m]
    start = bank.start[m]
    p = bank.p[m]
    for q in range(setup.stations.shape[0]):
        if now.used[q, lane] > 0.0 and q != skip:
            dx = at[0, lane] - setup.stations[q, 0]
            dy = at[1, lane] - setup.stations[q, 1]
            dz = at[2, lane] - setup.stations[q, 2]
            r = max(np.sqrt(dx * dx + dy * dy + dz * dz), 1e-3)
            rows[n, 0] = dx / r
            rows[n, 1] = dy / r
            rows[n, 2] = dz / r
            rows[n, 3] = 0.0
            rows[n, 4] = now.toa[q, lane] - r
            rows[n, 5] = 1.0
            s[n, n] = setup.variance[q]
            n += 1
    received = n
    if now.has_altitude[lane] > 0.0 and skip != -1:
        h, gx, gy, gz = height_and_up(at[0, lane], at[1, lane], at[2, lane], setup.earth)
        rows[n, 0] = gx
        rows[n, 1] = gy
        rows[n, 2] = gz
        rows[n, 3] = now.altitude_biased[lane] if choice.bias_variance > 0.0 else 0.0
        rows[n, 4] = now.altitude[lane] - h - rows[n, 3] * start[3, lane]
        rows[n, 5] = 0.0
        s[n, n] = choice.altitude_variance + now.altitude_extra[lane]
        n += 1
    dof = n - 1 if received > 0 else n
    if dof <= 0:
        return np.inf, 0
    # Residuals at the prediction, whose rows are taken at the point of linearisation.
    for i in range(n):
        for a in range(3):
            rows[i, 4] -= rows[i, a] * (start[a, lane] - at[a, lane])
    place = (0, 3, 6, 9)
    for i in range(n):
        for j in range(i + 1):
            total = s[i, i] if i == j else 0.0
            for a in range(4):
                for b in range(4):
                    high = max(place[a], place[b])
                    low = min(place[a], place[b])
                    total += rows[i, a] * rows[j, b] * p[high * (high + 1) // 2 + low, lane]
            s[i, j] = total
    # Cholesky in place, then both right-hand sides forward.
    for i in range(n):
        for j in range(i + 1):
            total = s[i, j]
            for k in range(j):
                total -= s[i, k] * s[j, k]
            if i == j:
                if not total > 0.0:
                    return np.inf, dof
                s[i, i] = np.sqrt(total)
            else:
                s[i, j] = total / s[j, j]
    rr = 0.0
    re = 0.0
    ee = 0.0
    for i in range(n):
        u = rows[i, 4]
        v = rows[i, 5]
        for k in range(i):
            u -= s[i, k] * rows[k, 4]
            v -= s[i, k] * rows[k, 5]
        rows[i, 4] = u / s[i, i]
        rows[i, 5] = v / s[i, i]
        rr += rows[i, 4] * rows[i, 4]
        re += rows[i, 4] * rows[i, 5]
        ee += rows[i, 5] * rows[i, 5]
    return rr - (re * re / ee if ee > 0.0 else 0.0), dof


@strict
def leave_one_out(lane, setup, choice, now, bank):
    """Take out of a lane's mark the part without which it passes best; False where no part alone is to blame."""
    n = setup.stations.shape[0]
    rows = np.empty((n + 1, 6))
    s = np.zeros((n + 1, n + 1))
    best = np.inf
    found = -2
    first = -1 if now.has_altitude[lane] > 0.0 and now.receptions[lane] >= 2 else 0
    stop = n if now.receptions[lane] >= FEWEST else 0
    for skip in range(first, stop):
        if skip >= 0 and now.used[skip, lane] == 0.0:
            continue
        for m in range(2):
            nis, dof = _nis_without(lane, m, skip, setup, choice, now, bank, rows, s)
            if nis < best and dof > 0 and nis <= choice.limits[dof]:
                best = nis
                found = skip
    if found == -2:
        return False
    if found == -1:
        now.has_altitude[lane] = 0.0
        bank.left[lane] = -1
    else:
        now.used[found, lane] = 0.0
        now.receptions[lane] -= 1
        bank.left[lane] = found + 1
    return True
