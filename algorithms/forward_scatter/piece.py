"""One pass of some trials as a method gets it, and the arrays that it fills."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter.motion import UNKNOWNS
from algorithms.forward_scatter.outputs import LINE_OUTPUTS, NO_VALUES
from algorithms.recording import DopplerPairs

Floats = NDArray[np.float64]
Arrays = dict[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Piece:
    """One pass of some trials: its rows, instants and measurements, and where the answers go."""

    rows: NDArray[np.int64]
    """(K,) positions in the recording."""
    lanes: NDArray[np.int64]
    time: Floats
    doppler: Floats
    """(K, C, L)."""
    rate: Floats
    """(K, 2, L)."""
    azimuth: Floats
    """(K, L) rad from the base line, positive to its left."""
    elevation: Floats
    interval: float

    def put(self, arrays: Arrays, name: str, values: NDArray[np.generic]) -> None:
        """Put (K, ..., L) values of this pass into an array of the result."""
        whole = arrays[name]
        index = np.ix_(self.rows, *(np.arange(n) for n in whole.shape[1:-1]), self.lanes)
        whole[index] = values


Method = Callable[[Piece, Arrays], None]


def empty_arrays(recording: DopplerPairs, *, lines: bool) -> Arrays:
    """Room for every output, filled with nothing."""
    m, c, lanes = recording.doppler_hz.shape
    nan = np.nan
    arrays: Arrays = {
        "row": recording.row.copy(),
        "target": recording.target.copy(),
        "time_s": np.repeat(recording.time_s[:, None], lanes, axis=1),
        "state": np.full((m, 9, lanes), nan),
        "covariance": np.full((m, 3, 3, lanes), nan),
        "track": np.zeros((m, lanes), np.int64),
        "status": np.full((m, lanes), NO_VALUES, np.int64),
        "theta": np.full((m, UNKNOWNS, lanes), nan),
        "theta_covariance": np.full((m, UNKNOWNS, UNKNOWNS, lanes), nan),
        "distance_interval_m": np.full((m, 2, lanes), nan),
        "chi2": np.full((m, lanes), nan),
        "dof": np.zeros((m, lanes), np.int64),
        "used": np.zeros((m, c, lanes), np.bool_),
        "residual_hz": np.full((m, c, lanes), nan),
    }
    if lines:
        arrays |= {
            "line": np.full((m, 2, 6, lanes), nan),
            "crossing_s": np.full((m, 2, lanes), nan),
            "frozen": np.zeros((m, 2, lanes), np.bool_),
            "omega_rad_s": np.full((m, lanes), nan),
            "difference_hz": np.full((m, lanes), nan),
        }
        assert set(arrays) == {o.name for o in LINE_OUTPUTS}
    return arrays
