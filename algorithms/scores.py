"""What one algorithm made of a batch of simulated trials, in a form that batches can be added up in.

Every metric of a Monte Carlo run is a ratio of two sums over trials, sometimes under a root: a root mean square is
sqrt(sum of squares / count), a share is hits / cases, NIS is the sum of NIS over the sum of its degrees of freedom. A
`Tally` holds numerator and denominator of each instant and trial; quantiles need the values themselves: a `Sample`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Tally:
    """A metric as a ratio of sums.

    Attributes
    ----------
    metric, unit : name as in the table `metrics`, and its unit
    numerator, denominator : (T, L), one value for each instant and trial, or (L,), one for each trial
        Where there is nothing to count, both are 0.
    root : the metric is the square root of the ratio
    curve : it is wanted at each instant too (over the trials)
    compared : algorithms are compared by it, on the same draws
    chi_square : the numerator is chi-square distributed with as many degrees of freedom as the denominator says,
        where the algorithm is honest
    share : the ratio is a share of cases, between 0 and 1
    spread : the square of the ratio of the tally before it, a mean, is taken off before the root: a standard deviation
    """

    metric: str
    unit: str
    numerator: Floats
    denominator: Floats
    root: bool = False
    curve: bool = False
    compared: bool = False
    chi_square: bool = False
    share: bool = False
    spread: bool = False

    @property
    def per_trial(self) -> bool:
        """Whether there is one value for each trial, not for each instant."""
        return self.numerator.ndim == 1


SampleKind = Literal["size", "signed", "drawn"]


@dataclass(frozen=True)
class Sample:
    """Values whose median and other quantiles are wanted.

    Attributes
    ----------
    name, unit : `horizontal_m` gives `median_horizontal_m`, `p90_horizontal_m`, ...
    values : (T, L) or (L,); NaN = none
    curve : median and 90 % point are wanted at each instant too
    kind : `size` of an error, from 0 up: its large values count; `signed`: the middle 68 % count (16 % point, median,
        84 % point); `drawn`: no quantile is wanted, the first few trials are drawn one by one
    """

    name: str
    unit: str
    values: NDArray[np.float32]
    curve: bool = False
    kind: SampleKind = "size"


@dataclass(frozen=True)
class Scores:
    """Tallies and samples of a batch of L trials over T instants.

    Attributes
    ----------
    time_s : (T,) s, in time order; empty where the algorithm gives one answer for each trial only
    target : (T,) index into `targets`
    targets : names of the targets, ("",) for one
    """

    tallies: tuple[Tally, ...]
    samples: tuple[Sample, ...] = ()
    time_s: Floats = field(default_factory=lambda: np.empty(0))
    target: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    targets: tuple[str, ...] = ("",)
