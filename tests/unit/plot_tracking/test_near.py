"""How near a track must be to be a target's: ten errors of a plot there, 2 km at most."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.plot_tracking import imm_tracker
from algorithms.plot_tracking.parameters import ImmParameters
from algorithms.plot_tracking.truth import Matched, matched
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.spec import LocalContext


def simulated(**parameters: object) -> PolarPlots:
    scenario = scenarios_by_name()["parallel_aircraft"]
    recording = scenario.simulate(scenario.parameters(**parameters), (0,), 3)
    assert isinstance(recording, PolarPlots)
    return recording


def found_of(recording: PolarPlots, seen: PolarPlots) -> Matched:
    found = matched(recording, dict(imm_tracker.run(seen, ImmParameters(), LocalContext()).arrays), 1)
    assert found is not None
    return found


def test_a_track_that_errs_by_more_than_ten_errors_is_nobodys() -> None:
    recording = simulated(distance_m=5000.0, sigma_range_m=10.0, sigma_azimuth_deg=0.01)
    # Plots lie 500 m farther from the radar than the target: within 2 km, but far for such a radar.
    off = replace(recording, range_m=recording.range_m + 500.0)
    assert found_of(recording, recording).estimate.max() >= 0
    assert found_of(recording, off).estimate.max() < 0
    coarse = simulated(distance_m=5000.0)
    assert found_of(coarse, replace(coarse, range_m=coarse.range_m + 500.0)).estimate.max() >= 0


def test_sets_are_cut_where_tracks_are_no_longer_near() -> None:
    recording = simulated(distance_m=5000.0, sigma_range_m=10.0, sigma_azimuth_deg=0.01)
    found = found_of(recording, recording.take(np.flatnonzero(recording.target == 0)))
    # One of two targets has no track: the root of half of the square of the cut, and a little.
    at_end = float(found.distances[-1].ospa_m[0])
    azimuth_error = np.radians(0.01) * 60_000
    assert at_end == pytest.approx(max(10.0, azimuth_error) * 10 / np.sqrt(2), rel=0.1)
