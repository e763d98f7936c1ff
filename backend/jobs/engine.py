"""The engine: takes queued runs, has their blocks computed by workers, stores what comes back.

One thread owns all of it. Everything that happens elsewhere (a request, a finished block, progress) arrives as a
message in its inbox, so there is nothing to lock. What must survive is in the database before the thread goes on:
a run's state, its finished blocks, its result.
"""

from __future__ import annotations

import logging
import queue
import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from algorithms.errors import FilterRoomError
from backend.db import events, outcomes, recordings, runs
from backend.db.engine import Database
from backend.errors import STORAGE_CODES, StorageError, UnavailableError
from backend.files.store import Store
from backend.jobs import ledger
from backend.jobs.collection import collect
from backend.jobs.outcome import Outcome
from backend.jobs.parsing import Parser
from backend.jobs.plan import plan_of
from backend.jobs.reader_process import ReadAnswer
from backend.jobs.schedule import RETRIES, ActiveRun, Flight, choose, monotonic
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
        # Why workers that are there get no work, in words.
        self._notice = ""
        # What hindered the last round, in words; it is logged once.
        self._trouble = ""
        self._cluster: Any = None
        self._workers: dict[str, int] = {}
        self._no_workers_since: float | None = None
        self._active: dict[str, ActiveRun] = {}
        self._flights: dict[str, Flight] = {}
        # Runs that failed and whose failure is not in the database yet: error and trace.
        self._failures: dict[str, tuple[dict[str, Any], str]] = {}
        # Workers that compile kernels now, and those that still have to.
        self._warming: dict[str, Any] = {}
        self._cold: deque[str] = deque()

    # What the server calls, from any thread.

    def start(self) -> None:
        """Take up what an earlier server left, and bring the workers up in the background."""
        ledger.recover(self._database, self._store)
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

    def look_into(
        self,
        files: tuple[tuple[str, Path], ...],
        site: bytes | None,
        truth: tuple[str, Path] | None,
        options: Mapping[str, Any],
    ) -> Future[ReadAnswer]:
        """Read files on trial, in the same process and after what is being parsed; nothing is stored."""
        return self._parser.look(files, site, truth, options)

    def read_tracks(
        self, file: tuple[str, Path], options: Mapping[str, Any], choice: Mapping[str, Any]
    ) -> Future[ReadAnswer]:
        """Read the paths of a file, in the same process and after what is being parsed; nothing is stored."""
        return self._parser.tracks(file, options, choice)

    def status(self) -> EngineStatus:
        """Return what the engine is doing."""
        with self._database.read() as connection:
            running, queued = (runs.count_runs(connection, s) for s in ("running", "queued"))
        detail = self._detail or self._notice
        return EngineStatus(self._state, sum(self._workers.values()), running, queued, detail)

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
                self._store_failures()
            except FilterRoomError as error:
                # A full disk, a locked database: the next round may succeed.
                if str(error) != self._trouble:
                    logger.error("the engine cannot go on, and tries again: %s", error)
                self._trouble = str(error)
                self._stopping.wait(1)
            except Exception:
                logger.exception("the engine's round failed")
                self._stopping.wait(1)
            else:
                self._trouble = ""
        self._close_cluster()

    def _connect(self) -> None:
        from backend.jobs.cluster import Cluster

        try:
            self._cluster = Cluster(
                self._settings, lambda token, share: self._post(lambda: self._progress(token, share))
            )
        except FilterRoomError as error:
            self._report_failure(str(error))
            self._stopping.wait(RETRY_S)
            return
        except Exception as error:
            logger.exception("the workers cannot be started")
            self._state, self._detail = "failed", f"The workers cannot be started: {error}"
            self._stopping.wait(RETRY_S)
            return
        self._state, self._detail = "warming_up", "Compiling the kernels."
        self._cold = deque(self._cluster.workers())

    def _report_failure(self, words: str) -> None:
        if (self._state, self._detail) != ("failed", words):
            logger.error("%s", words)
        self._state, self._detail = "failed", words

    def _disconnect(self, error: UnavailableError) -> None:
        """Take back what was sent to a scheduler that went away; `_connect` tries it again."""
        self._report_failure(str(error))
        cluster, self._cluster = self._cluster, None
        threading.Thread(target=cluster.close, args=([],), daemon=True).start()
        self._workers = {}
        self._warming.clear()
        self._cold.clear()
        flights, self._flights = self._flights, {}
        for flight in flights.values():
            active = self._active.get(flight.run_id)
            if active is not None and flight.stopping_since is None:
                active.waiting.appendleft(flight.position)
                active.shares.pop(flight.position, None)
        self._tell_waiting(str(error))

    def _tell_waiting(self, words: str) -> None:
        """Write into the logs of runs, once, why they wait."""
        for active in self._active.values():
            if active.told != words:
                with self._database.write() as connection:
                    events.append_log(connection, active.run.id, words, "warning")
                active.told = words

    def _close_cluster(self) -> None:
        cluster, self._cluster = self._cluster, None
        if cluster is not None:
            cluster.close(list(self._flights))
        self._workers = {}

    def _next_message(self) -> None:
        """Wait for a message, then take all that are there."""
        busy = self._flights or self._warming or any(a.waiting for a in self._active.values())
        try:
            message = self._inbox.get(timeout=TICK_S if busy else IDLE_TICK_S)
            while True:
                self._take(message)
                message = self._inbox.get_nowait()
        except queue.Empty:
            return

    def _take(self, message: Callable[[], None]) -> None:
        try:
            message()
        except (StorageError, UnavailableError):
            # Every message may come twice; none may be lost because the database is locked or away.
            self._post(message)
            raise

    # Workers.

    def _look_after_workers(self) -> None:
        try:
            self._workers = self._cluster.workers()
        except UnavailableError as error:
            self._disconnect(error)
            return
        notice = self._cluster.notice()
        if notice and notice != self._notice:
            logger.warning("%s", notice)
        self._notice = notice
        if self._notice and not self._workers:
            self._tell_waiting(self._notice)
        at = monotonic()
        if self._workers:
            self._no_workers_since = None
        elif self._no_workers_since is None:
            self._no_workers_since = at
        elif at - self._no_workers_since > MISSING_S:
            self._no_workers_since = at
            if self._cluster.heal():
                logger.error("no worker was left; they are started again")
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
                if run.id not in self._active and run.id not in self._failures:
                    done = set(outcomes.finished_blocks(connection, run.id))
                    plan = plan_of(run)
                    waiting = deque(p for p in range(plan.size) if p not in done)
                    self._active[run.id] = ActiveRun(run, plan, waiting, done)

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
        if active.run.state == "running":
            return True
        begun = ledger.begin(self._database, active.run, active.plan, len(active.finished))
        if begun is None:
            self._drop(active.run.id)
            return False
        active.run = begun
        return True

    def _send(self, active: ActiveRun, position: int, worker: str, alone: bool) -> None:
        with self._failing(active, position):
            block = ledger.block_of(self._database, self._store, active.run, active.plan, position)
            future = self._cluster.submit(block, worker)
            self._flights[block.token] = Flight(block.token, active.run.id, position, worker, future, alone)
            active.waiting.remove(position)
            future.add_done_callback(lambda _: self._post(lambda: self._landed(block.token)))

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
        if flight.outcome is None and flight.future.status != "finished" and not self._cluster.is_connected:
            # Nobody died: the scheduler went away, and all blocks are taken back together.
            return
        del self._flights[token]
        active = self._active.get(flight.run_id)
        if active is None or flight.stopping_since is not None:
            return
        if flight.outcome is None and flight.future.status != "finished":
            self._lost(active, flight)
            return
        try:
            with self._failing(active, flight.position):
                outcome: Outcome = flight.outcome or flight.future.result()
                flight.outcome = outcome
                if outcome.kind == "done":
                    ledger.keep(self._database, self._store, active.run, active.plan, flight.position, outcome)
                    active.finished.add(flight.position)
                elif outcome.kind == "failed":
                    assert outcome.error is not None
                    self._fail(flight.run_id, outcome.error, outcome.trace)
                    if outcome.error["code"] == "out_of_memory":
                        # What the algorithm still holds would be missing to the next block.
                        self._flights[token] = flight
                        self._restart(flight, "ran out of memory")
        except UnavailableError:
            # The outcome waits with its worker until it can be stored.
            self._flights[token] = flight
            raise

    def _finish(self, active: ActiveRun) -> None:
        with self._failing(active):
            ledger.finish(self._database, self._store, active.run, active.plan)
            self._active.pop(active.run.id, None)

    def _lost(self, active: ActiveRun, flight: Flight) -> None:
        """Send a block again whose worker died, or give the run up."""
        position, label = flight.position, active.plan.name_of(flight.position)
        deaths = active.deaths[position] = active.deaths.get(position, 0) + 1
        active.shares.pop(position, None)
        if deaths > RETRIES:
            self._fail(
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

    @contextmanager
    def _failing(self, active: ActiveRun, position: int | None = None) -> Iterator[None]:
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
            self._fail(active.run.id, ledger.error_of(error, label))
        except Exception:
            logger.exception("run %s failed", active.run.id)
            what = {"code": "internal", "detail": "The server could not go on.", "remedy": "Please report it."}
            self._fail(active.run.id, {**what, "label": label}, traceback.format_exc())

    def _fail(self, run_id: str, error: dict[str, Any], trace: str = "") -> None:
        self._failures[run_id] = (error, trace)
        self._active.pop(run_id, None)
        self._leave(run_id)

    def _store_failures(self) -> None:
        """Write failures down; where the disk is full this is tried again in every round."""
        for run_id, (error, trace) in list(self._failures.items()):
            ledger.fail(self._database, run_id, error, trace)
            ledger.forget(self._database, self._store, run_id)
            if error["code"] in STORAGE_CODES:
                # Its last file may be there without the row that refers to it.
                collect(self._database, self._store)
            del self._failures[run_id]

    def _drop(self, run_id: str) -> None:
        """Leave a run that is final: stop what is under way and delete what is half done."""
        self._active.pop(run_id, None)
        self._leave(run_id)
        ledger.forget(self._database, self._store, run_id)

    def _leave(self, run_id: str) -> None:
        tokens = [f.token for f in self._flights.values() if f.run_id == run_id and f.stopping_since is None]
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
                self._restart(flight, "does not leave a cancelled block")
            elif flight.worker in self._workers:
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
                self._post(lambda: self._forget_flight(flight.token))

        threading.Thread(target=restart, daemon=True).start()

    def _forget_flight(self, token: str) -> None:
        self._flights.pop(token, None)
