"""The finished blocks of a Monte Carlo run on their way to its result: added up as they come, in the trials' order.

When the last block of a cell is there its metrics and curves are computed at once, while workers still compute other
cells: little is left to do after the last block. What is gathered is in memory only; after a restart the stored blocks
are gathered anew, and come to the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.monte_carlo.running import Running
from algorithms.toolbox.monte_carlo.sums import Sums
from backend.jobs.plan import TrialsPlan

Arrays = Mapping[str, NDArray[Any]]


class Gathering:
    """Statistics of the blocks so far.

    Attributes
    ----------
    statistics : by cell
    bounds : by cell and variant
    seconds : (cells, variants) s, time of computation
    first : arrays of the first block, which hold the example
    """

    def __init__(self, plan: TrialsPlan) -> None:
        self.plan = plan
        self.statistics = {cell.index: Running(len(plan.variants)) for cell in plan.cells}
        self.bounds: dict[tuple[int, int], NDArray[Any]] = {}
        self.seconds = np.zeros((len(plan.cells), len(plan.variants)))
        self.first: Arrays = {}
        self._next = 0
        # Blocks whose predecessors are not there yet.
        self._early: dict[int, Arrays] = {}

    @property
    def missing(self) -> list[int]:
        """Positions of the blocks that were not added."""
        return [p for p in range(self._next, self.plan.size) if p not in self._early]

    def add(self, position: int, arrays: Arrays) -> None:
        """Add a block; one that was added before changes nothing."""
        if position < self._next:
            return
        self._early[position] = arrays
        while self._next in self._early:
            self._take(self._next, self._early.pop(self._next))
            self._next += 1

    def _take(self, position: int, arrays: Arrays) -> None:
        cell, _ = self.plan.place_of(position)
        running = self.statistics[cell.index]
        running.add(sums_in(arrays, len(self.plan.variants)))
        self.bounds |= {(cell.index, k): bound for k, bound in bounds_in(arrays).items()}
        self.seconds[cell.index] += arrays["array/seconds"]
        if position == 0:
            self.first = {name: arrays[name] for name in arrays}
        if position == self.plan.positions_of(cell.index)[-1]:
            running.settle()


def gathered(plan: TrialsPlan, blocks: Mapping[int, Arrays]) -> Gathering:
    """Gather blocks that are all there."""
    gathering = Gathering(plan)
    for position in range(plan.size):
        gathering.add(position, blocks[position])
    return gathering


def sums_in(arrays: Arrays, variants: int) -> list[Sums]:
    """Sums of a block, one for each variant."""
    return [Sums.from_arrays(under(arrays, f"array/{k}/")) for k in range(variants)]


def bounds_in(arrays: Arrays) -> dict[int, NDArray[Any]]:
    """Lower bounds by variant; only the first block of a cell has them."""
    return {int(name.split("/")[1]): arrays[name] for name in arrays if name.endswith("/bound")}


def under(arrays: Arrays, prefix: str) -> dict[str, NDArray[Any]]:
    """Arrays whose names begin with a prefix, without it."""
    return {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}
