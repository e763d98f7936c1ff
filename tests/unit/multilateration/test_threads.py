"""Targets of a long recording are filtered in threads beside each other: the bytes are those of one thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from algorithms.errors import RunCancelled
from algorithms.multilateration import tracker
from algorithms.multilateration.blocks import Block, run_beside
from algorithms.multilateration.rdfv import ALGORITHM
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels import LANES

AIRCRAFT = 2 * LANES + 5


def many_aircraft(marks: int = 60) -> ToaMarks:
    """Aircraft on the circuit at the same instants, each with noise of its own."""
    one = simulate(CircuitParameters(), tuple(range(AIRCRAFT)), 1)
    rows = np.repeat(np.arange(marks), AIRCRAFT)
    aircraft = np.tile(np.arange(AIRCRAFT), marks)
    return replace(
        one,
        time_s=one.time_s[rows],
        row=np.arange(1, rows.size + 1),
        target=aircraft,
        targets=tuple(f"aircraft {i}" for i in range(AIRCRAFT)),
        truth_m=one.truth_m[rows],
        truth_velocity_mps=one.truth_velocity_mps[rows],
        toa_s=one.toa_s[rows, :, aircraft][:, :, None],
        altitude_m=one.altitude_m[rows, aircraft][:, None],
        emitter_type=np.full(rows.size, -1),
    )


def test_the_bytes_do_not_depend_on_the_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    recording = many_aircraft()
    used: list[int] = []

    def counted(run: Callable[[Iterator[Block]], None], blocks: Sequence[Block], *, threads: int) -> None:
        used.append(threads)
        run_beside(run, blocks, threads=threads)

    monkeypatch.setattr(tracker, "run_beside", counted)
    beside = ALGORITHM.run(recording, ALGORITHM.parameters(), LocalContext(seed=1))
    monkeypatch.setattr(tracker, "run_beside", lambda run, blocks, threads: run(iter(blocks)))
    one = ALGORITHM.run(recording, ALGORITHM.parameters(), LocalContext(seed=1))
    assert used == [2]
    assert {n: np.asarray(a).tobytes() for n, a in beside.arrays.items()} == {
        n: np.asarray(a).tobytes() for n, a in one.arrays.items()
    }
    assert np.isfinite(np.asarray(beside.arrays["state"])).any()


def test_each_block_is_run_once_and_an_error_is_told() -> None:
    blocks: list[Block] = list(range(100))  # type: ignore[arg-type]  # any things
    done: list[Block] = []
    run_beside(lambda mine: done.extend(mine), blocks, threads=2)
    assert sorted(done) == blocks  # type: ignore[type-var]

    def stop(mine: Iterator[Block]) -> None:
        for _ in mine:
            raise RunCancelled

    with pytest.raises(RunCancelled):
        run_beside(stop, blocks, threads=2)
