"""Bins of time: as wide as the article's 50 s wherever that gives a readable number of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend.charts.columns import Floats, Ints

USUAL_S = 50.0
FEWEST, MOST = 12, 240


@dataclass(frozen=True)
class TimeBins:
    """Bins of equal width; `edges` are multiples of it."""

    width_s: float
    edges: Floats

    @property
    def centres(self) -> Floats:
        """(bin,) middle of each bin, s."""
        return (self.edges[:-1] + self.edges[1:]) / 2

    def index(self, time_s: Floats) -> Ints:
        """Bin of each instant."""
        at = np.searchsorted(self.edges, time_s, side="right") - 1
        return at.clip(0, self.edges.size - 2)

    def sums(self, time_s: Floats, values: NDArray[Any]) -> tuple[Floats, Floats]:
        """(bin,) number of values and their sum."""
        at, size = self.index(time_s), self.edges.size - 1
        count = np.bincount(at, minlength=size)
        return count.astype(np.float64), np.bincount(at, values, minlength=size).astype(np.float64)


def time_bins(time_s: Floats) -> TimeBins:
    """Choose bins for these instants: 50 s, else the width of 1, 2 or 5 times a power of ten that fits."""
    finite = time_s[np.isfinite(time_s)]
    first, last = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    span = last - first
    width = USUAL_S
    if not FEWEST <= span / width <= MOST and span > 0:
        least = span / (MOST if span / width > MOST else 4 * FEWEST)
        decade = 10.0 ** np.floor(np.log10(least))
        width = next(float(step * decade) for step in (1, 2, 5, 10) if step * decade >= least * (1 - 1e-9))
    start = np.floor(first / width)
    count = max(int(np.floor(last / width) - start) + 1, 1)
    return TimeBins(width, (start + np.arange(count + 1)) * width)
