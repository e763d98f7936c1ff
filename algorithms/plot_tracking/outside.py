"""Plots that lay just outside the gate of a track which then had none: what the outer ellipse did not hold.

Between the gate and twice its radius, of a confirmed track that has just missed its first scan, and taken by nobody.
With right accuracies 0.2 % of a target's plots lie there; false plots seldom do.

References
----------
Specification 5, 10.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.plots import Scan
from algorithms.toolbox.association.sparse import pairs_within

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# So many radii of the gate.
WITHIN = 2.0


def just_outside(lane: Ints, centre: Floats, shape: Floats, scan: Scan, free: Ints) -> Ints:
    """(T,) position among the scan's plots of the nearest one just outside each track's gate, -1 = none.

    Parameters
    ----------
    lane : (T,) trials of the tracks
    centre, shape : (T, models, 2) east and north, (T, models, 2, 2) covariance at the gate's edge; the nearest counts
    free : plots of no track
    """
    out = np.full(lane.size, -1)
    if not (lane.size and free.size):
        return out
    z = np.stack([scan.rho * np.sin(scan.theta), scan.rho * np.cos(scan.theta)], axis=1)
    half = WITHIN * np.sqrt(shape[..., 0, 0])
    order = free[np.lexsort((z[free, 0], scan.lane[free]))]
    low, high = (centre[..., 0] - half).min(axis=1), (centre[..., 0] + half).max(axis=1)
    i, j = pairs_within(lane, low, high, scan.lane[order], z[order, 0])
    plot = order[j]
    off = z[plot][:, None] - centre[i]
    xx, yy, xy = shape[i, :, 0, 0], shape[i, :, 1, 1], shape[i, :, 0, 1]
    squared = (yy * off[..., 0] ** 2 - 2.0 * xy * off[..., 0] * off[..., 1] + xx * off[..., 1] ** 2) / (xx * yy - xy**2)
    share = squared.min(axis=1)
    near = np.flatnonzero((share > 1.0) & (share <= WITHIN**2))
    # The nearest is written last.
    near = near[np.argsort(-share[near], kind="stable")]
    out[i[near]] = plot[near]
    return out
