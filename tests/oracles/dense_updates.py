"""Independent statements of the updates that are offered for comparison, in plain NumPy over all nine components.

Differences against the last reception with the full covariance, `solve`, points from a Cholesky root: written from the
literature, sharing nothing with the kernels but the Earth's altitude.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tests.oracles.dense_filter import C, sphere_altitude

Floats = NDArray[np.float64]
Measured = tuple[Floats, Floats, Callable[[Floats], Floats], Callable[[Floats], Floats]]


def measured(toa_s: Floats, altitude: float, stations: Floats, sigma_m: float, sigma_h: float) -> Measured:
    """What was measured, its covariance, the function of the state that expects it, and its Jacobian."""
    have = np.flatnonzero(np.isfinite(toa_s))
    known = int(np.isfinite(altitude))
    d = np.zeros((len(have) - 1, len(have)))
    d[:, :-1], d[:, -1] = -np.eye(len(have) - 1), 1.0

    def expect(x: Floats) -> Floats:
        p = x[[0, 3, 6]]
        return np.append(d @ np.linalg.norm(p - stations[have], axis=1), [sphere_altitude(p)[0]] * known)

    def jacobian(x: Floats) -> Floats:
        p = x[[0, 3, 6]]
        away = p - stations[have]
        rows = d @ (away / np.linalg.norm(away, axis=1)[:, None])
        out = np.zeros((len(rows) + known, 9))
        out[: len(rows), [0, 3, 6]] = rows
        if known:
            out[-1, [0, 3, 6]] = sphere_altitude(p)[1]
        return out

    z = np.append(d @ (C * toa_s[have]), [altitude] * known)
    v = np.zeros((len(z), len(z)))
    v[: len(d), : len(d)] = sigma_m**2 * d @ d.T
    if known:
        v[-1, -1] = sigma_h**2
    return z, v, expect, jacobian


def iterated(x: Floats, p: Floats, m: Measured, steps: int = 5) -> tuple[Floats, Floats]:
    z, v, expect, jacobian = m
    eta = x.copy()
    for _ in range(steps):
        a = jacobian(eta)
        gain = np.linalg.solve(a @ p @ a.T + v, a @ p).T
        eta = x + gain @ (z - expect(eta) - a @ (x - eta))
    k = np.eye(9) - gain @ a
    return eta, k @ p @ k.T + gain @ v @ gain.T


def over_points(x: Floats, p: Floats, m: Measured, *, unscented: bool) -> tuple[Floats, Floats]:
    z, v, expect, _ = m
    n = 9
    root = np.linalg.cholesky(p)
    scale = 0.25 * n if unscented else n
    points = np.concatenate([[x], x + np.sqrt(scale) * root.T, x - np.sqrt(scale) * root.T])
    w = np.full(2 * n + 1, 0.5 / scale)
    w[0] = 1 - n / scale if unscented else 0.0
    wc = w.copy()
    wc[0] += (1 - 0.25 + 2.0) if unscented else 0.0
    values = np.array([expect(point) for point in points])
    mean = w @ values
    dz, dx = values - mean, points - x
    s = (wc[:, None] * dz).T @ dz + v
    cross = (wc[:, None] * dx).T @ dz
    gain = np.linalg.solve(s, cross.T).T
    return x + gain @ (z - mean), p - gain @ s @ gain.T


def with_emission(
    x: Floats, p: Floats, toa_s: Floats, stations: Floats, sigma_m: float, prior_m: float
) -> tuple[Floats, Floats]:
    """Ten states, the last c times the emission time with a prior about what the prediction makes of the mark."""
    have = np.flatnonzero(np.isfinite(toa_s))
    away = x[[0, 3, 6]] - stations[have]
    r = np.linalg.norm(away, axis=1)
    big = np.zeros((10, 10))
    big[:9, :9], big[9, 9] = p, prior_m**2
    a = np.zeros((len(have), 10))
    a[:, [0, 3, 6]] = away / r[:, None]
    a[:, 9] = 1.0
    e = C * toa_s[have] - r
    e = e - e.mean()
    gain = np.linalg.solve(a @ big @ a.T + sigma_m**2 * np.eye(len(have)), a @ big).T
    k = np.eye(10) - gain @ a
    full = k @ big @ k.T + sigma_m**2 * gain @ gain.T
    return x + (gain @ e)[:9], full[:9, :9]
