"""Small tables of a tracker, written by hand, for the tests of the charts."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.recording import Recording
from algorithms.result import Table

DECIDED = (("updated", 0.6), ("updated_middle", 2.0), ("manoeuvre", 3.0))


def track_decisions(recording: Recording) -> Table:
    """Plots in tracking gates of radius 3.5, in each of the three ellipses in turn."""
    count = len(recording)
    columns: dict[str, Any] = {
        "track": np.ones(count),
        "row": recording.row.astype(float),
        "time_s": recording.time_s.copy(),
        "decision": [DECIDED[i % 3][0] for i in range(count)],
        "distance": np.array([DECIDED[i % 3][1] for i in range(count)]),
        "threshold": np.full(count, 3.5),
        "reason": [None] * count,
        "target": [recording.targets[i] for i in recording.target],
        "gate": ["tracking"] * count,
        "competing": ["2"] * count,
    }
    return Table(columns)


def motion(count: int) -> dict[str, Any]:
    """Columns of states that only trackers fill."""
    return {
        "speed_mps": np.full(count, 200.0),
        "sigma_speed_mps": np.full(count, 10.0),
        "normal_acceleration_mps2": np.full(count, 2.0),
    }
