"""Radars that turn by themselves: instants of their plots, and what moving them to one instant is worth."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.identification.instants import truth_at
from algorithms.recording import PolarPlots
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import LocalContext

SCENARIO = scenarios_by_name()["turning_radars"]


def simulated(**parameters: Any) -> PolarPlots:
    found = SCENARIO.simulate(SCENARIO.parameters(**parameters), (0,), 1)
    assert isinstance(found, PolarPlots)
    return found


def test_a_beam_meets_a_target_where_it_is_by_then() -> None:
    plots = simulated(radars=3)
    assert (np.diff(plots.time_s) >= 0).all()
    assert np.unique(plots.time_s).size == len(plots)
    assert plots.site is not None
    offset = plots.truth_m[:, :2] - plots.site.radar_positions()[plots.radar, :2]
    azimuth = np.arctan2(*offset.T) / (2 * np.pi)
    for radar, turn in enumerate((10.0, 11.3, 12.6)):
        own = plots.radar == radar
        phase = np.mod(plots.time_s[own] / turn - azimuth[own], 1.0)
        away = np.angle(np.exp(2j * np.pi * (phase - phase[0])))
        np.testing.assert_allclose(away, 0, atol=1e-6, err_msg=f"radar {radar + 1} turns in {turn} s")


def test_targets_fly_straight() -> None:
    plots = simulated()
    for target in range(6):
        own = plots.target == target
        expected = plots.truth_m[own][0, :2] + plots.truth_velocity_mps[own, :2] * (
            plots.time_s[own] - plots.time_s[own][0]
        )[:, None]  # fmt: skip
        np.testing.assert_allclose(plots.truth_m[own, :2], expected, atol=1e-3)
        assert np.hypot(*plots.truth_velocity_mps[own][0, :2]) == pytest.approx(200)


@pytest.mark.parametrize("name", ["pairwise_test", "multi_radar_assignment"])
def test_moved_to_one_instant_far_more_pairs_are_found(name: str) -> None:
    algorithm, plots = algorithms_by_name()[name], simulated()
    recall = []
    for extrapolate in (False, True):
        result = algorithm.run(plots, algorithm.parameters(extrapolate=extrapolate), LocalContext())
        (found,) = (m.value for m in algorithm.measure(plots, result) if m.metric == "recall" and not m.target)
        assert found is not None
        recall.append(found)
    assert recall[0] < 0.75
    assert recall[1] > recall[0] + 0.15


def test_false_plots_and_misses_have_instants_too() -> None:
    plots = simulated(false_plots=2, detection_probability=0.8)
    assert plots.targets[-1] == "clutter"
    assert 0.1 < np.isnan(plots.range_m[plots.target < 6]).mean() < 0.3
    assert np.isfinite(plots.range_m[plots.target == 6]).all()
    assert np.isfinite(plots.time_s).all()


def test_nameless_plots_with_misses_and_false_ones_find_each_other() -> None:
    """Many have no track that tells a velocity: they are as uncertain as the others fly, and are found all the same.

    The search for a disagreement of the radars looks at some of the plots that were moved.
    """
    plots = simulated(looks=20, targets=12, detection_probability=0.9, false_plots=3)
    nameless = replace(plots, target=np.zeros(len(plots), np.int64), targets=("",))
    algorithm = algorithms_by_name()["assignment"]
    told = {"detection_probability": 0.9, "clutter_per_radar": 3.0, "region_area_m2": 1.6e9}
    result = algorithm.run(nameless, algorithm.parameters(extrapolate=True, **told), LocalContext())
    found = {m.metric: m.value for m in algorithm.measure(plots, result) if not m.target}
    assert found["recall"] is not None
    assert found["precision"] is not None
    assert found["recall"] > 0.8
    assert found["precision"] > 0.95


@pytest.mark.slow
def test_false_plots_with_names_run_through() -> None:
    plots = simulated(targets=6, looks=20, detection_probability=0.8, false_plots=3)
    algorithm = algorithms_by_name()["assignment"]
    result = algorithm.run(plots, algorithm.parameters(extrapolate=True), LocalContext())
    assert any(note.code == "moved_to_one_instant" for note in result.notes)


@pytest.mark.parametrize("name", ["assignment", "pairwise_test"])
def test_fused_positions_are_as_uncertain_as_they_say(name: str) -> None:
    """Also where the plot that gives a set its number has no track that tells a velocity."""
    plots = simulated(looks=20, targets=12, detection_probability=0.9, false_plots=3)
    nameless = replace(plots, target=np.zeros(len(plots), np.int64), targets=("",))
    algorithm = algorithms_by_name()[name]
    result = algorithm.run(nameless, algorithm.parameters(extrapolate=True), LocalContext())
    group = result.arrays["group"][:, 0]
    first = np.flatnonzero(group == plots.row)
    one = [np.unique(plots.target[group == number]).size == 1 for number in group[first]]
    first = first[np.array(one) & (plots.target[first] < 12)]
    assert first.size > 100
    error = result.arrays["fused_m"][first, :, 0] - truth_at(plots, result.arrays["instant_s"])[first]
    xx, yy, xy = result.arrays["fused_covariance_m2"][first, :, 0].T
    nees = (yy * error[:, 0] ** 2 - 2 * xy * error[:, 0] * error[:, 1] + xx * error[:, 1] ** 2) / (xx * yy - xy * xy)
    assert 1.0 < nees.mean() < 3.0
    states = algorithm.tabulate(nameless, result)["states"]
    np.testing.assert_array_equal(states.columns["time_s"], result.arrays["instant_s"][group == plots.row])


def test_where_a_target_is_at_another_instant() -> None:
    plots = simulated()
    exact = plots.truth_m[:, :2] + 3.0 * plots.truth_velocity_mps[:, :2]
    np.testing.assert_allclose(truth_at(plots, plots.time_s + 3.0), exact)
    without = replace(plots, truth_velocity_mps=np.full_like(plots.truth_velocity_mps, np.nan))
    np.testing.assert_array_equal(truth_at(without, plots.time_s), plots.truth_m[:, :2])
    between = truth_at(without, plots.time_s + 3.0)
    known = np.isfinite(between).all(axis=1)
    # Behind the last plot of a target nobody knows.
    assert 0 < (~known).sum() < 2 * 6 * 2
    np.testing.assert_allclose(between[known], exact[known], atol=1e-3)
