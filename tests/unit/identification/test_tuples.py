"""Sets of plots of many radars: scores against those of pairs, the best choice against a listing of all choices."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from algorithms.identification import tuples as tuples_module
from algorithms.identification.pairs import Points, Side, pair_statistics, points_of
from algorithms.identification.tuples import Densities, Looked, pack
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import LocalContext
from algorithms.toolbox.association.assignment import most_likely_matching, pair_scores
from algorithms.toolbox.association.packings import packing_probabilities
from tests.unit.identification.test_bad_input import run, simulated

SITES = np.array([[0.0, 0.0], [30_000.0, 0.0], [15_000.0, 25_980.0]])
SIGMA = np.radians(1.0)
AREA = 4e8


def sides(seed: int, counts: tuple[int, ...]) -> list[Side]:
    """Plots of some targets near 106 km east and north, the last plots false ones."""
    rng = np.random.default_rng(seed)
    targets = 106_000 + 10_000 * (rng.random((max(counts), 2)) - 0.5)
    out = []
    for site, n in zip(SITES, counts, strict=False):
        offset = targets[:n] - site
        r = np.hypot(*offset.T) + 100 * rng.standard_normal(n)
        b = np.arctan2(offset[:, 1], offset[:, 0]) + SIGMA * rng.standard_normal(n)
        out.append(Side(site, r[:, None], b[:, None], 100.0, SIGMA))
    return out


def looked(found: list[Side], threshold: float = 1e9) -> Looked:
    points = [Points(*(a[:, 0] for a in points_of(s, "mucm"))) for s in found]
    return Looked(points, Densities(0.9, 5 / AREA, 2 / AREA, len(found)), threshold)


def test_for_two_radars_the_scores_are_those_of_the_pairs() -> None:
    first, second = sides(3, (4, 5))
    cost = pair_statistics(first, second, "mucm").cost[:, :, 0]
    expected = pair_scores(
        cost, detection_probability=(0.9, 0.9), target_density=5 / AREA, clutter_density=(2 / AREA, 2 / AREA)
    )
    tuples = np.array([(i, j) for i in range(4) for j in range(5)])
    scores, *_ = looked([first, second]).evaluate(tuples)
    assert scores.reshape(4, 5) == pytest.approx(expected, abs=1e-9)
    best = pack(looked([first, second]), probabilities=True)
    partner = most_likely_matching(expected)
    assert {tuple(t) for t in best.tuples} == {(i, int(j)) for i, j in enumerate(partner) if j >= 0}


@pytest.mark.parametrize("seed", range(6))
def test_the_best_choice_is_the_best_of_all(seed: int) -> None:
    one = looked(sides(seed, (3, 3, 2)))
    tuples = one.candidates(1000)
    assert tuples is not None
    assert len(tuples) == 4 * 4 * 3 - 1 - 3 - 3 - 2
    scores, *_ = one.evaluate(tuples)
    best = 0.0
    for size in (1, 2, 3, 4):
        for chosen in combinations(range(len(tuples)), size):
            taken = tuples[list(chosen)]
            if all(len(set(c[c >= 0])) == (c >= 0).sum() for c in taken.T):
                best = max(best, float(scores[list(chosen)].sum()))
    found = pack(one, probabilities=True)
    assert found.exact
    assert not found.bounded.any()
    assert found.scores.sum() == pytest.approx(best, abs=1e-9)
    # Each plot is in some set or in none.
    for radar, plots in enumerate(one.count):
        for plot in range(plots):
            assert found.listed_probability[found.listed[:, radar] == plot].sum() <= 1 + 1e-9


def test_a_bound_is_never_below_the_sum(monkeypatch: pytest.MonkeyPatch) -> None:
    one = looked(sides(5, (4, 4, 3)))
    exact = pack(one, probabilities=True)

    def nothing(members: np.ndarray, scores: np.ndarray, plots: int) -> np.ndarray:
        return packing_probabilities(members, scores, plots, most_steps=10)

    monkeypatch.setattr(tuples_module, "packing_probabilities", nothing)
    rough = pack(one, probabilities=True)
    assert rough.bounded.all()
    assert (rough.tuples == exact.tuples).all()
    assert (rough.probability >= exact.probability - 1e-9).all()
    assert (rough.probability <= 1).all()


@pytest.mark.parametrize("near", [1, 100_000])
def test_a_bound_from_nearby_choices_is_that_of_all(near: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """What stands near a set tells what lacks it; where little is looked at, the bound is the larger one."""
    monkeypatch.setattr(tuples_module, "MOST_NEAR", near)
    one = looked(sides(2, (12, 12, 11)), threshold=18.0)
    tuples = one.candidates(20_000)
    assert tuples is not None
    scores, *_ = one.evaluate(tuples)
    tuples, scores = tuples[scores > 0], scores[scores > 0]
    total, chosen = tuples_module._solve(one.count, tuples, scores)
    found = tuples_module._upper_bounds(one.count, tuples, scores, np.ones(len(tuples), np.bool_), chosen)
    for bound, c in zip(found, chosen, strict=True):
        rest = np.arange(len(tuples)) != c
        without = tuples_module._solve(one.count, tuples[rest], scores[rest])[0]
        full = 1 / (1 + np.exp(without - total))
        assert bound >= full - 1e-9
        if near > len(tuples):
            assert bound == pytest.approx(full, abs=1e-9)


def test_two_radars_state_the_probabilities_of_the_matching() -> None:
    plots = simulated(targets=6, looks=20, detection_probability=0.9, false_plots=1)
    told = {"detection_probability": 0.9, "clutter_per_radar": 1.0, "target_count": 6.0}
    sets = run(plots, "multi_radar_assignment", gate_tail=1e-9, **told)
    pairs = run(plots, "assignment", **told)
    for name in ("pair_probability", "alone_probability"):
        assert sets.arrays[name] == pytest.approx(pairs.arrays[name], abs=1e-6, nan_ok=True)
    assert (sets.arrays["pair_decision"] == pairs.arrays["pair_decision"]).mean() > 0.999


@pytest.mark.slow
def test_stated_probabilities_of_sets_are_those_that_come_true() -> None:
    plots = simulated(targets=8, looks=150, radars=3)
    result = run(plots, "multi_radar_assignment", decision="most_likely")
    group = result.arrays["group"][:, 0]
    first = np.flatnonzero((group == plots.row) & np.isfinite(result.arrays["probability"][:, 0]))
    stated = result.arrays["probability"][first, 0]
    right = np.array([
        np.unique(plots.target[group == g]).size == 1 and (group == g).sum() == 3 for g in group[first]
    ])  # fmt: skip
    assert first.size > 1000
    for low, high in ((0.0, 0.7), (0.7, 0.9), (0.9, 0.98), (0.98, 1.01)):
        some = (stated >= low) & (stated < high)
        assert some.sum() > 20
        error = 4 * np.sqrt(stated[some].mean() * (1 - stated[some].mean()) / some.sum()) + 0.01
        # Sets of the best choice: those of one look hang together, and a chosen one is a little too sure of itself.
        assert right[some].mean() == pytest.approx(stated[some].mean(), abs=error)


@pytest.mark.slow
def test_trials_keep_what_was_stated_of_sets() -> None:
    algorithm, preset = algorithms_by_name()["multi_radar_assignment"], scenarios_by_name()["two_radars_cluster"]
    trials = preset.simulate(preset.parameters(targets=8, looks=10, radars=3), tuple(range(8)), 3)
    assert algorithm.score is not None
    kept = []
    for decision in ("posterior", "most_likely"):
        scores = algorithm.score(trials, algorithm.parameters(decision=decision), LocalContext())
        stated, right = (s.values for s in scores.samples)
        assert stated.shape == right.shape == (80, 8)
        kept.append(stated)
        some = np.isfinite(stated)
        assert some.mean() > 0.95
        assert right[some].mean() == pytest.approx(stated[some].mean(), abs=0.04)
        assert right[some & (stated < 0.7)].mean() < 0.8 < right[some & (stated > 0.9)].mean()
    # What is stated does not hang on what is accepted.
    np.testing.assert_array_equal(*kept)


def test_radar_by_radar_where_there_are_too_many_sets() -> None:
    one = looked(sides(1, (4, 4, 4)))
    exact, quick = pack(one), pack(one, limit=5)
    assert exact.exact
    assert not quick.exact
    assert quick.scores.sum() <= exact.scores.sum() + 1e-9
    assert quick.scores.sum() > 0.7 * exact.scores.sum()
    for column in quick.tuples.T:
        used = column[column >= 0]
        assert len(set(used)) == used.size


def test_an_empty_radar() -> None:
    first, second, third = sides(2, (3, 3, 0))
    found = pack(looked([first, second, third]), probabilities=True)
    assert (found.tuples[:, 2] == -1).all()
    assert len(found.tuples) == 3


@pytest.mark.slow
def test_what_is_stated_of_sets_comes_true_with_misses_and_false_plots() -> None:
    """In each bin of the stated probability; without the sets that begin with a false plot 0.6 came true in 0.75."""
    algorithm, preset = algorithms_by_name()["multi_radar_assignment"], scenarios_by_name()["two_radars_cluster"]
    told = {"detection_probability": 0.9, "clutter_per_radar": 2, "region_area_m2": AREA}
    samples: dict[str, list[np.ndarray]] = {"stated_probability": [], "stated_right": []}
    for seed in range(3):
        flown = {"radars": 3, "targets": 6, "looks": 60, "detection_probability": 0.9, "false_plots": 2}
        plots = preset.simulate(preset.parameters(**flown, placement_seed=seed), (0, 1, 2, 3), seed)
        scores = algorithm.score(plots, algorithm.parameters(**told), LocalContext())
        for sample in scores.samples:
            if sample.name in samples:
                samples[sample.name].append(sample.values.ravel())
    stated, right = (np.concatenate(found) for found in samples.values())
    known = np.isfinite(stated)
    for low, high in ((0.0, 0.5), (0.5, 0.7), (0.7, 0.85), (0.85, 0.95), (0.95, 1.01)):
        chosen = known & (stated >= low) & (stated < high)
        assert chosen.sum() > 200
        assert right[chosen].mean() == pytest.approx(stated[chosen].mean(), abs=0.08)
