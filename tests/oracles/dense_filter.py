"""An independent statement of the range-difference filter in plain NumPy: joint update, Joseph form.

Differences against the last reception with the full covariance, dense matrices, `solve`: written from the
specification (3, 4), sharing nothing with the kernels but the Earth's altitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

C = 299_792_458.0
Floats = NDArray[np.float64]


def f_matrix(t: float) -> Floats:
    f1 = np.array([[1, t, t * t / 2], [0, 1, t], [0, 0, 1]])
    out = np.zeros((9, 9))
    for a in range(3):
        out[3 * a : 3 * a + 3, 3 * a : 3 * a + 3] = f1
    return out


def q_matrix(t: float, sigma: float, form: str) -> Floats:
    if form == "white":
        q1 = sigma**2 * np.array(
            [[t**5 / 20, t**4 / 8, t**3 / 6], [t**4 / 8, t**3 / 3, t**2 / 2], [t**3 / 6, t**2 / 2, t]]
        )
    else:
        g = np.array([0, 0, t]) if form == "paper" else np.array([t**3 / 6, t**2 / 2, t])
        q1 = sigma**2 * np.outer(g, g)
    out = np.zeros((9, 9))
    for a in range(3):
        out[3 * a : 3 * a + 3, 3 * a : 3 * a + 3] = q1
    return out


def sphere_altitude(p: Floats, radius: float = 6_371_000.0) -> tuple[float, Floats]:
    d = np.sqrt((radius + p[2]) ** 2 + p[0] ** 2 + p[1] ** 2)
    h = (p @ p + 2 * radius * p[2]) / (d + radius)
    return float(h), np.array([p[0], p[1], radius + p[2]]) / d


@dataclass
class Step:
    nis: float
    dof: int
    log_likelihood: float


@dataclass
class DenseFilter:
    stations: Floats
    sigma_toa_s: float
    sigma_altitude_m: float
    sigma_jerk: float
    form: str
    x: Floats
    p: Floats
    reference: int = -1
    """Which of the receptions present is the reference (-1 = the last)."""

    def predict(self, t: float) -> None:
        f = f_matrix(t)
        self.x = f @ self.x
        self.p = f @ self.p @ f.T + q_matrix(t, self.sigma_jerk, self.form)

    def update(self, toa_s: Floats, altitude: float) -> Step:
        have = list(np.flatnonzero(np.isfinite(toa_s)))
        position = self.x[[0, 3, 6]]
        nu: list[float] = []
        rows: list[Floats] = []
        n = max(len(have) - 1, 0)
        if n:
            ref = have.pop(self.reference)
            d = position - self.stations
            r = np.linalg.norm(d, axis=1)
            u = d / r[:, None]
            for s in have:
                nu.append(C * (toa_s[ref] - toa_s[s]) - (r[ref] - r[s]))
                rows.append(u[ref] - u[s])
        v = np.zeros((n, n))
        if n:
            v = (C * self.sigma_toa_s) ** 2 * (np.eye(n) + np.ones((n, n)))
        if np.isfinite(altitude):
            h, grad = sphere_altitude(position)
            nu.append(altitude - h)
            rows.append(grad)
            v = np.block([[v, np.zeros((n, 1))], [np.zeros((1, n)), np.array([[self.sigma_altitude_m**2]])]])
        if not rows:
            return Step(0.0, 0, 0.0)
        a = np.zeros((len(rows), 9))
        a[:, [0, 3, 6]] = rows
        s_matrix = a @ self.p @ a.T + v
        gain = np.linalg.solve(s_matrix, a @ self.p).T
        e = np.array(nu)
        self.x = self.x + gain @ e
        k = np.eye(9) - gain @ a
        self.p = k @ self.p @ k.T + gain @ v @ gain.T
        self.p = (self.p + self.p.T) / 2
        nis = float(e @ np.linalg.solve(s_matrix, e))
        _, logdet = np.linalg.slogdet(2 * np.pi * s_matrix)
        return Step(nis, len(rows), -0.5 * (nis + float(logdet)))
