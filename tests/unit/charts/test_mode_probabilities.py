"""Probabilities of the models of several tracks whose estimates come at instants of their own."""

from __future__ import annotations

import numpy as np

from algorithms.result import Table
from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions
from tests.chart_views import marks, run

DRAW = charts("run")["mode_probabilities"].draw


def table(rows: list[tuple[float, float, float]]) -> Table:
    """Track, time and the second model's probability of each estimate."""
    track, time, second = (np.repeat(np.array(column), 2) for column in zip(*rows, strict=True))
    both = np.where(np.arange(track.size) % 2 == 1, second, 1 - second)
    models = ["straight flight", "manoeuvre"] * len(rows)
    return Table({"track": track, "time_s": time, "model": models, "probability": both})


def test_each_track_keeps_what_it_had_between_its_estimates(traces_of) -> None:
    """Two tracks in turn, one turning, the other not: half of the tracks turn, at every instant that both live."""
    rows = [(float(1 + k % 2), float(k), 0.9 if k % 2 else 0.1) for k in range(10)] + [(1.0, 20.0, 0.3)]
    straight, turning = traces_of(DRAW(run(marks(), {"mode_probabilities": table(rows)}), ChartOptions()), "series")
    np.testing.assert_allclose(turning["x"], [*range(10), 20.0])
    np.testing.assert_allclose(turning["y"], [0.1, *[0.5] * 9, 0.3], rtol=1e-6)
    np.testing.assert_allclose(np.add(straight["y"], turning["y"]), 1.0, rtol=1e-6)
