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
        "outside": np.where(np.arange(count) % 50 == 3, 1.0, np.nan),
    }
    return Table(columns)


def motion(count: int) -> dict[str, Any]:
    """Columns of states that only trackers fill."""
    return {
        "speed_mps": np.full(count, 200.0),
        "sigma_speed_mps": np.full(count, 10.0),
        "normal_acceleration_mps2": np.full(count, 2.0),
        "course_deg": np.mod(350.0 + 5.0 * np.arange(count), 360.0),
        "q": np.minimum(2.0 + np.arange(count), 12.0),
        "window_plots": np.minimum(3.0 + np.arange(count), 13.0),
    }


def set_distances(recording: Recording) -> Table:
    """A set of tracks that misses a target in every second scan."""
    time = np.unique(recording.time_s)
    missed = np.arange(time.size) % 2.0
    columns: dict[str, Any] = {
        "trial": np.full(time.size, np.nan),
        "radar": [None] * time.size,
        "time_s": time,
        "ospa_m": 150.0 + 500.0 * missed,
        "gospa_m": 300.0 + 1400.0 * missed,
        "localisation_m": np.full(time.size, 300.0),
        "missed": missed,
        "false": np.zeros(time.size),
    }
    return Table(columns)
