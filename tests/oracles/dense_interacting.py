"""An independent statement of the interacting filter of marks in plain NumPy, from the specification (6.2, 6.5).

Mixing as the textbook writes it (barshalom2001, sec. 11.6.6: sums over models, no differences), joint updates against
the last reception with the full covariance, ten-component states.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tests.oracles.dense_filter import C, DenseFilter, Floats, f_matrix, q_matrix, sphere_altitude

POSITION = [0, 3, 6]
ACCELERATION = [2, 5, 8]


@dataclass
class DenseInteracting:
    stations: Floats
    sigma_toa_s: float
    sigma_altitude_m: float
    sigma_bias_m: float
    sigma_acceleration: float
    sigma_jerk: float
    bias_time_s: float = 3000.0
    stay_s: tuple[float, float] = (200.0, 50.0)
    x: list[Floats] = field(default_factory=list)
    p: list[Floats] = field(default_factory=list)
    weight: Floats = field(default_factory=lambda: np.array([0.5, 0.5]))

    def take_over(self, single: DenseFilter, altitude: float) -> None:
        """Both models begin with a filter whose altitudes had the noise sigma_altitude^2 + sigma_bias^2."""
        total = self.sigma_altitude_m**2 + self.sigma_bias_m**2
        x, p = np.zeros(10), np.zeros((10, 10))
        x[:9], p[:9, :9], p[9, 9] = single.x, single.p, self.sigma_bias_m**2
        if np.isfinite(altitude) and self.sigma_bias_m > 0:
            h, g = sphere_altitude(single.x[POSITION])
            gain = single.p[:, POSITION] @ g / total
            p[:9, 9] = p[9, :9] = -gain * self.sigma_bias_m**2
            # The bias given the position is what the altitude's residual says, with the noise of one altitude.
            share = self.sigma_bias_m**2 / total
            p[9, 9] = self.sigma_bias_m**2 * (1 - share) + share**2 * (g @ single.p[np.ix_(POSITION, POSITION)] @ g)
            x[9] = share * (altitude - h)
        self.x, self.p = [x, x.copy()], [p, p.copy()]

    def merged(self) -> tuple[Floats, Floats]:
        x = sum(w * m for w, m in zip(self.weight, self.x, strict=True))
        p = sum(w * (c + np.outer(m - x, m - x)) for w, m, c in zip(self.weight, self.x, self.p, strict=True))
        return np.asarray(x), np.asarray(p)

    def shown(self) -> tuple[Floats, Floats]:
        """The merged estimate with the bias's prior a mixture: information is added or taken away, then merged."""
        x, p = self.merged()
        if self.sigma_bias_m == 0:
            return x, p
        information = np.linalg.inv(p)
        found = []
        for weight, share in ((6 / 7, 0.5), (1 / 7, 4.0)):
            other = information.copy()
            other[9, 9] += (1 / share - 1) / self.sigma_bias_m**2
            p_j = np.linalg.inv(other)
            x_j = p_j @ information @ x
            cost = x @ information @ x - x_j @ other @ x_j
            scale = np.exp((np.linalg.slogdet(p_j)[1] - np.linalg.slogdet(p)[1] - cost) / 2) / np.sqrt(share)
            found.append((weight * scale, x_j, p_j))
        total = sum(w for w, _, _ in found)
        mean = sum(w / total * x_j for w, x_j, _ in found)
        spread = sum(w / total * (p_j + np.outer(x_j - mean, x_j - mean)) for w, x_j, p_j in found)
        return np.asarray(mean), np.asarray(spread)

    def predict(self, t: float) -> None:
        stay = np.exp(-t / np.array(self.stay_s))
        pi = np.array([[stay[0], 1 - stay[0]], [1 - stay[1], stay[1]]])
        joint = pi * self.weight[:, None]
        self.weight = joint.sum(axis=0)
        mu = joint / self.weight
        start = []
        for j in range(2):
            x = sum(mu[i, j] * self.x[i] for i in range(2))
            p = sum(mu[i, j] * (self.p[i] + np.outer(self.x[i] - x, self.x[i] - x)) for i in range(2))
            start.append((x, p))
        fade = np.exp(-t / self.bias_time_s)
        for j, (x, p) in enumerate(start):
            f, q = np.zeros((10, 10)), np.zeros((10, 10))
            f[:9, :9] = f_matrix(t)
            f[9, 9], q[9, 9] = fade, (1 - fade**2) * self.sigma_bias_m**2
            if j == 0:
                f[:, ACCELERATION] = 0.0
                g = np.kron(np.eye(3), np.array([[t * t / 2], [t], [0.0]]))
                q[:9, :9] = self.sigma_acceleration**2 * max(t, 1 / t) * g @ g.T + np.kron(
                    np.eye(3), np.diag([0, 0, 1e-6])
                )
            else:
                q[:9, :9] = q_matrix(t, self.sigma_jerk, "white")
            self.x[j], self.p[j] = f @ x, f @ p @ f.T + q

    def update(self, toa_s: Floats, altitude: float) -> None:
        score = np.zeros(2)
        for j in range(2):
            score[j] = self._update(j, toa_s, altitude)
        w = self.weight * np.exp(-(score - score.min()) / 2)
        self.weight = np.clip(w / w.sum(), 1e-6, 1 - 1e-6)

    def _update(self, j: int, toa_s: Floats, altitude: float) -> float:
        """Update one model; return minus twice the logarithm of its likelihood."""
        x, p = self.x[j], self.p[j]
        have = list(np.flatnonzero(np.isfinite(toa_s)))
        d = x[POSITION] - self.stations
        r = np.linalg.norm(d, axis=1)
        u = d / r[:, None]
        rows, nu = [], []
        ref = have.pop()
        for s in have:
            nu.append(C * (toa_s[s] - toa_s[ref]) - (r[s] - r[ref]))
            rows.append(np.append(u[s] - u[ref], 0.0))
        n = len(rows)
        v = (C * self.sigma_toa_s) ** 2 * (np.eye(n) + 1.0)
        if np.isfinite(altitude):
            h, grad = sphere_altitude(x[POSITION])
            nu.append(altitude - h - x[9])
            rows.append(np.append(grad, 1.0))
            v = np.block([[v, np.zeros((n, 1))], [np.zeros((1, n)), np.array([[self.sigma_altitude_m**2]])]])
        a = np.zeros((len(rows), 10))
        a[:, [*POSITION, 9]] = rows
        s_matrix = a @ p @ a.T + v
        gain = np.linalg.solve(s_matrix, a @ p).T
        e = np.array(nu)
        k = np.eye(10) - gain @ a
        self.x[j], self.p[j] = x + gain @ e, k @ p @ k.T + gain @ v @ gain.T
        return float(e @ np.linalg.solve(s_matrix, e) + np.linalg.slogdet(s_matrix)[1])
