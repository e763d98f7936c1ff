"""What came of joining the tracks of several radars: tables and metrics."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.scoring import track_shares
from algorithms.plot_tracking.truth import Matched, truth_of
from algorithms.recording import PolarPlots
from algorithms.result import GivenColumn, Metric, Table

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ONE_TARGET = "they are near each other wherever both live"
ANOTHER = "another track is nearer, or their addresses contradict each other"
TOO_FAR = "they are too far from each other"


def compared_tracks(a: dict[str, Any], lanes: int) -> Table:
    """Every pair of tracks of different radars that came near each other, and whether they were joined."""
    same = a["compared_same"].astype(bool)
    near = a["compared_statistic"] <= a["compared_threshold"]
    reasons = [
        ONE_TARGET if s else (ANOTHER if n else TOO_FAR) for s, n in zip(same.tolist(), near.tolist(), strict=True)
    ]
    columns: dict[str, GivenColumn] = {
        "trial": np.full(same.size, np.nan) if lanes == 1 else a["compared_trial"].astype(float),
        "track_1": a["compared_first"].astype(float),
        "track_2": a["compared_second"].astype(float),
        "instants": a["compared_instants"].astype(float),
        "statistic": a["compared_statistic"],
        "threshold": a["compared_threshold"],
        "decision": ["joined" if s else "apart" for s in same.tolist()],
        "reason": reasons,
    }
    return Table(columns)


def joined_states(a: dict[str, Any], target: list[str | None], lanes: int) -> Table:
    """Joint tracks at the instants of their radars' estimates, from all tracks that live then."""
    at = a["joined_estimate"]
    east, north, ve, vn = a["joined_state"].T
    xx, yy, xy = a["joined_covariance"].T
    trial = a["estimate_trial"][at].astype(float)
    columns: dict[str, GivenColumn] = {
        "trial": np.full(at.size, np.nan) if lanes == 1 else trial,
        "joined": a["estimate_joined"][at].astype(float),
        "time_s": a["estimate_time_s"][at],
        "tracks": a["joined_tracks"].astype(float),
        "east_m": east,
        "north_m": north,
        "velocity_east_mps": ve,
        "velocity_north_mps": vn,
        "sigma_east_m": np.sqrt(xx),
        "sigma_north_m": np.sqrt(yy),
        "covariance_east_north_m2": xy,
        "target": [target[i] for i in at.tolist()],
    }
    return Table(columns)


def joined_metrics(recording: PolarPlots, a: dict[str, Any], m: Matched | None) -> list[Metric]:
    """How many joint tracks there are and, with truth, how many are wrong and how good their places are."""
    key = np.unique(np.stack([a["estimate_trial"], a["estimate_joined"]]), axis=1)
    lanes = a["decision"].shape[1]
    out = [Metric("joined_tracks", key.shape[1] / max(lanes, 1), "1", lanes)]
    if m is None:
        return out
    trial, number, best, _ = track_shares(m, a)
    target = dict(zip(zip(trial.tolist(), number.tolist(), strict=True), best.tolist(), strict=True))
    pairs = [
        (target.get((t, one), -1), target.get((t, two), -2), bool(same))
        for t, one, two, same in zip(
            a["compared_trial"].tolist(), a["compared_first"].tolist(), a["compared_second"].tolist(),
            a["compared_same"].tolist(), strict=True,
        )
    ]  # fmt: skip
    true = [same for one, two, same in pairs if one == two]
    made = [one == two for one, two, same in pairs if same]
    out.append(Metric("join_recall", sum(true) / len(true) if true else None, "1", len(true)))
    out.append(Metric("join_precision", sum(made) / len(made) if made else None, "1", len(made)))
    at = a["joined_estimate"]
    owner = m.owner[at]
    own = truth_of(recording, a["estimate_time_s"][at])
    known = np.flatnonzero(owner >= 0)
    if own is not None and known.size:
        off = a["joined_state"][known, :2] - own.position_m[known, owner[known]]
        squared = (off**2).sum(axis=1)
        out.append(Metric("rms_joined_m", float(np.sqrt(np.nanmean(squared))), "m", int(known.size)))
    return out
