"""Estimates of simulated marks against their truth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import ToaMarks
from algorithms.scores import Scores
from algorithms.toolbox.metrics.position_scores import score_positions


def score_marks(
    recording: ToaMarks,
    state: NDArray[np.float64],
    covariance: NDArray[np.float64],
    nis: NDArray[np.float64],
    dof: NDArray[Any],
) -> Scores:
    """Score states (M, n, L) with packed covariances of their positions (M, 6, L), NIS and its dof (M, L)."""
    return score_positions(
        time_s=recording.time_s,
        target=recording.target,
        targets=recording.targets,
        truth_m=recording.truth_m,
        truth_velocity_mps=recording.truth_velocity_mps,
        state=state,
        covariance=covariance,
        nis=nis,
        dof=dof,
    )
