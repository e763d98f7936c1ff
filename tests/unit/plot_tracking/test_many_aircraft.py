"""As many aircraft as are asked for, all over the disc, and what they cost is told."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.plot_tracking import imm_tracker
from algorithms.plot_tracking.presets import MANY
from algorithms.plot_tracking.scenario import simulate_many
from algorithms.recording import CLUTTER
from algorithms.spec import LocalContext


@pytest.mark.parametrize("aircraft", [1, 7, 200])
def test_they_begin_all_over_the_disc(aircraft: int) -> None:
    plots = simulate_many(MANY(aircraft=aircraft, disc_radius_m=50_000.0, false_plots=0.0), (0,), 1)
    assert sum(name != CLUTTER for name in plots.targets) == aircraft
    first = plots.truth_m[plots.time_s == 0.0]
    assert len(first) == aircraft
    r = np.sort(np.hypot(first[:, 0], first[:, 1]))
    assert r[-1] <= 50_000.0
    # Evenly: as many within a circle as is its share of the area.
    share = np.searchsorted(r, [25_000.0, 40_000.0]) / aircraft
    assert share == pytest.approx([0.25, 0.64], abs=1 / aircraft)
    assert abs(np.arctan2(first[:, 0], first[:, 1]).mean()) < 1.0 or aircraft == 1


def test_each_gets_a_track() -> None:
    plots = simulate_many(MANY(aircraft=60), (0,), 1)
    parameters = imm_tracker.ALGORITHM.parameters()
    result = imm_tracker.ALGORITHM.run(plots, parameters, LocalContext())
    found = {m.metric: m.value for m in imm_tracker.ALGORITHM.measure(plots, result) if not m.target and not m.segment}
    assert found["confirmed_tracks"] == pytest.approx(60, abs=2)
    assert found["switches"] == 0
