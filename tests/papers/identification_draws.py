"""Two radars and two targets as the specification's tables have them, drawn and compared with the toolbox alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from algorithms.toolbox.association.assignment import pair_costs
from algorithms.toolbox.association.gate import gate_threshold, squared_distances
from algorithms.toolbox.association.only_partner import only_partners
from algorithms.toolbox.association.polar_fusion import fuse_polar
from algorithms.toolbox.frames.polar_conversion import ConversionName, cartesian_from_polar

TRIALS = 30_000
THRESHOLD = gate_threshold(0.01, 2)


@dataclass(frozen=True)
class Drawn:
    """Plots of two radars of two targets: (radar, target, trial)."""

    sites: np.ndarray
    targets: np.ndarray
    range_m: np.ndarray
    angle: np.ndarray
    sigma: np.ndarray

    def statistics(self, method: str) -> tuple[np.ndarray, np.ndarray]:
        """Squared distances and costs, (first's plot, second's plot, trial)."""
        if method == "polar":
            first, second = np.repeat([0, 1], 2), np.tile([0, 1], 2)
            trials = self.range_m.shape[2]
            r = np.stack([self.range_m[0, first].ravel(), self.range_m[1, second].ravel()])
            b = np.stack([self.angle[0, first].ravel(), self.angle[1, second].ravel()])
            found = fuse_polar(self.sites, r, b, np.full(2, 100.0), self.sigma)
            assert found.converged.all()
            return found.statistic.reshape(2, 2, trials), found.cost.reshape(2, 2, trials)
        z, p = self.converted(method)
        statistic, log_determinant = squared_distances(z[0][:, None] - z[1][None], p[0][:, None] + p[1][None])
        return statistic, pair_costs(statistic, log_determinant)

    def converted(self, method: str) -> tuple[np.ndarray, np.ndarray]:
        """Points and covariances in the common plane, (radar, target, trial, ...)."""
        name: ConversionName = method  # type: ignore[assignment]
        z, p = cartesian_from_polar(self.range_m, self.angle, 100.0, self.sigma[:, None, None], name)
        return z + self.sites[:, None, None], p


@lru_cache(maxsize=4)
def drawn(
    along: float = 1060.0,
    across: float = 0.0,
    sigma_deg: tuple[float, float] = (1.0, 1.0),
    base: float = 30_000.0,
    trials: int = TRIALS,
    base_angle_deg: float = 0.0,
) -> Drawn:
    """Plots with the same draws whatever the geometry."""
    rng = np.random.default_rng(2008)
    sight = np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])
    left = np.array([-sight[1], sight[0]])
    targets = 150_000 * sight + np.array([[0.0, 0.0], along * sight + across * left])
    turn = np.radians(base_angle_deg)
    sites = np.array([[0.0, 0.0], [base * np.cos(turn), base * np.sin(turn)]])
    offset = targets[None] - sites[:, None]
    sigma = np.radians(sigma_deg)
    noise = rng.standard_normal((2, 2, 2, trials))
    r = np.hypot(offset[..., 0], offset[..., 1])[..., None] + 100.0 * noise[0]
    b = np.arctan2(offset[..., 1], offset[..., 0])[..., None] + sigma[:, None, None] * noise[1]
    return Drawn(sites, targets, r, b, sigma)


def shares(statistic: np.ndarray, target: int = 0, reading: str = "A") -> tuple[float, float, float]:
    """Shares of correct, wrong and undecided marks of a target."""
    seen = statistic if reading == "A" else np.swapaxes(statistic, 0, 1)
    partner = only_partners(seen, THRESHOLD)[target]
    correct, wrong = float((partner == target).mean()), float((partner == 1 - target).mean())
    return correct, wrong, 1 - correct - wrong


def paired(cost: np.ndarray) -> float:
    """Share of trials in which the right pairing is the likelier one; ties count as one half."""
    straight, crossed = cost[0, 0] + cost[1, 1], cost[0, 1] + cost[1, 0]
    return float((straight < crossed).mean() + (straight == crossed).mean() / 2)


def band(share: float, reference_trials: int, trials: int = TRIALS, digits: int = 3) -> float:
    """Four standard errors of the difference of two independent simulations, and the rounding of the printed value."""
    return float(
        4 * np.sqrt(max(share * (1 - share), 1e-3) * (1 / trials + 1 / reference_trials)) + 0.51 * 10.0**-digits
    )
