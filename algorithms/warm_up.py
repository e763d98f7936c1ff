"""Compile every kernel once, so that the first run of a user does not wait for the compiler."""

from __future__ import annotations

import numpy as np

from algorithms.recording import ToaMarks
from algorithms.registry import algorithms_by_name
from algorithms.site import Site
from algorithms.spec import LocalContext

_SITE = {
    "origin": {"latitude_deg": 55.0, "longitude_deg": 37.0},
    "stations": [
        {"name": "1", "east_m": 5000, "north_m": 8660, "up_m": 15},
        {"name": "2", "east_m": 5000, "north_m": -8660, "up_m": 15},
        {"name": "3", "east_m": -10000, "north_m": 0, "up_m": 15},
        {"name": "4", "east_m": 0, "north_m": 0, "up_m": 15},
    ],
}


def warm_up() -> None:
    """Run, tabulate and score every algorithm on a few marks; the compiled kernels stay in the kernel cache."""
    site = Site.model_validate(_SITE)
    marks = 4
    truth = np.stack([30_000.0 + 200 * np.arange(marks), np.full(marks, 9_000.0), np.full(marks, 8_000.0)], axis=1)
    toa = np.linalg.norm(truth[:, None] - site.station_positions(), axis=2) / 299_792_458.0
    recording = ToaMarks(
        time_s=np.arange(marks, dtype=float),
        row=np.arange(1, marks + 1),
        target=np.zeros(marks, np.int64),
        truth_m=truth,
        site=site,
        toa_s=toa[:, :, None],
        altitude_m=np.full((marks, 1), 8_090.0),
        stations=tuple(s.name for s in site.stations),
    )
    for algorithm in algorithms_by_name().values():
        if recording.kind in algorithm.takes:
            result = algorithm.run(recording, algorithm.parameters(), LocalContext())
            algorithm.tabulate(recording, result)
            if algorithm.score is not None:
                algorithm.score(recording, algorithm.parameters(), LocalContext())
            if algorithm.bound is not None:
                algorithm.bound(recording, algorithm.parameters())
