"""Score position estimates of a block of trials: errors, claims and how well both agree, at each instant and trial.

An instant without an estimate after the trial's first one is lost. NEES is e' P^-1 e of the position, three degrees of
freedom, by the Cholesky factor written out; a covariance that is not positive definite has none.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.scores import Floats, Ints, Sample, Scores, Tally
from algorithms.toolbox.kernels import kernel

OVER_M = 5_000.0

# Rows of the kernel's output.
_HORIZONTAL, _EAST, _NORTH, _UP, _KNOWN, _CLAIM, _CLAIMED, _NEES, _NEES_DOF, _VELOCITY, _MOVING = range(11)


def score_positions(
    *,
    time_s: Floats,
    target: Ints,
    targets: tuple[str, ...],
    truth_m: Floats,
    truth_velocity_mps: Floats,
    state: Floats,
    covariance: Floats,
    nis: Floats,
    dof: NDArray[np.integer[Any]],
) -> Scores:
    """Score the estimates of a nine-component state.

    Parameters
    ----------
    time_s, target : (M,); truth_m, truth_velocity_mps : (M, 3), NaN where unknown
    state : (M, 9, L) x vx ax y vy ay z vz az; NaN where there is no estimate
    covariance : (M, 6, L) m^2, packed lower triangle of the position's covariance
    nis, dof : (M, L); NIS is NaN where it must not count
    """
    values = np.empty((11, *nis.shape))
    # One layout, so that the kernel is compiled once.
    _score(*(np.ascontiguousarray(a) for a in (state, covariance, truth_m, truth_velocity_mps)), values)
    known, claimed = values[_KNOWN], values[_CLAIMED]
    answered = np.isfinite(state[:, 0])
    lost, after = _lost(answered, target, len(targets))
    tested = np.isfinite(nis) & (dof > 0)
    horizontal = values[_HORIZONTAL]
    both = np.where(claimed > 0, horizontal, 0.0)
    far = (horizontal > OVER_M**2).any(axis=0).astype(float)
    one = np.ones(far.shape)
    tallies = (
        Tally("rms_horizontal_m", "m", horizontal, known, root=True, curve=True, compared=True),
        Tally("rms_position_m", "m", horizontal + values[_UP], known, root=True, compared=True),
        Tally("rms_east_m", "m", values[_EAST], known, root=True),
        Tally("rms_north_m", "m", values[_NORTH], known, root=True),
        Tally("rms_up_m", "m", values[_UP], known, root=True, curve=True, compared=True),
        Tally("rms_velocity_mps", "m/s", values[_VELOCITY], values[_MOVING], root=True, compared=True),
        Tally("claimed_horizontal_m", "m", values[_CLAIM], claimed, root=True, curve=True),
        Tally("actual_over_claimed", "1", both, np.where(known > 0, values[_CLAIM], 0.0), root=True),
        Tally("nees", "1", values[_NEES], values[_NEES_DOF], curve=True, chi_square=True),
        Tally(
            "nis", "1", np.where(tested, nis, 0.0), np.where(tested, dof, 0).astype(float), curve=True, chi_square=True
        ),
        Tally("answered_share", "1", answered.astype(float), np.ones(answered.shape), share=True),
        Tally("lost_share", "1", lost, after, curve=True, share=True),
        Tally("lost_tracks", "1", (lost.any(axis=0) | ~answered.any(axis=0)).astype(float), one, share=True),
        Tally("over_5km_share", "1", far, one, share=True),
    )
    errors = np.sqrt(np.where(known > 0, horizontal, np.nan)).astype(np.float32)
    return Scores(tallies, (Sample("horizontal_m", "m", errors, curve=True),), time_s, target, targets)


def _lost(answered: NDArray[np.bool_], target: Ints, targets: int) -> tuple[Floats, Floats]:
    """(M, L): 1 where an estimate is missing after the first one of the target, and 1 from the first one on."""
    after = np.zeros(answered.shape)
    for index in range(targets):
        rows = slice(None) if targets == 1 else np.flatnonzero(target == index)
        after[rows] = np.logical_or.accumulate(answered[rows], axis=0)
    return np.where(answered, 0.0, after), after


@kernel
def _score(state, covariance, truth, truth_velocity, out):
    """Fill the rows of `out` (11, M, L); see the names above."""
    marks, _, lanes = state.shape
    for k in range(marks):
        for lane in range(lanes):
            x = state[k, 0, lane] - truth[k, 0]
            y = state[k, 3, lane] - truth[k, 1]
            z = state[k, 6, lane] - truth[k, 2]
            h = x * x + y * y
            known = 1.0 if np.isfinite(h + z * z) else 0.0
            out[0, k, lane] = h if known > 0.0 else 0.0
            out[1, k, lane] = x * x if known > 0.0 else 0.0
            out[2, k, lane] = y * y if known > 0.0 else 0.0
            out[3, k, lane] = z * z if known > 0.0 else 0.0
            out[4, k, lane] = known
            xx = covariance[k, 0, lane]
            xy = covariance[k, 1, lane]
            yy = covariance[k, 2, lane]
            xz = covariance[k, 3, lane]
            yz = covariance[k, 4, lane]
            zz = covariance[k, 5, lane]
            claim = xx + yy
            claimed = 1.0 if np.isfinite(claim) else 0.0
            out[5, k, lane] = claim if claimed > 0.0 else 0.0
            out[6, k, lane] = claimed
            # P = L L', L w = e, NEES = w' w.
            d1 = xx
            l21 = xy / d1
            l31 = xz / d1
            d2 = yy - l21 * xy
            t32 = yz - l31 * xy
            l32 = t32 / d2
            d3 = zz - l31 * xz - l32 * t32
            w2 = y - l21 * x
            w3 = z - l31 * x - l32 * w2
            nees = x * x / d1 + w2 * w2 / d2 + w3 * w3 / d3
            sound = 3.0 if np.isfinite(nees) and d1 > 0.0 and d2 > 0.0 and d3 > 0.0 else 0.0
            out[7, k, lane] = nees if sound > 0.0 else 0.0
            out[8, k, lane] = sound
            u = state[k, 1, lane] - truth_velocity[k, 0]
            v = state[k, 4, lane] - truth_velocity[k, 1]
            w = state[k, 7, lane] - truth_velocity[k, 2]
            speed = u * u + v * v + w * w
            moving = 1.0 if np.isfinite(speed) else 0.0
            out[9, k, lane] = speed if moving > 0.0 else 0.0
            out[10, k, lane] = moving
