"""Statistics of a forward-scatter method over simulated trials, as a run of the server would find them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import LocalContext
from algorithms.toolbox.monte_carlo.running import Running
from algorithms.toolbox.monte_carlo.sums import sums_of

Floats = NDArray[np.float64]

SEED = 77
TRIALS = 1024
LINES, ML, ANGLE, KALMAN = (f"forward_scatter_{n}" for n in ("lines", "ml", "angle", "kalman"))
RMS, SD, MEAN, CLAIMED = (f"crossing_distance_{n}_m" for n in ("rms", "sd", "mean", "claimed"))
BOUND_3, BOUND_4 = (f"crossing_distance_bound_{n}_m" for n in (3, 4))
MEDIAN, FAR = "median_crossing_distance_m", "crossing_distance_over_5km_share"
AT = ("t=9", "t=12", "t=16", "t=20", "t=30")
S15, S30 = {"crossing_distance_m": 15_000.0}, {"crossing_distance_m": 30_000.0}


@cache
def _running(name: str, scenario: Any, trials: int, parameters: Any) -> Running:
    algorithm, preset = algorithms_by_name()[name], scenarios_by_name()["forward_scatter_pass"]
    conditions, given = preset.parameters(**dict(scenario)), algorithm.parameters(**dict(parameters))
    assert algorithm.score is not None
    running = Running(1)
    for first in range(0, trials, 64):
        recording = preset.simulate(conditions, tuple(range(first, first + 64)), SEED)
        running.add([sums_of(algorithm.score(recording, given, LocalContext(SEED, first)), preset.legs(conditions))])
    return running


def running(name: str, scenario: dict[str, Any], trials: int = TRIALS, **parameters: Any) -> Running:
    """Statistics of so many trials; asked for again they are there."""
    return _running(name, tuple(sorted(scenario.items())), trials, tuple(sorted(parameters.items())))


class Found:
    """Metrics of a method by name and segment, and curves over the instants."""

    def __init__(self, name: str, scenario: dict[str, Any], trials: int = TRIALS, **parameters: Any) -> None:
        self._running = running(name, scenario, trials, **parameters)
        self._metrics = {(m.metric, m.segment): m.value for m in self._running.metrics(0)}

    def at(self, metric: str, segments: tuple[str, ...] = AT) -> list[float]:
        """One metric at some legs; NaN where there is no value."""
        return [np.nan if (value := self._metrics[metric, s]) is None else value for s in segments]

    def curve(self, metric: str) -> Floats:
        """One metric at every instant."""
        return self._running.curves(0)[metric]
