"""Arrays of an outcome travel with every piece of memory once, and come back as they were."""

from __future__ import annotations

import pickle

import numpy as np

from algorithms.result import Metric, Table
from backend.jobs.bundle import Bundle
from backend.jobs.outcome import Outcome, block_arrays


def test_views_of_one_memory_are_sent_once() -> None:
    state = np.arange(60.0).reshape(10, 6, 1)
    columns = [state[:, k, 0] for k in range(6)]
    bundle = Bundle.of([state, *columns, state])
    assert [piece.nbytes for piece in bundle.memory] == [state.nbytes]
    found = bundle.arrays()
    for array, again in zip([state, *columns, state], found, strict=True):
        np.testing.assert_array_equal(again, array)
        assert again.dtype == array.dtype


def test_a_small_piece_of_a_large_memory_is_copied() -> None:
    large = np.arange(1000.0)
    bundle = Bundle.of([large[5:8]])
    assert [piece.nbytes for piece in bundle.memory] == [24]
    np.testing.assert_array_equal(bundle.arrays()[0], [5.0, 6.0, 7.0])
    # The same view twice does not make it larger.
    assert sum(piece.nbytes for piece in Bundle.of([large[:300]] * 4).memory) == 4 * 2400


def test_any_order_type_and_shape_comes_back() -> None:
    base = np.arange(24, dtype=np.int32).reshape(4, 6)
    nobody = np.empty(0, np.int64)
    given = [
        np.asfortranarray(base),
        base[:, ::2],
        base.T,
        base[::-1],
        np.array(3.5),
        np.empty((0, 3)),
        *np.zeros((5, 3, 1))[nobody, :, nobody].reshape(-1, 3).T,
        base[4:, 2],
        np.array([True, False]),
        np.frombuffer(b"read only", np.uint8),
        base.astype(">i4"),
    ]
    bundle = pickle.loads(pickle.dumps(Bundle.of(given), protocol=5))
    for array, again in zip(given, bundle.arrays(), strict=True):
        assert again.shape == array.shape
        assert again.dtype == array.dtype
        np.testing.assert_array_equal(again, array)


def test_an_outcome_is_the_same_after_its_way() -> None:
    state = np.arange(20.0).reshape(5, 4)
    row = np.arange(1, 6)
    outcome = Outcome(
        "done",
        arrays={"state": state, "row": row},
        tables={
            "states": Table({"east_m": state[:, 0], "row": row, "status": ["a", None, "a", "b", "a"]}),
            "errors": Table({"row": row, "error": state[:, 2] * 2}),
            "none": Table({}),
        },
        metrics=(Metric("rms", 1.5, "m", 5),),
        settings={"gain": {"value": 2, "source": "run"}},
        seconds=0.25,
        software={"numpy": "2"},
    )
    buffers: list[pickle.PickleBuffer] = []
    sent = pickle.dumps(outcome, protocol=5, buffer_callback=buffers.append)
    assert sum(buffer.raw().nbytes for buffer in buffers) == state.nbytes + row.nbytes + 5 * 8 + 5 * 4
    again: Outcome = pickle.loads(sent, buffers=buffers)
    before, after = block_arrays(outcome), block_arrays(again)
    assert list(before) == list(after)
    for name, array in before.items():
        assert np.ascontiguousarray(array).tobytes() == np.ascontiguousarray(after[name]).tobytes(), name
    assert again.tables["states"].columns["status"] == ["a", None, "a", "b", "a"]
    failed = pickle.loads(pickle.dumps(Outcome("failed", error={"code": "internal"}, trace="t")))
    assert failed == Outcome("failed", error={"code": "internal"}, trace="t")
