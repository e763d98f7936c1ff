"""Order statistics found in buckets are those of the sorted values, whatever the values are."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from algorithms.toolbox.monte_carlo.order import SORTED, Ordered

SIZE = SORTED + 1
SHAPES = {
    "errors": lambda draw: draw.rayleigh(100, SIZE),
    "both signs": lambda draw: draw.standard_normal(SIZE) * 10.0 ** draw.integers(-30, 30, SIZE),
    "all alike": lambda draw: np.full(SIZE, -7.25),
    "two values": lambda draw: draw.integers(0, 2, SIZE) * 3.0 - 1.0,
    "nothing and its negative": lambda draw: draw.integers(0, 2, SIZE) * -0.0,
}


@pytest.mark.parametrize("shape", SHAPES)
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0, 1))
def test_ranks_and_quantiles_of_many_values(shape: str, seed: int, share: float) -> None:
    values = SHAPES[shape](np.random.default_rng(seed)).astype(np.float32)
    ordered, whole = Ordered(values), np.sort(values)
    rank = int(share * (SIZE - 1))
    assert ordered.at(rank) == whole[rank]
    assert ordered.quantile(share) == pytest.approx(np.quantile(whole.astype(float), share), rel=1e-6)


@given(st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=1))
def test_few_values_are_sorted(values: list[float]) -> None:
    ordered = Ordered(np.array(values, np.float32))
    assert [ordered.at(k) for k in range(len(values))] == sorted(values)


def test_few_and_many_values_go_different_ways() -> None:
    assert Ordered(np.zeros(SORTED, np.float32))._keys.size == 0
    assert Ordered(np.zeros(SORTED + 1, np.float32))._keys.size == SORTED + 1
