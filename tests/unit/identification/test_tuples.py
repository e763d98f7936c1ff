"""Sets of plots of many radars: scores against those of pairs, the best choice against a listing of all choices."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from algorithms.identification.pairs import Points, Side, pair_statistics, points_of
from algorithms.identification.tuples import Densities, Looked, pack
from algorithms.toolbox.association.assignment import most_likely_matching, pair_scores

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
    best = pack(looked([first, second]), margins=True)
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
    found = pack(one, margins=True)
    assert found.exact
    assert found.scores.sum() == pytest.approx(best, abs=1e-9)
    # Without one of its sets the best choice is worse, or as good.
    assert (found.margin > -1e-9).all()


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
    found = pack(looked([first, second, third]), margins=True)
    assert (found.tuples[:, 2] == -1).all()
    assert len(found.tuples) == 3
