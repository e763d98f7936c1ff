"""How pure the tracks are: which of their plots come from the target that most of a track's plots come from."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.outputs import SHARED
from algorithms.recording import CLUTTER, PolarPlots

Ints = NDArray[np.int64]


def taken_by(a: dict[str, Any], tracks: Ints, lanes: int) -> NDArray[np.bool_]:
    """(M, L) whether a plot went into one of these tracks (trial, number)."""
    track = a["track"]
    most = int(max(track.max(initial=0), tracks[1].max(initial=0))) + 1
    known = np.zeros((lanes, most), bool)
    known[tracks[0], tracks[1]] = True
    out: NDArray[np.bool_] = known[np.arange(lanes)[None], track] & (track > 0)
    return out


def purity_counts(recording: PolarPlots, a: dict[str, Any]) -> tuple[Ints, Ints]:
    """(L,) plots of confirmed tracks that are of the track's own target, and all of them; 0 where nothing is named."""
    lanes = a["track"].shape[1]
    named = np.array([name not in ("", CLUTTER) for name in recording.targets], bool)
    if not named.any():
        return np.zeros(lanes, np.int64), np.zeros(lanes, np.int64)
    confirmed = np.unique(np.stack([a["estimate_trial"], a["estimate_track"]]), axis=1)
    mark, lane = np.nonzero(taken_by(a, confirmed, lanes) & (a["decision"] != SHARED))
    tracks, index = np.unique(np.stack([lane, a["track"][mark, lane]]), axis=1, return_inverse=True)
    target = np.where(named[recording.target[mark]], recording.target[mark], -1)
    pair, count = np.unique(np.stack([index.ravel(), target]), axis=1, return_counts=True)
    best = np.zeros(tracks.shape[1], np.int64)
    real = pair[1] >= 0
    np.maximum.at(best, pair[0][real], count[real])
    own = np.bincount(tracks[0], best, lanes).astype(np.int64)
    return own, np.bincount(lane, minlength=lanes)
