"""What is asked of a tracker against what it did."""

from __future__ import annotations

import numpy as np

from algorithms.plot_tracking.imm_tracker import run
from algorithms.plot_tracking.parameters import ImmParameters
from algorithms.plot_tracking.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.spec import LocalContext


def rows(name: str, *, without: tuple[int, int] | None = None, **asked: object) -> dict[tuple[object, ...], tuple]:
    """Verdict, value and number by target, segment and requirement."""
    scenario = scenarios_by_name()[name]
    recording = scenario.simulate(scenario.parameters(), (0,), 2)
    assert isinstance(recording, PolarPlots)
    if without is not None:
        keep = (recording.time_s < without[0]) | (recording.time_s >= without[1]) | (recording.target != 0)
        # The truth stays: what is not seen is asked for all the same.
        recording.range_m[~keep], recording.azimuth_rad[~keep] = np.nan, np.nan
    table = tabulate(recording, run(recording, ImmParameters(**asked), LocalContext()))["requirements"]
    return {tuple(row[:3]): (row[6], row[3], row[7]) for row in table.rows()}


def test_each_target_and_segment_passes_or_fails() -> None:
    found = rows("ten_aircraft", required_rms_m=250.0, required_tracked_share=0.95, allowed_switches=0)
    assert found[None, "whole", "rms_horizontal_m"][0] == "passed"
    assert found["7", "manoeuvre", "switches"][0] == "passed"
    # The first flies straight: of manoeuvres there is nothing to say.
    assert found["1", "manoeuvre", "rms_horizontal_m"][:2] == ("no data", None)
    assert found[None, "whole", "false_tracks"][0] == "not asked"
    strict = rows("ten_aircraft", required_rms_m=50.0)
    assert strict["1", "straight", "rms_horizontal_m"][0] == "failed"
    assert {v[0] for k, v in strict.items() if k[2] == "tracked_share"} == {"not asked"}


def test_the_segments_are_the_scenarios() -> None:
    found = rows("wide_turn")
    # 61 scans of 5 s, ten to settle; the turn lasts from 100 to 168.7 s, then 40 s of recovery.
    assert found[None, "whole", "rms_horizontal_m"][2] == 51
    assert found[None, "manoeuvre", "rms_horizontal_m"][2] == 14
    assert found[None, "recovery", "rms_horizontal_m"][2] == 8
    assert found[None, "straight", "rms_horizontal_m"][2] == 51 - 14 - 8


def test_a_target_that_is_lost_fails_what_is_asked_of_its_continuity() -> None:
    asked = {"required_tracked_share": 0.95, "allowed_switches": 0}
    found = rows("ten_aircraft", without=(100, 250), **asked)
    assert found["1", "whole", "tracked_share"][0] == "failed"
    assert found["1", "whole", "switches"][0] == "failed"
    assert found["2", "whole", "tracked_share"][0] == "passed"
