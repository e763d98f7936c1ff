"""The runs that are not final: how they are taken up, begin, succeed, fail and are left.

Only the engine's thread comes here. What must survive is in the database before anything goes on.
"""

from __future__ import annotations

import logging
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from numpy.typing import NDArray

from algorithms.errors import FilterRoomError
from backend.db import events, outcomes, runs
from backend.db.engine import Database
from backend.errors import STORAGE_CODES, UnavailableError
from backend.files.store import Store
from backend.jobs import ledger
from backend.jobs.collection import collect
from backend.jobs.outcome import Outcome
from backend.jobs.plan import RecordingPlan, TrialsPlan, plan_of
from backend.jobs.schedule import ActiveRun, monotonic

logger = logging.getLogger(__name__)

# Seconds between two stored progresses of a run.
PROGRESS_S = 0.25
# Monte Carlo runs whose statistics are kept in memory while their blocks come in.
GATHERED_RUNS = 2


class LiveRuns:
    """Runs by their id; `leave` stops what is under way for a run that ended."""

    def __init__(self, database: Database, store: Store, leave: Callable[[str], None]) -> None:
        self._database = database
        self._store = store
        self._leave = leave
        self.active: dict[str, ActiveRun] = {}
        # Runs that failed and whose failure is not in the database yet: error and trace.
        self._failures: dict[str, tuple[dict[str, Any], str]] = {}

    def take_up(self) -> None:
        """Take up what is queued or running in the database and not known yet."""
        with self._database.read() as connection:
            for run in runs.live_runs(connection):
                if run.id not in self.active and run.id not in self._failures:
                    done = set(outcomes.finished_blocks(connection, run.id))
                    plan = plan_of(run)
                    waiting = deque(p for p in range(plan.size) if p not in done)
                    self.active[run.id] = ActiveRun(run, plan, waiting, done)

    def begin(self, active: ActiveRun) -> bool:
        """Make a queued run a running one; False where it was cancelled or deleted meanwhile."""
        if active.run.state == "running":
            return True
        begun = ledger.begin(self._database, active.run, active.plan, len(active.finished))
        if begun is None:
            self.drop(active.run.id)
            return False
        active.run = begun
        return True

    def finish_complete(self) -> None:
        """Compose the results of runs whose blocks are all finished.

        A run whose last block was stored just before the server died has nothing left to send.
        """
        for active in [a for a in self.active.values() if a.is_complete]:
            if self.begin(active):
                with self.failing(active):
                    ledger.finish(self._database, self._store, active.run, active.plan, active.gathering)
                    self.active.pop(active.run.id, None)

    def finish_with(self, active: ActiveRun, position: int, outcome: Outcome) -> bool:
        """Compose the result of a run on recordings whose last algorithm has come back; False where others are missing.

        To store it for itself first would write a long result twice.
        """
        if not isinstance(active.plan, RecordingPlan) or len(active.finished) + 1 < active.plan.size:
            return False
        ledger.finish(self._database, self._store, active.run, active.plan, last=(position, outcome))
        self.active.pop(active.run.id, None)
        return True

    def gather(self, active: ActiveRun, position: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Add a stored block to the statistics of its run; a third run is gathered from the disk at its end."""
        if not isinstance(active.plan, TrialsPlan):
            return
        if active.gathering is None:
            if sum(a.gathering is not None for a in self.active.values()) >= GATHERED_RUNS:
                return
            # Its statistics need scipy, for which no server waits at its start.
            from backend.jobs.gathering import Gathering

            active.gathering = Gathering(active.plan)
        active.gathering.add(position, arrays)

    def report_progress(self) -> None:
        """Store how far runs are, not too often."""
        at = monotonic()
        for active in self.active.values():
            if active.done != active.reported and at - active.reported_at >= PROGRESS_S:
                active.reported, active.reported_at = active.done, at
                if active.run.state == "running":
                    with self._database.write() as connection:
                        runs.set_progress(connection, active.run.id, active.done)

    def tell_waiting(self, words: str) -> None:
        """Write into the logs of runs, once, why they wait."""
        for active in self.active.values():
            if active.told != words:
                with self._database.write() as connection:
                    events.append_log(connection, active.run.id, words, "warning")
                active.told = words

    @contextmanager
    def failing(self, active: ActiveRun, position: int | None = None) -> Iterator[None]:
        """Fail the run where something of ours goes wrong: it must not wait for ever.

        A database that does not answer now is not the run's fault: the error goes on, and the step is repeated.
        """
        label = "" if position is None else active.plan.label_of(position)
        try:
            yield
        except UnavailableError:
            raise
        except FilterRoomError as error:
            # Also to the server's log: where a disk is full the run's own cannot be written now.
            logger.error("run %s failed: %s", active.run.id, error)
            self.fail(active.run.id, ledger.error_of(error, label))
        except Exception:
            logger.exception("run %s failed", active.run.id)
            what = {"code": "internal", "detail": "The server could not go on.", "remedy": "Please report it."}
            self.fail(active.run.id, {**what, "label": label}, traceback.format_exc())

    def fail(self, run_id: str, error: dict[str, Any], trace: str = "") -> None:
        """Let a run fail; `store_failures` writes it down."""
        self._failures[run_id] = (error, trace)
        self.active.pop(run_id, None)
        self._leave(run_id)

    def fail_all(self, error: FilterRoomError) -> None:
        """Let every run fail: nobody is there who could compute it, and nobody will come."""
        for run_id in list(self.active):
            self.fail(run_id, ledger.error_of(error, ""))

    def store_failures(self) -> None:
        """Write failures down; where the disk is full this is tried again in every round."""
        for run_id, (error, trace) in list(self._failures.items()):
            ledger.fail(self._database, run_id, error, trace)
            ledger.forget(self._database, self._store, run_id)
            if error["code"] in STORAGE_CODES:
                # Its last file may be there without the row that refers to it.
                collect(self._database, self._store)
            del self._failures[run_id]

    def drop(self, run_id: str) -> None:
        """Leave a run that is final: stop what is under way and delete what is half done."""
        self.active.pop(run_id, None)
        self._leave(run_id)
        ledger.forget(self._database, self._store, run_id)
