from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from algorithms.toolbox.association.sparse import most_pairs_at_least_cost, pairs_within


def test_the_specification_s_example_needs_the_dearer_first_pair() -> None:
    """Nearest first would pair (0, 0) alone."""
    chosen = most_pairs_at_least_cost(
        np.array([0, 0, 1]), np.array([0, 1, 0]), np.array([-2.25574, -2.07241, -0.86528])
    )
    assert chosen.tolist() == [1, 2]


@pytest.mark.parametrize("seed", range(30))
def test_against_every_possible_matching(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = rng.integers(1, 5, 2).tolist()
    track, plot = np.nonzero(rng.random((n, m)) < 0.6)
    cost = rng.normal(0, 3, track.size)
    chosen = most_pairs_at_least_cost(track, plot, cost)
    price = {(t, p): c for t, p, c in zip(track.tolist(), plot.tolist(), cost.tolist(), strict=True)}
    best = (0, 0.0)
    for columns in permutations([*range(m), *[None] * n], n):
        pairs = [(t, p) for t, p in enumerate(columns) if (t, p) in price]
        best = min(best, (-len(pairs), sum(price[pair] for pair in pairs)))
    assert len(set(track[chosen])) == len(set(plot[chosen])) == chosen.size
    assert (-chosen.size, float(cost[chosen].sum())) == pytest.approx(best)


def test_nothing_to_pair() -> None:
    empty = np.empty(0, np.int64)
    assert most_pairs_at_least_cost(empty, empty, np.empty(0)).size == 0
    assert pairs_within(empty, np.empty(0), np.empty(0), empty, np.empty(0))[0].size == 0


def test_pairs_of_one_group_in_an_interval() -> None:
    rng = np.random.default_rng(1)
    plot_group = np.sort(rng.integers(0, 4, 60))
    plot_value = rng.uniform(0, 10, 60)
    order = np.lexsort((plot_value, plot_group))
    plot_group, plot_value = plot_group[order], plot_value[order]
    group, low = rng.integers(0, 5, 20), rng.uniform(0, 10, 20)
    high = low + rng.uniform(-1, 4, 20)
    found = set(zip(*(a.tolist() for a in pairs_within(group, low, high, plot_group, plot_value)), strict=True))
    assert found == {
        (t, p) for t in range(20) for p in range(60) if group[t] == plot_group[p] and low[t] <= plot_value[p] <= high[t]
    }


@pytest.mark.parametrize("seed", range(5))
def test_many_clusters_are_chosen_as_they_would_be_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    of, row, column = (rng.integers(0, n, 300) for n in (40, 4, 4))
    track, plot = np.unique(np.stack([4 * of + row, 4 * ((of + 7) % 40) + column]), axis=1)
    cost = rng.normal(0, 3, track.size)
    chosen = most_pairs_at_least_cost(track, plot, cost)
    alone = [np.flatnonzero(track // 4 == k) for k in range(40)]
    expected = [mine[most_pairs_at_least_cost(track[mine], plot[mine], cost[mine])] for mine in alone]
    assert chosen.tolist() == sorted(np.concatenate(expected).tolist())
