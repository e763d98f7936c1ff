"""Marks that a lane without a track keeps, none of which can start one by itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import LANES

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Gathered(NamedTuple):
    """Marks that a lane without a track keeps for a start from several of them; W marks at most, 0 = none is kept."""

    gate: Floats
    """(LANES, W)"""
    toa: Floats
    """(LANES, W, S) m, c times the times of arrival, NaN where not received"""
    altitude: Floats
    """(LANES, W) m, NaN where not decoded"""
    kept: Ints
    """How many marks there are."""
    due: Ints
    """Marks still to come before the next fit."""
    failures: Ints
    """Fits in vain since the pile was full."""
    heard: Ints
    """Most stations that any of its fits had."""
    why: Ints
    """Reason of the last failure."""
    error: Floats
    """m, claimed horizontal error of the last fit, NaN where there is none"""


def new_gathered(stations: int, marks: int) -> Gathered:
    """Empty piles of so many marks at most."""
    return Gathered(
        gate=np.zeros((LANES, marks)),
        toa=np.zeros((LANES, marks, stations)),
        altitude=np.zeros((LANES, marks)),
        kept=np.zeros(LANES, np.int64),
        due=np.zeros(LANES, np.int64),
        failures=np.zeros(LANES, np.int64),
        heard=np.zeros(LANES, np.int64),
        why=np.zeros(LANES, np.int64),
        error=np.full(LANES, np.nan),
    )
