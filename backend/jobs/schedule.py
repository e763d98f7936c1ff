"""Which block is computed next: the engine's memory of live runs, without Dask and without a database."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from backend.db.runs import Run
from backend.jobs.plan import Plan

if TYPE_CHECKING:
    from backend.jobs.gathering import Gathering

# A block that ended with its worker is sent again this often.
RETRIES = 2


@dataclass
class ActiveRun:
    """A live run: which of its blocks (by position) wait, and how far the ones under way are."""

    run: Run
    plan: Plan
    waiting: deque[int]
    finished: set[int]
    deaths: dict[int, int] = field(default_factory=dict)
    """Position -> how many workers died while they computed it."""
    shares: dict[int, float] = field(default_factory=dict)
    reported: int = -1
    reported_at: float = 0.0
    gathering: Gathering | None = None
    """Statistics of the blocks of simulated trials that came back so far; None where nobody keeps them."""
    told: str = ""
    """Why it waits, as its log says."""

    @property
    def done(self) -> int:
        """Work that is done, of the run's `progress_total`; all blocks count alike."""
        under_way = sum(share for position, share in self.shares.items() if position not in self.finished)
        return int(self.run.progress_total * (len(self.finished) + under_way) / self.plan.size)

    @property
    def is_complete(self) -> bool:
        """Whether all blocks are finished."""
        return len(self.finished) == self.plan.size


@dataclass
class Flight:
    """A block that a worker computes."""

    token: str
    run_id: str
    position: int
    worker: str
    future: Any
    alone: bool
    output: Path | None = None
    """Where the worker writes the run's result; nobody needs the file if it is not fetched."""
    missing_since: float | None = None
    """When the worker was first not there any more."""
    stopping_since: float | None = None
    """When the workers were told to leave this block."""
    restarting: bool = False
    outcome: Any = None
    """What came back and is not stored yet; None while it was not fetched."""


@dataclass(frozen=True)
class Choice:
    """A block to send, and whether nothing else may be under way beside it."""

    active: ActiveRun
    position: int
    alone: bool


def choose(active_runs: Collection[ActiveRun], flights: Collection[Flight]) -> Choice | None:
    """Return the next block: of the run with the fewest blocks under way, among these the oldest.

    A run of many long blocks thus leaves room for one that comes later, and still goes on itself. A block whose
    worker died is suspected of having killed it: it is sent alone, after everything else has landed, so that no
    innocent block falls with it.
    """
    if any(flight.alone for flight in flights):
        return None
    suspects = [(a, p) for a in active_runs for p in a.waiting if a.deaths.get(p)]
    if suspects:
        return None if flights else Choice(*suspects[0], alone=True)
    under_way: dict[str, int] = {}
    for flight in flights:
        under_way[flight.run_id] = under_way.get(flight.run_id, 0) + 1
    candidates = [a for a in active_runs if a.waiting]
    if not candidates:
        return None
    first = min(candidates, key=lambda a: (under_way.get(a.run.id, 0), a.run.created_at, a.run.id))
    return Choice(first, first.waiting[0], alone=False)


def monotonic() -> float:
    """Return the seconds of a clock that nobody sets."""
    return time.monotonic()
