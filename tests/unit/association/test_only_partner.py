from __future__ import annotations

import numpy as np

from algorithms.toolbox.association.only_partner import NOBODY, SEVERAL, only_partners


def test_exactly_one_inside_is_a_decision() -> None:
    statistic = np.array([[1.0, 20.0, np.nan], [20.0, 9.0, 8.0], [10.0, 30.0, 40.0], [50.0, 60.0, 9.21]])
    assert only_partners(statistic, 9.21).tolist() == [0, SEVERAL, NOBODY, 2]


def test_trials_side_by_side_and_an_empty_other_side() -> None:
    statistic = np.random.default_rng(1).exponential(8.0, (3, 4, 5))
    together = only_partners(statistic, 9.21)
    assert together.shape == (3, 5)
    for trial in range(5):
        assert (together[:, trial] == only_partners(statistic[..., trial], 9.21)).all()
    assert only_partners(np.empty((3, 0)), 9.21).tolist() == [NOBODY] * 3
