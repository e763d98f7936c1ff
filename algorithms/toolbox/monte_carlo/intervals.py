"""95 % intervals of ratios of sums over independent trials.

R = sum n_i / sum d_i over N trials. By linearisation the deviation of R is the mean of (n_i - R d_i) / mean(d), so

    var R = N / (N - 1) * (sum n^2 - 2 R sum n d + R^2 sum d^2) / (sum d)^2,

with Student's quantile of N - 1 degrees of freedom. Instants of one trial may be correlated in any way: they stand in
the same n_i. A share gets Wilson's interval instead, with as many cases as independent ones would have given this
variance, because near 0 and 1 a symmetrical interval is wrong, and where no case (or every case) was a hit it is empty.
A quantile q is where the share below is p: its interval is the quantiles at the ends of the interval of that share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from algorithms.toolbox.monte_carlo.order import Ordered

Floats = NDArray[np.float64]
LEVEL = 0.95


@dataclass(frozen=True)
class Moments:
    """Sums over N trials of numerator, denominator and their products."""

    trials: int
    n: float
    d: float
    nn: float
    nd: float
    dd: float

    @property
    def ratio(self) -> float:
        """Sum of numerators over sum of denominators; NaN where there was nothing to count."""
        return self.n / self.d if self.d > 0 else float("nan")

    @property
    def variance(self) -> float:
        """Variance of the ratio; NaN from less than two trials."""
        if self.trials < 2 or not self.d > 0:
            return float("nan")
        spread = self.nn - 2 * self.ratio * self.nd + self.ratio**2 * self.dd
        return max(spread, 0.0) / self.d**2 * self.trials / (self.trials - 1)


@lru_cache(maxsize=64)
def student(trials: int) -> float:
    """Quantile that bounds 95 % on both sides, of a mean over so many trials."""
    return float(stats.t.ppf((1 + LEVEL) / 2, trials - 1)) if trials > 1 else float("nan")


def interval_of_spread(m: Moments, mean: float) -> tuple[float, float, float]:
    """Standard deviation from the mean of squares and the mean, with its ends.

    The half width is that of the mean of squares: right where the mean is small against the spread, a little too wide
    where it is not.
    """
    variance = max(m.ratio - mean * mean, 0.0) if m.d > 0 else float("nan")
    half = student(m.trials) * float(np.sqrt(m.variance))
    if not np.isfinite(variance):
        return float("nan"), float("nan"), float("nan")
    return float(np.sqrt(variance)), float(np.sqrt(max(variance - half, 0.0))), float(np.sqrt(variance + half))


def interval_of_ratio(m: Moments, *, root: bool = False, share: bool = False) -> tuple[float, float, float]:
    """Value, lower and upper end; the ends are NaN where there are fewer than two trials."""
    value = m.ratio
    if not np.isfinite(value):
        return float("nan"), float("nan"), float("nan")
    if share:
        low, high = _wilson(m)
        return value, low, high
    half = student(m.trials) * np.sqrt(m.variance)
    low, high = value - half, value + half
    if not root:
        return value, float(low), float(high)
    return float(np.sqrt(value)), float(np.sqrt(max(low, 0.0))) if np.isfinite(low) else low, float(np.sqrt(high))


def _wilson(m: Moments) -> tuple[float, float]:
    """Wilson's interval with the number of independent cases that the variance over trials stands for."""
    if m.trials < 2:
        return float("nan"), float("nan")
    p, z = m.ratio, student(m.trials)
    spread = p * (1 - p)
    cases = min(spread / m.variance, m.d) if m.variance > 0 and spread > 0 else float(m.trials)
    middle = (p + z * z / (2 * cases)) / (1 + z * z / cases)
    half = z / (1 + z * z / cases) * np.sqrt(max(spread, 0.0) / cases + z * z / (4 * cases * cases))
    # At 0 and 1 the ends meet the share itself, but for rounding.
    return min(max(0.0, float(middle - half)), p), max(min(1.0, float(middle + half)), p)


def quantiles_with_intervals(
    values: NDArray[np.float32], shares: Sequence[float]
) -> list[tuple[float, float, float, int]]:
    """Quantiles of values (K, N) of N trials: each with its interval and the number of values; NaN = none."""
    nan = float("nan")
    finite = np.isfinite(values)
    whole = bool(finite.all())
    ordered = Ordered(values.reshape(-1) if whole else values[finite])
    if ordered.size == 0:
        return [(nan, nan, nan, 0)] * len(shares)
    d = np.full(values.shape[1], float(values.shape[0])) if whole else _per_trial(finite)
    out = []
    for p in shares:
        q = ordered.quantile(p)
        low = high = nan
        if 0 < p < 1:
            below = _per_trial(values <= q)
            m = Moments(values.shape[1], *(float(v) for v in (below.sum(), d.sum(), below @ below, below @ d, d @ d)))
            if np.isfinite(m.variance):
                half = student(m.trials) * np.sqrt(m.variance)
                ends = np.clip([p - half, p + half], 0.0, 1.0)
                low, high = (float(ordered.at(min(int(end * ordered.size), ordered.size - 1))) for end in ends)
                low, high = min(low, q), max(high, q)
        out.append((q, low, high, ordered.size))
    return out


def _per_trial(hits: NDArray[np.bool_]) -> Floats:
    """How many of each column are true; bytes are added many times faster than anything wider, as far as they hold."""
    counts = np.zeros(hits.shape[1])
    for first in range(0, hits.shape[0], 255):
        counts += np.add.reduce(hits[first : first + 255].view(np.uint8), axis=0, dtype=np.uint8)
    return counts
