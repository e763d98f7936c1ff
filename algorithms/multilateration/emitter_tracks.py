"""Rough tracks that tell emitters apart: position and velocity of each, held against every mark that comes.

Straight flight disturbed by white acceleration, one extended update a mark. They decide which mark is whose; what is
shown comes from the filter that then runs over each emitter's marks.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.conditions import Conditions
from algorithms.toolbox.frames.earth import altitude_from_position, up_from_position
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Of the white acceleration that disturbs the flight, m/s2 over a second: a turn of 2 deg/s at 140 m/s.
ACCELERATION = 5.0
# Where the components of a rough track stand in a state of nine.
IN_STATE = [0, 3, 6, 1, 4, 7]


@dataclass
class RoughTracks:
    """Live tracks, T of them: x (T, 6) m and m/s, p (T, 6, 6), their instants, numbers and marks so far."""

    x: Floats = field(default_factory=lambda: np.empty((0, 6)))
    p: Floats = field(default_factory=lambda: np.empty((0, 6, 6)))
    time_s: Floats = field(default_factory=lambda: np.empty(0))
    last_s: Floats = field(default_factory=lambda: np.empty(0))
    number: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    marks: Ints = field(default_factory=lambda: np.empty(0, np.int64))

    def keep(self, kept: NDArray[np.bool_]) -> None:
        """Let go of the others."""
        for name in ("x", "p", "time_s", "last_s", "number", "marks"):
            setattr(self, name, getattr(self, name)[kept])

    def add(self, state: Floats, covariance: Floats, time_s: float, number: int, marks: int) -> None:
        """Begin a track with a state of nine and its covariance."""
        self.x = np.concatenate([self.x, state[IN_STATE][None]])
        self.p = np.concatenate([self.p, covariance[np.ix_(IN_STATE, IN_STATE)][None]])
        self.time_s, self.last_s = np.append(self.time_s, time_s), np.append(self.last_s, time_s)
        self.number, self.marks = np.append(self.number, number), np.append(self.marks, marks)

    def predict(self, time_s: float) -> None:
        """Carry all tracks to an instant."""
        t = np.maximum(time_s - self.time_s, 0.0)
        f = np.tile(np.eye(6), (t.size, 1, 1))
        for a in range(3):
            f[:, a, a + 3] = t
        self.x = np.einsum("tij,tj->ti", f, self.x)
        self.p = f @ self.p @ f.transpose(0, 2, 1)
        q = ACCELERATION**2
        for a in range(3):
            self.p[:, a, a] += q * t**3 / 3
            self.p[:, a, a + 3] += q * t**2 / 2
            self.p[:, a + 3, a] += q * t**2 / 2
            self.p[:, a + 3, a + 3] += q * t
        self.time_s = np.maximum(self.time_s, time_s)

    def rows(self, toa_s: Floats, altitude_m: float, conditions: Conditions) -> tuple[Floats, Floats, Floats]:
        """Innovations (T, R) of a mark, Jacobians by the position (T, R, 3), noise (R, R): differences and altitude."""
        have = np.flatnonzero(np.isfinite(toa_s))
        n, known = max(have.size - 1, 0), int(np.isfinite(altitude_m))
        away = self.x[:, None, :3] - conditions.stations[have]
        r = np.maximum(np.linalg.norm(away, axis=2), 1.0)
        e = SPEED_OF_LIGHT_MPS * toa_s[have] - r
        u = away / r[:, :, None]
        nu, h = np.empty((len(self.x), n + known)), np.empty((len(self.x), n + known, 3))
        noise = np.zeros((n + known, n + known))
        nu[:, :n] = e[:, :n] - e[:, n:]
        h[:, :n] = u[:, :n] - u[:, n:]
        variance = conditions.variance[have]
        noise[:n, :n] = np.diag(variance[:n]) + (variance[n] if n else 0.0)
        if known:
            nu[:, n] = altitude_m - altitude_from_position(self.x[:, :3], conditions.earth)
            h[:, n] = up_from_position(self.x[:, :3], conditions.earth)
            noise[n, n] = conditions.sigma_altitude_m**2
        return nu, h, noise

    def compare(self, toa_s: Floats, altitude_m: float, conditions: Conditions) -> tuple[Floats, Floats, int]:
        """NIS of a mark for every track (T,), ln det of the innovation's covariance (T,), degrees of freedom."""
        nu, h, noise = self.rows(toa_s, altitude_m, conditions)
        if not nu.shape[1]:
            return np.full(len(self.x), np.inf), np.zeros(len(self.x)), 0
        s = h @ self.p[:, :3, :3] @ h.transpose(0, 2, 1) + noise
        nis = np.einsum("ti,ti->t", nu, np.linalg.solve(s, nu[:, :, None])[:, :, 0])
        return nis, np.linalg.slogdet(s)[1], nu.shape[1]

    def update(self, track: int, time_s: float, toa_s: Floats, altitude_m: float, conditions: Conditions) -> None:
        """Take a mark into a track (its place in the arrays)."""
        all_nu, all_h, noise = self.rows(toa_s, altitude_m, conditions)
        nu, h, p = all_nu[track], all_h[track], self.p[track]
        a = np.concatenate([h, np.zeros_like(h)], axis=1)
        s = a @ p @ a.T + noise
        gain = np.linalg.solve(s, a @ p).T
        k = np.eye(6) - gain @ a
        self.x[track] += gain @ nu
        p = k @ p @ k.T + gain @ noise @ gain.T
        self.p[track] = (p + p.T) / 2
        self.last_s[track] = time_s
        self.marks[track] += 1

    def apart(self, one: int, other: int) -> float:
        """Squared normalised distance of two tracks in place and velocity."""
        d = self.x[one] - self.x[other]
        return float(d @ np.linalg.solve(self.p[one] + self.p[other], d))
