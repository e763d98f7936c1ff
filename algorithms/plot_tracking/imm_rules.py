"""What the recommended tracker is told, and what it remembers of a scan."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.gates import radius_of
from algorithms.plot_tracking.imm_filter import Motion

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# The density of false plots follows their number in a scan with this weight; never less than so many in the disc.
DENSITY_GAIN, LEAST_FALSE = 0.1, 0.1


@dataclass(frozen=True)
class Rules:
    """Everything about the tracker that can be chosen."""

    motion: Motion
    sigma_r: float
    sigma_th: float
    across_m: float
    max_speed_mps: float
    gate: float
    coasting_gate: float
    joint: bool
    detection: float
    largest_cluster: int
    confirm_plots: int
    drop_after: int

    @property
    def period_s(self) -> float:
        """Of the antenna, s."""
        return self.motion.period_s


@dataclass
class Identity:
    """What plots say of themselves, (P,)."""

    address: Ints
    callsign: Ints
    altitude_m: Floats


@dataclass
class Taken:
    """What became of the plots of one scan; arrays (P,)."""

    owner: Ints
    stage: Ints
    distance: Floats
    edge: Floats
    rivals: Ints
    probability: Floats
    shared: NDArray[np.bool_]
    pairs: list[tuple[int, Ints, Ints, Floats]] = field(default_factory=list)
    too_large: int = 0
    areas: list[tuple[int, Ints, Floats, Floats]] = field(default_factory=list)
    """of each stage: its number, tracks, centres (T, M, 2) and covariances (T, M, 2, 2) times the squared radius"""

    @classmethod
    def of(cls, plots: int) -> Taken:
        """Nothing has become of them yet."""
        zero, none = np.zeros(plots, np.int64), np.full(plots, np.nan)
        return cls(zero - 1, zero.copy(), none.copy(), none.copy(), zero.copy(), none.copy(), zero > 0)

    @property
    def free(self) -> Ints:
        """Plots that no track has taken."""
        return np.flatnonzero((self.owner < 0) & ~self.shared)


@dataclass
class Clutter:
    """How many false plots there are in a scan of each trial, and the area (L,) m2 that they lie in."""

    area_m2: Floats
    number: Floats

    @property
    def log_density(self) -> Floats:
        """Logarithm of their number for each m2, (L,)."""
        out: Floats = np.log(np.maximum(self.number, LEAST_FALSE) / self.area_m2)
        return out

    def learn(self, lane: Ints) -> None:
        """Take the trials of the plots that no confirmed track wanted."""
        now = np.bincount(lane, minlength=self.number.size)
        self.number += DENSITY_GAIN * (now - self.number)


@dataclass(frozen=True)
class Offer:
    """Pairs inside gates: tracks and plots (positions), distance, cost, and ln of the likelihood in 1/m2."""

    track: Ints
    plot: Ints
    d2: Floats
    cost: Floats
    log_likelihood: Floats

    def take(self, which: Ints) -> Offer:
        """Some of the pairs."""
        return Offer(**{name: values[which] for name, values in self.__dict__.items()})


def gate_radius(probability: float) -> float:
    """Radius of a gate that holds this share, in standard deviations."""
    return float(radius_of(np.array(probability)))
