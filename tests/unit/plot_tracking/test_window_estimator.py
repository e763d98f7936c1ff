"""The estimator of one window: whose plots it takes, what it gives, and what its numbers mean."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError

from algorithms.plot_tracking import window_estimator
from algorithms.plot_tracking.window_parameters import WindowParameters
from algorithms.recording import PolarPlots
from algorithms.registry import scenarios_by_name
from algorithms.scores import Scores
from algorithms.spec import LocalContext


def simulated(trials: int = 1, **parameters: Any) -> PolarPlots:
    scenario = scenarios_by_name()["steady_motions"]
    recording = scenario.simulate(scenario.parameters(**parameters), tuple(range(trials)), 5)
    assert isinstance(recording, PolarPlots)
    return recording


def scored(recording: PolarPlots, **parameters: Any) -> Scores:
    return window_estimator.score(recording, WindowParameters(**parameters), LocalContext())


def of_target(scores: Scores, metric: str, target: str) -> float:
    (tally,) = (t for t in scores.tallies if t.metric == metric)
    rows = scores.target == scores.targets.index(target)
    value = float(tally.numerator[rows].sum() / tally.denominator[rows].sum())
    return value**0.5 if tally.root else value


def test_plots_without_errors_give_the_truth_and_the_error_of_the_series() -> None:
    recording = simulated(sigma_range_m=1e-3, sigma_azimuth_deg=1e-6)
    scores = scored(recording, window_plots=13, least_across_m=0.0, series_order=3, series_ahead_s=20.0)
    for target in scores.targets:
        assert of_target(scores, "rms_horizontal_m", target) < 0.01
        assert of_target(scores, "rms_ahead_m", target) < 0.02
    assert of_target(scores, "rms_series_m", "wide_turn") == pytest.approx(16, abs=0.5)
    assert of_target(scores, "rms_series_m", "tight_turn") == pytest.approx(113, abs=0.5)
    assert of_target(scores, "rms_series_m", "straight_200") < 0.01


def test_estimates_begin_with_the_window_full_and_leave_false_plots_alone() -> None:
    recording = simulated(false_plots=20.0)
    result = window_estimator.run(recording, WindowParameters(window_plots=6), LocalContext())
    assert result.arrays["estimate_scan"].min() == 5
    # Fourteen scans, five targets.
    assert len(result.arrays["window_trial"]) == 5 * (14 - 5)
    tables = window_estimator.tabulate(recording, result)
    false = tables["decisions"].columns["target"].are("clutter")
    assert false.sum() > 100
    assert set(np.asarray(tables["decisions"].columns["decision"].are("started"))[false]) == {True}
    assert len(tables["windows"]) == len(tables["states"]) == 45


def test_without_names_everything_is_one_target_and_with_addresses_it_is_not() -> None:
    recording = simulated(transponders="address")
    none = replace(
        recording, target=np.zeros(len(recording), np.int64), targets=("",), truth_m=recording.truth_m * np.nan
    )
    p = WindowParameters(window_plots=6)
    by_address = window_estimator.run(none, p, LocalContext()).arrays
    assert set(by_address["window_track"]) == {1, 2, 3, 4, 5}
    alone = none.take(np.flatnonzero(none.address == 2))
    alone = replace(alone, address=np.full(len(alone), -1), addresses=())
    found = window_estimator.run(alone, p, LocalContext()).arrays
    assert set(found["window_track"]) == {1}
    assert_allclose(found["window_chi2"], by_address["window_chi2"][by_address["window_track"] == 3], rtol=1e-9)


def test_descents_that_fail_are_counted_and_give_no_estimate() -> None:
    recording = simulated(trials=8)
    damped, centre = (scored(recording, window_plots=13, descent=d, compare_minima=True) for d in ("damped", "centre"))
    assert of_target(damped, "lowest_share", "tight_turn") == 1
    assert of_target(centre, "lowest_share", "tight_turn") < 0.3
    assert of_target(centre, "converged_share", "tight_turn") < 0.3


def test_errors_are_near_the_bound_and_a_line_is_better_only_on_a_line() -> None:
    recording = simulated(trials=40)
    free, line = (scored(recording, window_plots=8, trajectory=t) for t in ("ml6", "line"))
    for target in ("straight_200", "wide_turn", "tight_turn"):
        ratio = of_target(free, "rms_horizontal_m", target) / of_target(free, "bound_horizontal_m", target)
        assert 0.85 < ratio < 1.15
    assert of_target(line, "rms_ahead_m", "straight_200") < 0.7 * of_target(free, "rms_ahead_m", "straight_200")
    assert of_target(line, "rms_ahead_m", "tight_turn") > 2 * of_target(free, "rms_ahead_m", "tight_turn")


@pytest.mark.parametrize(("trajectory", "plots"), [("ml6", 3), ("cubic", 3), ("quadratic", 2)])
def test_too_few_plots_are_refused(trajectory: Any, plots: int) -> None:
    with pytest.raises(ValidationError, match="needs at least"):
        WindowParameters(trajectory=trajectory, window_plots=plots)
