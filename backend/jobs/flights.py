"""Blocks under way: sent to a worker, landed, kept; or lost with their worker, or left because their run ended.

Only the engine's thread comes here; what Dask's threads have to say is posted to it.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections import deque
from collections.abc import Callable, Collection, Container
from typing import Any

from backend.db import events
from backend.db.engine import Database
from backend.errors import STORAGE_CODES
from backend.files.store import Store
from backend.jobs import ledger
from backend.jobs.live_runs import LiveRuns
from backend.jobs.outcome import Outcome
from backend.jobs.schedule import RETRIES, ActiveRun, Choice, Flight, monotonic
from backend.jobs.work import Block

logger = logging.getLogger(__name__)

# Seconds until a cancelled block's worker is restarted, and until a block whose worker is gone is given up.
PATIENCE_S = 1.0
MISSING_S = 3.0
# Seconds until an outcome is given up that its worker was to hand over: Dask would wait for one who is gone.
FETCH_S = 30.0


class Flights:
    """Blocks under way by their tokens; `post` hands a message to the engine's thread."""

    def __init__(
        self, database: Database, store: Store, live: LiveRuns, post: Callable[[Callable[[], None]], None]
    ) -> None:
        self._database = database
        self._store = store
        self._live = live
        self._post = post
        self._cluster: Any = None
        self._flights: dict[str, Flight] = {}
        # Finished blocks whose outcomes are not fetched and stored yet, in the order in which they came.
        self._arrived: deque[Flight] = deque()

    def use(self, cluster: Any) -> None:
        """Send to this cluster from now on."""
        self._cluster = cluster

    @property
    def under_way(self) -> Collection[Flight]:
        """Blocks that workers have."""
        return self._flights.values()

    @property
    def tokens(self) -> list[str]:
        """Names of the blocks that workers have."""
        return list(self._flights)

    def send(self, choice: Choice, worker: str) -> None:
        """Send a block to a worker."""
        active, position = choice.active, choice.position
        with self._live.failing(active, position):
            here = self._cluster.is_same_machine
            block = ledger.block_of(self._database, self._store, active.run, active.plan, position, same_machine=here)
            future = self._cluster.submit(block, worker)
            output = block.output if isinstance(block, Block) else None
            self._flights[block.token] = Flight(
                block.token, active.run.id, position, worker, future, choice.alone, output
            )
            active.waiting.remove(position)
            future.add_done_callback(lambda _: self._post(lambda: self._landed(block.token)))

    def progress(self, token: str, share: float) -> None:
        """Note how far a block is."""
        flight = self._flights.get(token)
        active = self._live.active.get(flight.run_id) if flight is not None else None
        if flight is not None and active is not None:
            active.shares[flight.position] = min(max(share, 0.0), 1.0)

    def keep_arrived(self) -> None:
        """Fetch and store what came back; what the database does not take now is tried again."""
        while self._arrived:
            flight = self._arrived[0]
            active = self._live.active.get(flight.run_id)
            if active is not None:
                with self._live.failing(active, flight.position):
                    self._keep(active, flight)
            _clear(flight)
            self._arrived.popleft()

    def _keep(self, active: ActiveRun, flight: Flight) -> None:
        if flight.outcome is None:
            flight.outcome = _fetched(flight)
        outcome, position = flight.outcome, flight.position
        if outcome is None:
            self._lost(active, flight)
        elif outcome.kind == "done":
            if not self._live.finish_with(active, position, outcome):
                arrays = ledger.keep(self._database, self._store, active.run, active.plan, position, outcome)
                active.finished.add(position)
                self._live.gather(active, position, arrays)
        elif outcome.kind == "failed":
            assert outcome.error is not None
            if outcome.error["code"] in STORAGE_CODES:
                # Where a disk is full the run's own log cannot be written now.
                logger.error("run %s failed: %s", flight.run_id, outcome.error["detail"])
            self._live.fail(flight.run_id, outcome.error, outcome.trace)
            if outcome.error["code"] == "out_of_memory":
                # What the algorithm still holds would be missing to the next block.
                self._take_back([other for other in self._flights.values() if other.worker == flight.worker])
                self._flights[flight.token] = flight
                self._restart(flight, "ran out of memory")

    def _landed(self, token: str) -> None:
        flight = self._flights.get(token)
        if flight is None or flight.restarting:
            return
        if flight.future.status != "finished" and not self._cluster.is_connected:
            # Nobody died: the scheduler went away, and all blocks are taken back together.
            return
        del self._flights[token]
        active = self._live.active.get(flight.run_id)
        if active is None or flight.stopping_since is not None:
            _clear(flight)
            return
        if flight.future.status != "finished":
            self._lost(active, flight)
            return
        # Its worker gets the next block before this one is fetched.
        self._arrived.append(flight)

    def _lost(self, active: ActiveRun, flight: Flight) -> None:
        """Send a block again whose worker died, or give the run up."""
        _clear(flight)
        position, label = flight.position, active.plan.name_of(flight.position)
        deaths = active.deaths[position] = active.deaths.get(position, 0) + 1
        active.shares.pop(position, None)
        if deaths > RETRIES:
            self._live.fail(
                active.run.id,
                {
                    "code": "worker_died",
                    "detail": f"The worker died {deaths} times while it computed {label}.",
                    "remedy": "Most often it ran out of memory: use a shorter recording or fewer workers.",
                    "label": active.plan.label_of(position),
                },
            )
            return
        active.waiting.append(position)
        with self._database.write() as connection:
            events.append_log(
                connection, active.run.id, f"{label}: the worker died; it is computed again, alone.", "warning"
            )

    def take_back(self) -> None:
        """Take back what was sent to a scheduler that went away."""
        self._take_back(list(self._flights.values()))

    def _take_back(self, flights: list[Flight]) -> None:
        """Let blocks wait again, whose worker is taken from them through no fault of theirs."""
        for flight in flights:
            _clear(flight)
            del self._flights[flight.token]
            active = self._live.active.get(flight.run_id)
            if active is not None and flight.stopping_since is None:
                active.waiting.appendleft(flight.position)
                active.shares.pop(flight.position, None)

    def leave(self, run_id: str) -> None:
        """Tell the workers to leave the blocks of a run."""
        tokens = [f.token for f in self._flights.values() if f.run_id == run_id and f.stopping_since is None]
        for token in tokens:
            self._flights[token].stopping_since = monotonic()
        if tokens:
            # In a thread of its own: a worker that hangs does not answer.
            cluster = self._cluster
            threading.Thread(target=cluster.signal_cancel, args=(tokens,), daemon=True).start()

    def look_after(self, workers: Container[str]) -> None:
        """Restart workers that do not leave a block; give up blocks whose worker is not among `workers` any more."""
        at = monotonic()
        for flight in list(self._flights.values()):
            if flight.restarting:
                continue
            if flight.stopping_since is not None and at - flight.stopping_since > PATIENCE_S:
                self._restart(flight, "does not leave a cancelled block")
            elif flight.worker in workers:
                flight.missing_since = None
            elif flight.missing_since is None:
                flight.missing_since = at
            elif at - flight.missing_since > MISSING_S and not flight.future.done():
                # Its worker went away before Dask knew of the block: it would wait for ever.
                flight.future.cancel()
                self._landed(flight.token)

    def _restart(self, flight: Flight, why: str) -> None:
        logger.warning("worker %s %s and is restarted", flight.worker, why)
        flight.restarting = True
        # Else Dask would start the block again when the worker is back.
        flight.future.cancel()
        cluster = self._cluster

        def restart() -> None:
            try:
                cluster.restart(flight.worker)
            finally:
                self._post(lambda: self._forget(flight.token))

        threading.Thread(target=restart, daemon=True).start()

    def _forget(self, token: str) -> None:
        flight = self._flights.pop(token, None)
        if flight is not None:
            _clear(flight)


def _clear(flight: Flight) -> None:
    """Delete what a worker may have written for a run that did not take it; else the store has moved it."""
    if flight.output is not None:
        # A disk that takes no changes does not take this one; the next server clears up.
        with contextlib.suppress(OSError):
            flight.output.unlink(missing_ok=True)


def _fetched(flight: Flight) -> Outcome | None:
    """What the worker made of a block; None where the worker went away with it."""
    try:
        outcome: Outcome = flight.future.result(FETCH_S)
    except Exception as error:
        if flight.future.status == "finished" and not isinstance(error, TimeoutError):
            raise
        logger.warning("the outcome of block %s was lost: %s", flight.token, error)
        return None
    return outcome
