"""Fixed-interval smoothing of constant-acceleration states whose noise is known in time: the backward pass (RTS).

    C = P_k F' (F P_k F' + Q)^-1,
    x_k|n = x_k + C (x_{k+1|n} - F x_k),   P_k|n = P_k + C (P_{k+1|n} - F P_k F' - Q) C',

over the interval to the next row that the filter used. Q is that of the rate form, which depends on elapsed time only,
so an instant between two used rows, where the filter predicted, is smoothed by the same formula and disturbs nothing.
`toolbox.filters.smoothing` knows neither such instants nor a noise that changes from row to row.

References
----------
barshalom2001, section 8.6 (Rauch, Tung, Striebel).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.filters.smoothing import solve_scaled
from algorithms.toolbox.kernels.symmetric import pack, unpack

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def transition_matrices(tau: Floats) -> Floats:
    """(L, 9, 9) of constant acceleration over tau (L,) s."""
    block = np.zeros((tau.size, 3, 3))
    block[:, [0, 1, 2], [0, 1, 2]] = 1.0
    block[:, 0, 1] = block[:, 1, 2] = tau
    block[:, 0, 2] = tau * tau / 2
    return _by_axes(block)


def noise_matrices(tau: Floats, density: Floats) -> Floats:
    """(L, 9, 9) of white noise in the jerk with `density` (L,) m^2/s^5 over tau (L,) s."""
    block = np.empty((tau.size, 3, 3))
    powers = {(0, 0): (5, 20), (0, 1): (4, 8), (0, 2): (3, 6), (1, 1): (3, 3), (1, 2): (2, 2), (2, 2): (1, 1)}
    for (i, j), (power, divisor) in powers.items():
        block[:, i, j] = block[:, j, i] = density * tau**power / divisor
    return _by_axes(block)


def _by_axes(block: Floats) -> Floats:
    out = np.zeros((len(block), 9, 9))
    for a in (0, 3, 6):
        out[:, a : a + 3, a : a + 3] = block
    return out


def smooth_backward(
    time_s: Floats, state: Floats, covariance: Floats, track: Ints, used: NDArray[np.bool_], density: Floats
) -> tuple[Floats, Floats]:
    """Smooth a target's rows, lanes side by side.

    Parameters
    ----------
    time_s : (M,), in order
    state, covariance : (M, 9, L), (M, 45, L) packed, filtered where `used`, elsewhere predicted
    track : (M, L), number of the track, 0 = none; nothing is smoothed from one track into another
    used : (M, L)
    density : (M, L) m^2/s^5, of the jerk over the interval that ends at a row

    Returns
    -------
    The same two arrays, smoothed; rows after the last used one of a track stay as they were.
    """
    out_state, out_covariance = state.copy(), covariance.copy()
    m, lanes = track.shape
    later = np.full(lanes, -1)
    for k in range(m - 1, -1, -1):
        go = np.flatnonzero((later >= 0) & (track[k] > 0) & (track[np.maximum(later, 0), np.arange(lanes)] == track[k]))
        if go.size:
            then = later[go]
            # Lanes that go on to different rows lie apart; as a rule they all go on to the next one.
            x, p = state[k][:, go].T, unpack(covariance[k][:, go]).transpose(2, 0, 1)
            next_x, next_p = out_state[then, :, go], unpack(out_covariance[then, :, go].T).transpose(2, 0, 1)
            tau = time_s[then] - time_s[k]
            f, q = transition_matrices(tau), noise_matrices(tau, density[then, go])
            xs, ps = _step(x, p, next_x, next_p, f, q)
            out_state[k][:, go] = xs.T
            out_covariance[k][:, go] = pack(ps.transpose(1, 2, 0))
        later = np.where(used[k], k, later)
    return out_state, out_covariance


def _step(x: Floats, p: Floats, next_x: Floats, next_p: Floats, f: Floats, q: Floats) -> tuple[Floats, Floats]:
    """One step back, for (L, 9) states and (L, 9, 9) covariances."""
    predicted = f @ p @ f.transpose(0, 2, 1) + q
    gain = solve_scaled(predicted, f @ p).transpose(0, 2, 1)
    moved = next_x - (f @ x[:, :, None])[:, :, 0]
    xs = x + (gain @ moved[:, :, None])[:, :, 0]
    ps = p + gain @ (next_p - predicted) @ gain.transpose(0, 2, 1)
    return xs, 0.5 * (ps + ps.transpose(0, 2, 1))
