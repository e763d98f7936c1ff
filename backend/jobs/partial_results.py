"""What a Monte Carlo run that is still under way can say already: statistics of the trials that have been stored.

Blocks are added as they are found and kept in memory while the run is looked at, so a look costs as much as is new. The
finished result is composed anew, in the order of the trials; it may differ from the last look in the last digits.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from algorithms.result import Table
from algorithms.toolbox.monte_carlo.running import Running
from backend.db import outcomes, runs
from backend.db.engine import Database
from backend.files.store import Store
from backend.jobs import results, trial_results
from backend.jobs.gathering import bounds_in, sums_in
from backend.jobs.plan import TrialsPlan, plan_of

# Runs whose statistics are kept between two looks.
KEPT_RUNS = 4


@dataclass
class PartialRun:
    """Statistics of the finished blocks of a live run."""

    plan: TrialsPlan
    statistics: dict[int, Running] = field(default_factory=dict)
    bounds: dict[tuple[int, int], NDArray[Any]] = field(default_factory=dict)
    added: set[int] = field(default_factory=set)
    first: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """Arrays of the recording of the first trial, in which charts find the truth."""
    lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def version(self) -> str:
        """Changes with every block."""
        return str(len(self.added))

    def table(self, name: str) -> Table | None:
        """Table `curves`, `metrics`, `comparisons` or `consistency`; None for any other."""
        with self.lock:
            if name == "curves":
                return trial_results.curves_of(self.plan, self.statistics, self.bounds)
            metrics = trial_results.measured(self.plan, self.statistics, quantiles=False)
            found = {t.name: t for t in trial_results.small_tables(self.plan, self.statistics, metrics)}
        return results.table_of_stored(found[name]) if name in found else None


_kept: OrderedDict[str, PartialRun] = OrderedDict()
_guard = threading.Lock()


def partial_run(database: Database, store: Store, run: runs.Run) -> PartialRun | None:
    """Return the statistics of a running Monte Carlo run; None where its first block is not finished, or it is none."""
    if run.is_final or "scenario" not in run.source:
        return None
    with database.read() as connection:
        blobs = outcomes.finished_blocks(connection, run.id)
    # Another block may be there before it; without the first trial no chart knows the truth.
    if 0 not in blobs:
        return None
    with _guard:
        kept = _kept.pop(run.id, None)
        if kept is None:
            plan = plan_of(run)
            assert isinstance(plan, TrialsPlan)
            kept = PartialRun(plan)
        _kept[run.id] = kept
        while len(_kept) > KEPT_RUNS:
            _kept.popitem(last=False)
    with kept.lock:
        for position in sorted(set(blobs) - kept.added):
            _add(kept, position, store.get_arrays(blobs[position]))
    return kept


def _add(kept: PartialRun, position: int, arrays: Mapping[str, NDArray[Any]]) -> None:
    cell, _ = kept.plan.place_of(position)
    running = kept.statistics.setdefault(cell.index, Running(len(kept.plan.variants), samples=False))
    running.add(sums_in(arrays, len(kept.plan.variants)))
    kept.bounds |= {(cell.index, k): bound for k, bound in bounds_in(arrays).items()}
    if position == 0:
        kept.first = {
            name.removeprefix("array/recording/"): arrays[name]
            for name in arrays
            if name.startswith("array/recording/")
        }
    kept.added.add(position)
