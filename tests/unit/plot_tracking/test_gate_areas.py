"""The ellipses that a plan shows as gates are those in which the trackers looked for plots."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np
import pytest

from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.plot_tracking.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

TRACKERS: dict[str, Callable[[PolarPlots], Result]] = {
    "imm": lambda r: imm_tracker.run(r, ImmParameters(association="nearest"), LocalContext()),
    "paper": lambda r: curvature_tracker.run(r, CurvatureParameters(), LocalContext()),
    "exact": lambda r: curvature_tracker.run(r, CurvatureParameters(gate="exact"), LocalContext()),
}


def share_of_radius(area: tuple[float, ...], east: float, north: float) -> float:
    """Squared distance from the centre, 1 at the edge."""
    centre_east, centre_north, major, minor, azimuth = area
    e, n, turn = east - centre_east, north - centre_north, np.radians(azimuth)
    along, across = e * np.sin(turn) + n * np.cos(turn), e * np.cos(turn) - n * np.sin(turn)
    return float((along / major) ** 2 + (across / minor) ** 2)


@pytest.mark.parametrize("tracker", TRACKERS.values(), ids=TRACKERS)
def test_plots_lie_in_the_ellipses_as_far_as_the_decisions_say(tracker: Callable[[PolarPlots], Result]) -> None:
    scenario = scenarios_by_name()["wide_turn"]
    recording = scenario.simulate(scenario.parameters(detection_probability=0.9), (0,), 4)
    assert isinstance(recording, PolarPlots)
    tables = tabulate(recording, tracker(recording))
    areas = defaultdict(list)
    for _, track, time, gate, *area in tables["gate_areas"].rows():
        if gate == "tracking":
            areas[track, time].append(tuple(area))
    columns = tables["decisions"].columns
    found = []
    for track, row, time, gate, distance, threshold in zip(
        *(columns[n] for n in ("track", "row", "time_s", "gate", "distance", "threshold")), strict=True
    ):
        if gate != "tracking":
            continue
        at = int(np.flatnonzero(recording.row == row)[0])
        rho, theta = recording.range_m[at, 0], recording.azimuth_rad[at, 0]
        nearest = min(share_of_radius(a, rho * np.sin(theta), rho * np.cos(theta)) for a in areas[track, time])
        found.append((nearest**0.5, distance / threshold))
    assert len(found) > 40
    drawn, decided = np.array(found).T
    # While coasting the gate is wider than the threshold tells; a polar gate is a little bent.
    assert np.median(np.abs(drawn - decided)) < 0.01
    assert (drawn < 1.03).all()


@pytest.mark.parametrize("tracker", TRACKERS.values(), ids=TRACKERS)
def test_second_and_third_plots_lie_in_the_circles_of_their_gates(tracker: Callable[[PolarPlots], Result]) -> None:
    scenario = scenarios_by_name()["ten_aircraft"]
    recording = scenario.simulate(scenario.parameters(false_plots=20), (0,), 4)
    assert isinstance(recording, PolarPlots)
    tables = tabulate(recording, tracker(recording))
    areas = defaultdict(list)
    for _, _, time, gate, *area in tables["gate_areas"].rows():
        areas[gate, time].append(tuple(area))
    assert {gate for gate, _ in areas} == {"start", "acquisition", "tracking"}
    columns = tables["decisions"].columns
    found = {"start": 0, "acquisition": 0}
    for row, time, gate, distance, threshold in zip(
        *(columns[n] for n in ("row", "time_s", "gate", "distance", "threshold")), strict=True
    ):
        if gate not in found:
            continue
        at = int(np.flatnonzero(recording.row == row)[0])
        rho, theta = recording.range_m[at, 0], recording.azimuth_rad[at, 0]
        east, north = rho * np.sin(theta), rho * np.cos(theta)
        shares = np.sqrt([share_of_radius(a, east, north) for a in areas[gate, time]])
        # One of the gates is the one in which it was found, as far from the middle as is told.
        assert np.abs(shares - distance / threshold).min() < 1e-3
        found[gate] += 1
    assert min(found.values()) >= 10
