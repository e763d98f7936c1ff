"""Fixed-interval smoothing of a Kalman filter that has already run: Rauch, Tung and Striebel's backward pass.

From what the filter kept, x_k, P_k after mark k, and the model between marks, x' = F x_k, P' = F P_k F^T + Q:

    G   = P_k F^T P'^-1,
    x^s = x_k + G (x^s_{k+1} - x'),        P^s = P_k + G (P^s_{k+1} - P') G^T.

Trials stand side by side, as in the filter, and the pass goes back mark by mark with one batch of small matrices a
mark. P' is scaled to a unit diagonal before it is solved with: variances of position and acceleration differ by
fourteen orders of magnitude, and a plain elimination would lose the small ones.

Differences from the textbook: a filter may lose its track and start anew, and an estimate may be no update of the one
before (a rival hypothesis took over). An update moves an estimate by K nu, whose covariance P' - P is below P'; what
moved by more than eight sigma of P' was none. There a piece ends; each piece is smoothed by itself, its last estimate
is the filter's.

References
----------
barshalom2001, sec. 8.6.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

JUMP_SIGMA = 8.0

# Of the elapsed times (L,), and of the later estimates' places, marks (L,) and trials (L,): F and Q (L, n, n).
Model = Callable[[Floats, Ints, Ints], tuple[Floats, Floats]]


def smooth(time_s: Floats, state: Floats, covariance: Floats, linked: Bools, model: Model) -> tuple[Floats, Floats]:
    """Smooth every trial of a sequence of estimates.

    Parameters
    ----------
    time_s : (M, L) instants of the estimates, s; NaN where there is none.
    state : (M, L, n) after each mark.
    covariance : (M, L, n, n)
    linked : (M, L) whether the estimate of a mark was predicted from the last one before it that exists.
    model : F and Q over given intervals, up to given estimates.

    Returns
    -------
    (M, L, n), (M, L, n, n)
        Smoothed; NaN stays where it was.
    """
    marks, trials, n = state.shape
    x_out, p_out = state.copy(), covariance.copy()
    # The smoothed estimate that comes next, its time, and whether it was predicted from what comes before it.
    x_next, p_next = np.zeros((trials, n)), np.zeros((trials, n, n))
    # As the filter left it.
    x_after = np.zeros((trials, n))
    t_next = np.full(trials, np.nan)
    is_next_linked = np.zeros(trials, bool)
    following = np.zeros(trials, np.int64)
    for k in range(marks - 1, -1, -1):
        there = np.isfinite(time_s[k])
        lanes = np.flatnonzero(there & is_next_linked & np.isfinite(t_next))
        if lanes.size:
            x, p = state[k, lanes], covariance[k, lanes]
            f, q = model(t_next[lanes] - time_s[k, lanes], following[lanes], lanes)
            x_predicted = np.einsum("lij,lj->li", f, x)
            fp = f @ p
            predicted = fp @ np.swapaxes(f, -1, -2) + q
            moved = (x_after[lanes] - x_predicted) ** 2
            chained = (moved <= JUMP_SIGMA**2 * np.einsum("lii->li", predicted)).all(axis=1)
            gain = np.swapaxes(solve_scaled(predicted, fp), -1, -2) * chained[:, None, None]
            x_out[k, lanes] = x + np.einsum("lij,lj->li", gain, x_next[lanes] - x_predicted)
            smoothed = p + gain @ (p_next[lanes] - predicted) @ np.swapaxes(gain, -1, -2)
            p_out[k, lanes] = 0.5 * (smoothed + np.swapaxes(smoothed, -1, -2))
        now = np.flatnonzero(there)
        x_after[now] = state[k, now]
        x_next[now], p_next[now], t_next[now] = x_out[k, now], p_out[k, now], time_s[k, now]
        is_next_linked[now], following[now] = linked[k, now], k
    return x_out, p_out


def solve_scaled(symmetric: Floats, right: Floats) -> Floats:
    """Solve S X = R with S scaled to a unit diagonal."""
    scale = 1.0 / np.sqrt(np.einsum("lii->li", symmetric))
    unit = symmetric * scale[:, :, None] * scale[:, None, :]
    return np.asarray(np.linalg.solve(unit, right * scale[:, :, None]) * scale[:, :, None])
