"""Probabilities of sets of plots against a listing of all choices of disjoint sets."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from algorithms.toolbox.association.exact import exact_probabilities
from algorithms.toolbox.association.packings import packing_probabilities

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def listed(members: Ints, scores: Floats) -> Floats:
    """Add up every choice one by one."""
    share, total = np.zeros(len(scores)), 0.0
    for chosen in product((False, True), repeat=len(scores)):
        taken = members[list(chosen)]
        taken = taken[taken >= 0]
        if np.unique(taken).size < taken.size:
            continue
        weight = float(np.exp(scores[list(chosen)].sum()))
        total += weight
        share[list(chosen)] += weight
    return share / total


@pytest.mark.parametrize("seed", range(8))
def test_the_sweep_is_the_listing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sets = np.stack([rng.integers(-1, 3, 12), rng.integers(3, 6, 12), np.where(rng.random(12) < 0.4, -1,
                     rng.integers(6, 9, 12))], axis=1)  # fmt: skip
    scores = rng.normal(0.5, 2.0, 12)
    assert packing_probabilities(sets, scores, 9) == pytest.approx(listed(sets, scores), abs=1e-12)


def test_sets_of_two_are_pairs() -> None:
    rng = np.random.default_rng(4)
    score = rng.normal(0.0, 3.0, (5, 6))
    pairs = np.array([(i, 5 + j) for i in range(5) for j in range(6)])
    found = packing_probabilities(pairs, score.ravel(), 11)
    assert found.reshape(5, 6) == pytest.approx(exact_probabilities(score[:, :, None])[0][:, :, 0], abs=1e-12)


def test_scores_of_thousands_neither_overflow_nor_vanish() -> None:
    members = np.array([[0, 1], [0, 2], [3, 4]])
    found = packing_probabilities(members, np.array([2000.0, 2000.0 + np.log(3.0), -2000.0]), 5)
    assert found == pytest.approx([0.25, 0.75, 0.0], abs=1e-12)


def test_a_group_that_is_too_large_is_left_out_and_the_others_are_summed() -> None:
    rng = np.random.default_rng(6)
    dense = np.array([(i, 6 + j) for i in range(6) for j in range(6)])
    members = np.concatenate([dense, [[12, 13]]])
    found = packing_probabilities(members, np.append(rng.normal(size=36), 0.0), 14, most_steps=100)
    assert np.isnan(found[:36]).all()
    assert found[36] == pytest.approx(0.5)


def test_nothing_to_sum() -> None:
    assert packing_probabilities(np.empty((0, 3), np.int64), np.empty(0), 4).size == 0
