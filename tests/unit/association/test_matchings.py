"""Matchings and their probabilities against a listing of all matchings."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pytest
from scipy.special import logsumexp

from algorithms.toolbox.association.assignment import most_likely_matching
from algorithms.toolbox.association.exact import exact_probabilities
from algorithms.toolbox.association.probabilities import association_probabilities, linked_groups
from algorithms.toolbox.association.ranked import ranked_matchings

SHAPES = [(1, 1), (2, 2), (3, 5), (5, 3), (4, 4)]


def matchings(n: int, m: int, taken: frozenset[int] = frozenset()) -> Iterator[tuple[int, ...]]:
    """Every matching as the columns of the rows, -1 = none."""
    if n == 0:
        yield ()
        return
    for column in (-1, *(j for j in range(m) if j not in taken)):
        for rest in matchings(n - 1, m, taken if column < 0 else taken | {column}):
            yield (column, *rest)


def listed(score: np.ndarray, *, complete: bool = False) -> tuple[list[tuple[int, ...]], np.ndarray]:
    n, m = score.shape
    found = [c for c in matchings(n, m) if not complete or sum(j >= 0 for j in c) == min(n, m)]
    return found, np.array([sum(score[i, j] for i, j in enumerate(c) if j >= 0) for c in found])


def by_listing(score: np.ndarray, *, complete: bool = False) -> tuple[np.ndarray, float]:
    found, total = listed(score, complete=complete)
    everything = float(logsumexp(total))
    pairs = np.zeros(score.shape)
    for columns, value in zip(found, total, strict=True):
        for i, j in enumerate(columns):
            if j >= 0:
                pairs[i, j] += np.exp(value - everything)
    return pairs, everything


def scores(shape: tuple[int, int], seed: int, *, gated: bool) -> np.ndarray:
    rng = np.random.default_rng(seed)
    score = rng.normal(0.0, 4.0, shape)
    if gated:
        score[rng.random(shape) < 0.4] = -np.inf
    return score


@pytest.mark.parametrize("gated", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_exact_sum_is_the_listed_one(shape: tuple[int, int], gated: bool) -> None:
    for seed in range(5):
        score = scores(shape, seed, gated=gated)
        pairs, total = exact_probabilities(score)
        expected, everything = by_listing(score)
        assert pairs == pytest.approx(expected, abs=1e-12)
        assert total == pytest.approx(everything, abs=1e-12)
        assert (pairs[score == -np.inf] == 0).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_complete_case_is_the_listed_one(shape: tuple[int, int]) -> None:
    score = scores(shape, 9, gated=False)
    pairs, _ = exact_probabilities(score, complete=True)
    assert pairs == pytest.approx(by_listing(score, complete=True)[0], abs=1e-12)
    # The shorter side has a partner for certain.
    assert pairs.sum(axis=int(shape[0] <= shape[1])) == pytest.approx(1.0)


def test_a_complete_matching_that_cannot_be_has_no_probabilities() -> None:
    score = np.array([[1.0, -np.inf], [2.0, -np.inf]])
    pairs, total = exact_probabilities(score, complete=True)
    assert total == -np.inf
    assert np.isnan(pairs).all()


def test_trials_side_by_side_are_the_same_as_one_by_one() -> None:
    score = np.random.default_rng(2).normal(0, 3, (3, 4, 6))
    together, _ = exact_probabilities(score)
    for trial in range(6):
        assert (together[..., trial] == exact_probabilities(score[..., trial])[0]).all()


def test_scores_of_hundreds_neither_overflow_nor_vanish() -> None:
    pairs, total = exact_probabilities(np.array([[900.0, 899.0], [-900.0, -2000.0]]))
    assert pairs == pytest.approx(np.array([[1 / (1 + np.exp(-1)), 1 / (1 + np.exp(1))], [0, 0]]), abs=1e-12)
    assert total == pytest.approx(900 + np.log1p(np.exp(-1)))


def test_a_tie_is_half_and_half() -> None:
    pairs, _ = exact_probabilities(np.full((2, 2), 30.0), complete=True)
    assert pairs == pytest.approx(np.full((2, 2), 0.5))


@pytest.mark.parametrize("gated", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_most_likely_matching_is_the_listed_one(shape: tuple[int, int], gated: bool) -> None:
    for seed in range(5):
        score = scores(shape, seed, gated=gated)
        found, total = listed(score)
        assert tuple(most_likely_matching(score)) == found[int(np.argmax(total))]
    full = scores(shape, 3, gated=False)
    found, total = listed(full, complete=True)
    assert tuple(most_likely_matching(full, complete=True)) == found[int(np.argmax(total))]


@pytest.mark.parametrize("shape", [(0, 0), (0, 3), (3, 0)])
def test_an_empty_side_leaves_all_alone(shape: tuple[int, int]) -> None:
    score = np.zeros(shape)
    assert (most_likely_matching(score) == -1).all()
    found = association_probabilities(score)
    assert found.pairs.shape == shape
    assert (found.row_alone == 1).all()
    assert (found.column_alone == 1).all()
    assert exact_probabilities(score)[1] == 0


@pytest.mark.parametrize("gated", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_ranked_matchings_are_all_of_them_in_order(shape: tuple[int, int], gated: bool) -> None:
    score = scores(shape, 4, gated=gated)
    _, total = listed(score)
    possible = np.sort(total[total > -np.inf])[::-1]
    ranked = ranked_matchings(score, limit=10_000, negligible=0.0)
    assert ranked.log_likelihood == pytest.approx(possible, abs=1e-10)
    assert len({tuple(c) for c in ranked.columns}) == possible.size
    assert ranked.truncation == 0


@pytest.mark.parametrize("limit", [1, 3, 10, 60])
def test_what_is_left_out_is_never_more_than_stated(limit: int) -> None:
    for seed in range(4):
        score = scores((5, 4), seed, gated=False) / 3
        _, total = listed(score)
        ranked = ranked_matchings(score, limit, negligible=0.0)
        missing = 1 - np.exp(logsumexp(ranked.log_likelihood) - logsumexp(total))
        assert 0 < missing <= ranked.truncation < 1
        found = association_probabilities(score, exact_columns=2, ranked=limit)
        assert found.ranked_groups == 1
        assert np.abs(found.pairs - by_listing(score)[0]).max() <= found.truncation + 1e-9


def test_groups_have_nothing_to_do_with_each_other() -> None:
    score = np.full((5, 6), -np.inf)
    score[np.ix_([0, 3], [1, 5])] = scores((2, 2), 1, gated=False)
    score[np.ix_([1, 2], [0, 2, 3])] = scores((2, 3), 2, gated=False)
    groups = {(tuple(r.tolist()), tuple(c.tolist())) for r, c in linked_groups(score)}
    assert groups == {((0, 3), (1, 5)), ((1, 2), (0, 2, 3))}
    found = association_probabilities(score)
    assert found.pairs == pytest.approx(by_listing(score)[0], abs=1e-12)
    assert (found.groups, found.ranked_groups, found.truncation) == (2, 0, 0.0)
    assert found.row_alone[4] == 1
    assert found.column_alone[4] == 1


def test_a_large_group_is_ranked_and_close_to_the_exact_sum() -> None:
    score = np.random.default_rng(8).normal(-3.0, 2.0, (12, 12)) + 12 * np.eye(12)
    exact, _ = exact_probabilities(score)
    found = association_probabilities(score, exact_columns=5, ranked=150)
    assert found.ranked_groups == 1
    assert np.abs(found.pairs - exact).max() <= found.truncation < 0.05


@pytest.mark.slow
def test_two_hundred_by_two_hundred_in_a_second() -> None:
    rng = np.random.default_rng(1)
    place = rng.uniform(0, 300, (200, 2))
    seen = place + rng.normal(0, 0.5, (200, 2))
    distance = ((place[:, None] - seen[None]) ** 2).sum(axis=2)
    score = np.where(distance < 60, 9 - distance, -np.inf)
    begun = time.perf_counter()
    found = association_probabilities(score)
    assert time.perf_counter() - begun < 1.0
    assert found.ranked_groups == 0
    assert found.groups > 30


def test_large_scores_and_small_ones_are_summed_the_same_way() -> None:
    """Likelihoods are multiplied where numbers reach that far, and their logarithms added where they do not."""
    score = scores((5, 4), 8, gated=True)
    # With a column that one row alone may and will take, and nobody else: the others' probabilities stay.
    certain = np.full((6, 5), -np.inf)
    certain[:5, :4], certain[5, 4] = score, 700.0
    plain, total = exact_probabilities(score)
    pairs, larger = exact_probabilities(certain)
    np.testing.assert_allclose(pairs[:5, :4], plain, rtol=1e-12, atol=1e-15)
    assert pairs[5, 4] == pytest.approx(1.0)
    assert larger - total == pytest.approx(700.0)
    both, _ = exact_probabilities(np.stack([certain, np.where(certain == 700.0, 7.0, certain)], axis=-1))
    assert (both[..., 0] == pairs).all()
    assert both[5, 4, 1] == pytest.approx(1 / (1 + np.exp(-7.0)))
