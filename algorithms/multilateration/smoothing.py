"""Smooth what the range-difference filter has reported, target by target and trial by trial.

What is smoothed is the filter's own chain of estimates: a restart, and a rival position that took over, begin a new
piece. A mark older than the one before it has no estimate and gets none. NIS, gates and statuses stay the filter's:
they were decided when the mark came.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.multilateration import lanes
from algorithms.multilateration.bank import Choice, straight_noise
from algorithms.multilateration.lanes import Report
from algorithms.multilateration.parameters import FilterParameters
from algorithms.recording import ToaMarks
from algorithms.toolbox.filters.smoothing import smooth
from algorithms.toolbox.kernels.symmetric import pack, unpack
from algorithms.toolbox.motion.jerk import PROCESS_NOISE, jerk_matrices

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# The covariances of all marks stand in memory twice, 0.65 kB each.
MOST_MARKS = 300_000


def check_size(recording: ToaMarks) -> None:
    """Refuse what would not fit, before anything is filtered.

    Raises
    ------
    ParameterError
        More marks than can be smoothed at once.
    """
    count = len(recording) * recording.toa_s.shape[2]
    if count > MOST_MARKS:
        raise ParameterError(
            f"{count} marks are too many to be smoothed at once; there may be {MOST_MARKS}",
            pointer="/smoothing",
            remedy="choose a target or a part of the recording, or leave the smoothing out",
            code="smoothing_too_long",
        )


def smooth_report(
    recording: ToaMarks, report: Report, parameters: FilterParameters, process_noise: str, models: Choice | None
) -> None:
    """Replace states and covariances of a report, which must hold whole covariances, by the smoothed ones.

    Where two models interact, what is smoothed is their merged estimate, with the process noise of each in the share
    that the model has after the later mark. The textbook's smoother of interacting models goes back through every pair
    of models, of which the straight one's covariance has next to no inverse; this one is tested by its errors.
    """
    form = PROCESS_NOISE.index(process_noise)
    for rows in recording.rows_by_target():
        if rows.size < 2:
            continue
        state = np.moveaxis(report.state[rows], 2, 1)
        covariance = np.moveaxis(unpack(report.covariance[rows], axis=1), 3, 1)
        there = np.isfinite(state[:, :, 0])
        time = np.where(there, report.time[rows], np.nan)
        track = report.track[rows]
        linked = _linked(track, report.status[rows], there)
        weight = report.probability[rows, 1] if models is not None else None

        def model(t: Floats, later: Ints, trials: Ints, weight: Floats | None = weight) -> tuple[Floats, Floats]:
            f, q = jerk_matrices(t, parameters.sigma_jerk_mps3, form)
            if models is None or weight is None:
                return f, q
            # Where no model carried the track yet, the single filter did, whose noise is the manoeuvre's.
            w = np.nan_to_num(weight[later, trials], nan=1.0)[:, None, None]
            return f, w * q + (1.0 - w) * straight_noise(t, models.sigma_acceleration)

        x, p = smooth(time, state, covariance, linked, model)
        report.state[rows] = np.moveaxis(x, 1, 2)
        report.covariance[rows] = np.moveaxis(pack(np.moveaxis(p, (2, 3), (0, 1))), 0, 1)


def _linked(track: NDArray[Any], status: NDArray[Any], there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(M, L) whether a mark's estimate was predicted from the last one before it."""
    number = np.where(there, track, 0)
    # The last number that was shown before each mark.
    last = np.zeros_like(number)
    for k in range(1, len(number)):
        last[k] = np.where(there[k - 1], number[k - 1], last[k - 1])
    begun = (status == lanes.INITIALISED) | (status == lanes.REINITIALISED)
    return np.asarray(there & (number == last) & (number > 0) & ~begun)
