"""The engine: takes queued runs, has their blocks computed by workers, stores what comes back.

One thread owns all of it. Everything that happens elsewhere (a request, a finished block, progress) arrives as a
message in its inbox, so there is nothing to lock. What must survive is in the database before the thread goes on:
a run's state, its finished blocks, its result.
"""

from __future__ import annotations

import datetime as dt
import logging
import queue
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Literal

from algorithms.errors import FilterRoomError
from backend.db import events, idempotency, outcomes, recordings, runs
from backend.db.engine import Database
from backend.db.ids import new_id, now
from backend.errors import StorageError
from backend.files.store import Store
from backend.jobs import results
from backend.jobs.collection import collect
from backend.jobs.parsing import Parser
from backend.jobs.schedule import RETRIES, ActiveRun, Flight, choose, monotonic
from backend.jobs.work import Block, Outcome
from backend.settings import Settings

logger = logging.getLogger(__name__)

EngineState = Literal["starting", "warming_up", "ready", "failed", "stopped"]

# Seconds: between two looks at what hangs, between two stored progresses of a run, until a cancelled block's worker
# is restarted, until a block whose worker is gone is given up, between two tries to start a cluster.
TICK_S = 0.1
IDLE_TICK_S = 2.0
PROGRESS_S = 0.25
PATIENCE_S = 1.0
MISSING_S = 3.0
RETRY_S = 10.0
# How long idempotency keys and events that belong to no run are kept.
KEEP_KEYS = dt.timedelta(days=7)
KEEP_EVENTS = dt.timedelta(days=1)


@dataclass(frozen=True)
class EngineStatus:
    """What the engine is doing; `detail` says in words what the state does not."""

    state: EngineState
    workers: int
    running: int
    queued: int
    detail: str = ""


class Engine:
    """Runs and parse jobs of one server."""

    def __init__(self, database: Database, store: Store, settings: Settings) -> None:
        self._database = database
        self._store = store
        self._settings = settings
        self._parser = Parser(database, store, settings)
        self._inbox: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._live, name="engine", daemon=True)
        self._stopping = threading.Event()
        self._state: EngineState = "starting"
        self._detail = ""
        self._cluster: Any = None
        self._workers: dict[str, int] = {}
        self._no_workers_since: float | None = None
        self._active: dict[str, ActiveRun] = {}
        self._flights: dict[str, Flight] = {}
        # Workers that compile kernels now, and those that still have to.
        self._warming: dict[str, Any] = {}
        self._cold: deque[str] = deque()

    # What the server calls, from any thread.

    def start(self) -> None:
        """Take up what an earlier server left, and bring the workers up in the background."""
        recover(self._database, self._store)
        self._parser.resume()
        self._post(self._take_live_runs)
        self._thread.start()

    def stop(self) -> None:
        """End the workers; runs under way stay in the database and go on with the next server."""
        self._stopping.set()
        self._post(lambda: None)
        self._parser.stop()
        if self._thread.ident is not None:
            self._thread.join()
        self._state = "stopped"

    def notify(self) -> None:
        """Say that a run was queued."""
        self._post(self._take_live_runs)

    def cancel(self, run_id: str) -> bool:
        """Cancel a run: final at once, its workers free within about a second; False where it was cancelled before.

        Raises
        ------
        NotFoundError, StateError
            There is no such run, or it succeeded or failed.
        """
        with self._database.write() as connection:
            changed = runs.cancel_run(connection, run_id)
            if changed:
                events.append_log(connection, run_id, "Cancelled by the user.")
        if changed:
            self._post(lambda: self._drop(run_id))
        return changed

    def read_recording(self, recording_id: str) -> Future[recordings.Recording]:
        """Parse a recording that is in the state `parsing`; the future gives its row, `ready` or `failed`."""
        return self._parser.parse(recording_id)

    def status(self) -> EngineStatus:
        """Return what the engine is doing."""
        with self._database.read() as connection:
            running, queued = (runs.count_runs(connection, s) for s in ("running", "queued"))
        return EngineStatus(self._state, sum(self._workers.values()), running, queued, self._detail)

    # The engine's thread.

    def _post(self, message: Callable[[], None]) -> None:
        self._inbox.put(message)

    def _live(self) -> None:
        while not self._stopping.is_set():
            try:
                if self._cluster is None:
                    self._connect()
                    continue
                self._next_message()
                self._look_after_workers()
                self._look_after_flights()
                self._report_progress()
                self._dispatch()
            except Exception:
                # Whatever it was (a full disk, a scheduler that went away), the next round may succeed.
                logger.exception("the engine's round failed")
                self._stopping.wait(1)
        self._close_cluster()

    def _connect(self) -> None:
        from backend.jobs.cluster import Cluster

        try:
            self._cluster = Cluster(
                self._settings, lambda token, share: self._post(lambda: self._progress(token, share))
            )
        except Exception as error:
            logger.exception("the workers cannot be started")
            self._state, self._detail = "failed", f"The workers cannot be started: {error}"
            self._stopping.wait(RETRY_S)
            return
        self._workers = self._cluster.workers()
        self._cold = deque(self._workers)
        self._state, self._detail = "warming_up", "Compiling the kernels."

    def _close_cluster(self) -> None:
        cluster, self._cluster = self._cluster, None
        if cluster is not None:
            cluster.close()
        self._workers = {}

    def _next_message(self) -> None:
        """Wait for a message, then take all that are there."""
        busy = self._flights or self._warming or any(a.waiting for a in self._active.values())
        try:
            message = self._inbox.get(timeout=TICK_S if busy else IDLE_TICK_S)
            while True:
                message()
                message = self._inbox.get_nowait()
        except queue.Empty:
            return

    # Workers.

    def _look_after_workers(self) -> None:
        self._workers = self._cluster.workers()
        at = monotonic()
        if self._workers:
            self._no_workers_since = None
        elif self._no_workers_since is None:
            self._no_workers_since = at
        elif at - self._no_workers_since > MISSING_S:
            self._no_workers_since = at
            logger.error("no worker is left")
            if self._cluster.heal():
                self._workers = self._cluster.workers()
        self._warm_up()

    def _warm_up(self) -> None:
        """Compile on one worker first; the others then only load from the cache, and until then take blocks."""
        if self._state != "warming_up":
            return
        while self._cold and not self._warming:
            batch = [self._cold.popleft()] if len(self._cold) == len(self._workers) else list(self._cold)
            self._cold = deque(w for w in self._cold if w not in batch)
            for worker in batch:
                if worker in self._workers:
                    self._warming[worker] = future = self._cluster.warm_up(worker)
                    future.add_done_callback(lambda f, w=worker: self._post(lambda: self._warmed(w, f)))
        if not self._cold and not self._warming:
            self._state, self._detail = "ready", ""

    def _warmed(self, worker: str, future: Any) -> None:
        self._warming.pop(worker, None)
        if future.status == "error":
            logger.error("compiling the kernels on %s failed", worker, exc_info=future.exception())

    def _free_worker(self) -> str | None:
        taken = [f.worker for f in self._flights.values()] + list(self._warming)
        return next((w for w, threads in self._workers.items() if taken.count(w) < threads), None)

    # Runs.

    def _take_live_runs(self) -> None:
        with self._database.read() as connection:
            for run in runs.live_runs(connection):
                if run.id not in self._active:
                    done = set(outcomes.finished_blocks(connection, run.id))
                    waiting = deque(p for p in range(len(run.algorithms)) if p not in done)
                    self._active[run.id] = ActiveRun(run, waiting, done)

    def _dispatch(self) -> None:
        # A run whose last block was stored just before the server died has nothing left to send.
        for active in [a for a in self._active.values() if a.is_complete]:
            if self._begin(active):
                self._finish(active)
        while (worker := self._free_worker()) is not None:
            choice = choose(self._active.values(), self._flights.values())
            if choice is None:
                return
            if self._begin(choice.active):
                self._send(choice.active, choice.position, worker, choice.alone)

    def _begin(self, active: ActiveRun) -> bool:
        """Make a queued run a running one; False where it was cancelled or deleted meanwhile."""
        run = active.run
        if run.state == "running":
            return True
        with self._database.write() as connection:
            started = runs.start_run(connection, run.id)
            if started:
                count = f"{len(active.finished)} of {len(run.algorithms)} algorithms are finished already"
                text = f"Goes on after a restart of the server: {count}." if run.started_at else "Started."
                events.append_log(connection, run.id, text)
                active.run = runs.get_run(connection, run.id)
        if not started:
            self._drop(run.id)
        return started

    def _send(self, active: ActiveRun, position: int, worker: str, alone: bool) -> None:
        active.waiting.remove(position)
        try:
            block = self._block(active.run, position)
        except FilterRoomError as error:
            self._fail(active.run.id, _error(error, active.run.algorithms[position].label))
            return
        future = self._cluster.submit(block, worker)
        self._flights[block.token] = Flight(block.token, active.run.id, position, worker, future, alone)
        future.add_done_callback(lambda _: self._post(lambda: self._landed(block.token)))

    def _block(self, run: runs.Run, position: int) -> Block:
        entry = run.algorithms[position]
        with self._database.read() as connection:
            (recording_id,) = runs.recording_ids_of(connection, run.id)
            data_sha256 = recordings.get_recording(connection, recording_id).data_sha256
        if data_sha256 is None:
            raise StorageError("The recording has no data.", remedy="Upload it again.", code="recording_not_ready")
        return Block(
            token=f"{run.id}-{position}-{new_id()}",
            algorithm=entry.name,
            label=entry.label,
            parameters=entry.parameters,
            seed=run.seed,
            recording=self._store.get_bytes(data_sha256),
        )

    # Blocks that come back, or do not.

    def _progress(self, token: str, share: float) -> None:
        flight = self._flights.get(token)
        active = self._active.get(flight.run_id) if flight is not None else None
        if flight is not None and active is not None:
            active.shares[flight.position] = min(max(share, 0.0), 1.0)

    def _report_progress(self) -> None:
        at = monotonic()
        for active in self._active.values():
            if active.done != active.reported and at - active.reported_at >= PROGRESS_S:
                active.reported, active.reported_at = active.done, at
                if active.run.state == "running":
                    with self._database.write() as connection:
                        runs.set_progress(connection, active.run.id, active.done)

    def _landed(self, token: str) -> None:
        flight = self._flights.get(token)
        if flight is None or flight.restarting:
            return
        del self._flights[token]
        active = self._active.get(flight.run_id)
        if active is None or flight.stopping_since is not None:
            return
        if flight.future.status != "finished":
            self._lost(active, flight)
            return
        outcome: Outcome = flight.future.result()
        if outcome.kind == "done":
            self._keep(active, flight.position, outcome)
        elif outcome.kind == "failed":
            assert outcome.error is not None
            self._fail(flight.run_id, outcome.error, outcome.trace)

    def _keep(self, active: ActiveRun, position: int, outcome: Outcome) -> None:
        run = active.run
        label = run.algorithms[position].label
        try:
            with self._store.guard():
                sha256 = self._store.put_arrays(results.block_arrays(outcome))
                with self._database.write() as connection:
                    outcomes.store_block(connection, run.id, position, sha256)
                    events.append_log(connection, run.id, f"{label}: finished in {outcome.seconds:.2f} s.")
                    for note in outcome.notes:
                        events.append_log(connection, run.id, f"{label}: {note['detail']}", "warning")
        except StorageError as error:
            self._fail(run.id, _error(error, label))
            return
        active.finished.add(position)
        if active.is_complete:
            self._finish(active)

    def _finish(self, active: ActiveRun) -> None:
        run = active.run
        with self._database.read() as connection:
            blobs = outcomes.finished_blocks(connection, run.id)
        blocks = [results.outcome_of(self._store.get_arrays(blobs[p])) for p in range(len(run.algorithms))]
        try:
            composed = results.compose([e.label for e in run.algorithms], blocks)
            with self._store.guard():
                sha256 = self._store.put_arrays(composed.arrays)
                with self._database.write() as connection:
                    finished = runs.finish_run(
                        connection,
                        run.id,
                        result_sha256=sha256,
                        summary=composed.summary,
                        entries=composed.entries,
                        software=composed.software,
                    )
                    if finished:
                        outcomes.store_tables(connection, run.id, composed.tables)
                        outcomes.forget_blocks(connection, run.id)
                        events.append_log(connection, run.id, "Succeeded.")
        except StorageError as error:
            self._fail(run.id, _error(error, ""))
            return
        self._active.pop(run.id, None)
        collect(self._database, self._store, {sha256, *blobs.values()})

    def _lost(self, active: ActiveRun, flight: Flight) -> None:
        """Send a block again whose worker died, or give the run up."""
        position, label = flight.position, active.run.algorithms[flight.position].label
        deaths = active.deaths[position] = active.deaths.get(position, 0) + 1
        active.shares.pop(position, None)
        if deaths > RETRIES:
            self._fail(
                active.run.id,
                {
                    "code": "worker_died",
                    "detail": f"The worker died {deaths} times while it computed {label}.",
                    "remedy": "Most often it ran out of memory: use a shorter recording or fewer workers.",
                    "label": label,
                },
            )
            return
        active.waiting.append(position)
        with self._database.write() as connection:
            events.append_log(
                connection, active.run.id, f"{label}: the worker died; it is computed again, alone.", "warning"
            )

    def _fail(self, run_id: str, error: dict[str, Any], trace: str = "") -> None:
        with self._database.write() as connection:
            if runs.fail_run(connection, run_id, error):
                where = f"{error['label']}: " if error.get("label") else ""
                text = f"{where}{error['detail']} {error['remedy']}".strip()
                events.append_log(connection, run_id, text + (f"\n{trace}" if trace else ""), "error")
        self._drop(run_id)

    def _drop(self, run_id: str) -> None:
        """Leave a run that is final: stop what is under way and delete what is half done."""
        self._active.pop(run_id, None)
        with self._database.write() as connection:
            blobs = set(outcomes.finished_blocks(connection, run_id).values())
            outcomes.forget_blocks(connection, run_id)
        if blobs:
            collect(self._database, self._store, blobs)
        tokens = [f.token for f in self._flights.values() if f.run_id == run_id]
        for token in tokens:
            self._flights[token].stopping_since = monotonic()
        if tokens:
            # In a thread of its own: a worker that hangs does not answer.
            cluster = self._cluster
            threading.Thread(target=cluster.signal_cancel, args=(tokens,), daemon=True).start()

    def _look_after_flights(self) -> None:
        at = monotonic()
        for flight in list(self._flights.values()):
            if flight.restarting:
                continue
            if flight.stopping_since is not None and at - flight.stopping_since > PATIENCE_S:
                self._restart(flight)
            elif flight.worker in self._workers:
                flight.missing_since = None
            elif flight.missing_since is None:
                flight.missing_since = at
            elif at - flight.missing_since > MISSING_S and not flight.future.done():
                # Its worker went away before Dask knew of the block: it would wait for ever.
                flight.future.cancel()
                self._landed(flight.token)

    def _restart(self, flight: Flight) -> None:
        logger.warning("worker %s does not leave a cancelled block and is restarted", flight.worker)
        flight.restarting = True
        # Else Dask would start the block again when the worker is back.
        flight.future.cancel()
        cluster = self._cluster

        def restart() -> None:
            try:
                cluster.restart(flight.worker)
            finally:
                self._post(lambda: self._forget_flight(flight.token))

        threading.Thread(target=restart, daemon=True).start()

    def _forget_flight(self, token: str) -> None:
        self._flights.pop(token, None)


def recover(database: Database, store: Store) -> None:
    """Take up what an earlier server left: queue its running runs again, delete what belongs to nothing."""
    with database.write() as connection:
        runs.requeue_running(connection)
        idempotency.forget_old_keys(connection, now() - KEEP_KEYS)
        events.forget_old_events(connection, now() - KEEP_EVENTS)
    store.clear_temporary()
    collect(database, store)


def _error(error: FilterRoomError, label: str) -> dict[str, Any]:
    return {"code": error.code, "detail": error.message, "remedy": error.remedy, "label": label}
