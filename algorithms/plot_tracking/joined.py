"""Tracks of several radars that are one target, as arrays of a result.

Each radar is tracked by itself; the tracks are joined afterwards, over the whole recording.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.parameters import TrackerParameters
from algorithms.plot_tracking.radars import Feed
from algorithms.recording import PolarPlots
from algorithms.toolbox.tracks.joining import Comparison, Estimates, join

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# By which a target leaves the straight line between the looks of two radars, m/s2.
SD_ACCELERATION = 1.0


@dataclass(frozen=True)
class Joining:
    """What is known of the radars: `period_s` (radars,), and the address that each row of the recording says (M,)."""

    period_s: Floats
    address: Ints
    registration_m: float


def joining_of(
    recording: PolarPlots, feeds: Sequence[Feed], parameters: TrackerParameters, *, identities: bool
) -> Joining | None:
    """Return what joining needs; None where there is but one radar."""
    if len(feeds) < 2:
        return None
    address = recording.address if identities else np.full(len(recording), -1)
    return Joining(np.array([feed.period_s for feed in feeds]), address, parameters.registration_m)


def joined_tracks(arrays: Mapping[str, Any], covariance: Floats, joining: Joining | None) -> dict[str, Any]:
    """Arrays `estimate_joined`, `joined_*` and `compared_*`; `covariance` is the whole one of each estimate."""
    if joining is None or not len(covariance):
        return _arrays(arrays["estimate_track"], *_nothing())
    mark = arrays["estimate_mark"]
    found = join(
        Estimates(
            arrays["estimate_trial"],
            arrays["estimate_track"],
            arrays["estimate_radar"],
            arrays["estimate_time_s"],
            arrays["estimate_state"],
            covariance,
            np.where(mark >= 0, joining.address[np.maximum(mark, 0)], -1),
        ),
        joining.period_s,
        SD_ACCELERATION,
        joining.registration_m,
    )
    several = np.flatnonzero(found.tracks > 1)
    return _arrays(
        found.number, several, found.tracks[several], found.state[several], found.covariance[several], found.compared
    )


def _arrays(
    number: Ints, estimate: Ints, tracks: Ints, state: Floats, covariance: Floats, compared: Comparison
) -> dict[str, Any]:
    xx, yy, xy = covariance[:, 0, 0], covariance[:, 1, 1], covariance[:, 0, 1]
    return {
        "estimate_joined": number,
        "joined_estimate": estimate,
        "joined_tracks": tracks,
        "joined_state": state,
        "joined_covariance": np.stack([xx, yy, xy], axis=1),
        "compared_trial": compared.lane,
        "compared_first": compared.first,
        "compared_second": compared.second,
        "compared_instants": compared.common,
        "compared_statistic": compared.statistic,
        "compared_threshold": compared.threshold,
        "compared_same": compared.same.astype(np.int64),
    }


def _nothing() -> tuple[Ints, Ints, Floats, Floats, Comparison]:
    none, value = np.empty(0, np.int64), np.empty(0)
    compared = Comparison(none, none, none, none, value, value, np.empty(0, bool))
    return none, none, np.empty((0, 4)), np.empty((0, 4, 4)), compared
