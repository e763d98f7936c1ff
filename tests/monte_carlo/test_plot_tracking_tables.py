"""Tables 9.2 (close aircraft) and 9.3 (ten aircraft, missed and false plots) of the specification, cell by cell.

A cell is reproduced within three standard errors of both sides together. Those of table 9.2 are not printed: an
exchange of two tracks makes a switch of each, so that a mean of v switches has a variance of about 1.5 v in a run.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.plot_tracking import curvature_tracker, imm_tracker
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.scores import Scores
from algorithms.spec import LocalContext

# The tables were made with five missed scans and a gate three times as wide after a miss.
OLD = {"drop_after": 5, "coasting_gate": 3.0}
KALMAN = {"motion": "constant_velocity", "sd_straight_mps2": 3.0, **OLD}
CURVATURE: dict[str, dict[str, Any]] = {
    "paper": {},
    "keep": {"on_miss": "keep"},
    "line": {"predictor": "line", "gate": "sqrt", "kept_plots": 3},
    "map6": {"predictor": "map6", "gate": "exact", "cost": "distance_determinant", "max_speed_mps": 350.0},
}
MODELS: dict[str, dict[str, Any]] = {
    "kf nearest": {**KALMAN, "association": "nearest"},
    "kf joint": {**KALMAN, "association": "joint"},
    "imm nearest": {**OLD, "association": "nearest"},
    "imm joint": {**OLD, "association": "joint"},
}


def scored(recording: PolarPlots, method: str) -> Scores:
    if method in CURVATURE:
        return curvature_tracker.score(recording, CurvatureParameters(**CURVATURE[method]), LocalContext())
    return imm_tracker.score(recording, ImmParameters(**MODELS[method]), LocalContext())


def mean_of(scores: Scores, metric: str) -> float:
    (tally,) = (t for t in scores.tallies if t.metric == metric)
    return float(np.sum(tally.numerator) / np.sum(tally.denominator))


def simulated(name: str, trials: int, **parameters: Any) -> PolarPlots:
    scenario = scenarios_by_name()[name]
    recording = scenario.simulate(scenario.parameters(**parameters), tuple(range(trials)), 7)
    assert isinstance(recording, PolarPlots)
    return recording


CLOSE = ("paper", "line", "map6", "kf nearest", "kf joint", "imm nearest", "imm joint")
CLOSE_RUNS, TABLE_RUNS = 48, 50
# 0.02 switches of the penalised curve are printed here, one exchange in 50 runs; in 1,200 of ours it is 0.098, and
# groups of 50 of them lie between 0.02 and 0.26: so few runs say little.
MORE_RUNS = {("par1000", False): 400}
# Switches of a target with every plot detected and no false ones, and with detection 0.9 and ten false plots a scan.
TABLE_9_2: dict[str, tuple[str, dict[str, Any], tuple[float, ...], tuple[float, ...]]] = {
    "cross90": ("crossing_aircraft", {"crossing_angle_deg": 90.0}, (0, 0, 0, 0, 0, 0, 0), (0, 0, 0, 0, 0, 0, 0)),
    "cross30": ("crossing_aircraft", {"crossing_angle_deg": 30.0},
                (0.08, 0, 0.04, 0.02, 0, 0, 0), (0.08, 0.04, 0.10, 0.05, 0.08, 0.10, 0.08)),
    "cross10": ("crossing_aircraft", {"crossing_angle_deg": 10.0},
                (0.36, 0.12, 0.32, 0.24, 0.08, 0.24, 0), (0.58, 0.18, 0.41, 0.45, 0.04, 0.34, 0.04)),
    "par2000": ("parallel_aircraft", {"distance_m": 2000.0},
                (0, 0, 0, 0, 0, 0, 0), (0.15, 0, 0.03, 0.02, 0.01, 0.01, 0)),
    "par1000": ("parallel_aircraft", {"distance_m": 1000.0},
                (0.42, 0.02, 0.02, 0, 0.08, 0, 0.08), (0.93, 0.11, 0.72, 0.40, 0.24, 0.27, 0.42)),
    "par500": ("parallel_aircraft", {"distance_m": 500.0},
               (3.8, 0.6, 2.9, 1.5, 0.98, 1.1, 1.1), (3.5, 1.0, 3.3, 2.4, 0.93, 2.0, 0.88)),
    "formation": ("aircraft_formation", {},
                  (0.12, 0.98, 0.06, 0, 0.05, 0, 0.03), (0.30, 1.35, 0.20, 0.04, 0.14, 0, 0.07)),
    "overtake": ("overtaking_aircraft", {},
                 (0.02, 0, 0.02, 0.12, 0, 0, 0), (0.10, 0, 0.08, 0.16, 0, 0, 0)),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("hard", [False, True], ids=["all detected", "0.9 and ten false"])
@pytest.mark.parametrize("name", TABLE_9_2)
def test_table_9_2(name: str, hard: bool) -> None:
    scenario, given, easy, clutter = TABLE_9_2[name]
    more = {"detection_probability": 0.9, "false_plots": 10.0} if hard else {}
    runs = MORE_RUNS.get((name, hard), CLOSE_RUNS)
    recording = simulated(scenario, runs, **given, **more)
    found = np.array([mean_of(scored(recording, method), "switches_per_target") for method in CLOSE])
    printed = np.array(clutter if hard else easy, float)
    print(name, dict(zip(CLOSE, np.round(found, 2).tolist(), strict=True)))
    # None in 50 runs is no proof that there is none.
    interval = 3 * np.sqrt(1.5 * np.maximum(printed, 0.04) * (1 / TABLE_RUNS + 1 / runs))
    assert (np.abs(found - printed) <= interval + 0.02).all()


MANY = ("paper", "keep", "line", "map6", "kf nearest", "imm nearest", "imm joint")
MANY_RUNS, TEN_RUNS = 16, 30
# (detection, false plots): OSPA in m of each method, then the printed standard error of the paper's tracker.
TABLE_9_3 = {
    (0.7, 0): (433, 467, 488, 374, 313, 271, 287, 14),
    (0.7, 20): (427, 498, 454, 378, 342, 324, 266, 13),
    (0.7, 50): (494, 586, 486, 418, 447, 499, 292, 13),
    (0.8, 10): (301, 338, 339, 269, 231, 193, 192, 7),
    (0.8, 50): (392, 500, 361, 309, 286, 331, 202, 12),
    (0.9, 0): (243, 286, 293, 223, 195, 161, 166, 4),
    (0.9, 10): (257, 283, 280, 234, 194, 162, 164, 6),
    (0.9, 50): (308, 442, 302, 256, 241, 257, 184, 12),
    (0.95, 0): (226, 244, 261, 212, 187, 154, 159, 4),
    (0.95, 50): (299, 439, 274, 239, 231, 308, 163, 11),
    (1.0, 10): (213, 233, 259, 197, 179, 149, 152, 4),
}


@pytest.mark.slow
@pytest.mark.parametrize(("detection", "false"), TABLE_9_3, ids=str)
def test_table_9_3(detection: float, false: int) -> None:
    recording = simulated("ten_aircraft", MANY_RUNS, detection_probability=detection, false_plots=float(false))
    found = np.array([mean_of(scored(recording, method), "ospa_m") for method in MANY])
    *cells, error = TABLE_9_3[detection, false]
    printed = np.array(cells, float)
    print(detection, false, dict(zip(MANY, np.round(found).tolist(), strict=True)))
    interval = 3 * error * np.sqrt(1 + TEN_RUNS / MANY_RUNS) + 0.04 * printed
    # An error is printed of the paper's tracker alone; straight lines and `keep` lose tracks, and scatter more.
    interval *= np.array([2.0 if method in ("line", "keep") else 1.0 for method in MANY])
    assert (found <= printed + interval).all()
    # Filters are better than the table among many false plots: here a pair must be more probable than a miss, and
    # what is not confirmed has no wider gate after one, so that there are fewer tracks of nothing.
    better = np.array([false >= 50 and method in ("kf nearest", "imm nearest") for method in MANY])
    assert (found >= printed - interval)[~better].all()
    assert (found[-1] < found[:5]).all(), "interacting models with joint probabilities beat what cannot turn"
