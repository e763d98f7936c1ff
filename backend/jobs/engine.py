"""The engine: takes queued runs, has their blocks computed by workers, stores what comes back.

One thread owns all of it: the live runs (`live_runs`), the blocks under way (`flights`) and the workers (`crew`).
Everything that happens elsewhere (a request, a finished block, progress) arrives as a message in its inbox, so there is
nothing to lock. What must survive is in the database before the thread goes on: a run's state, its finished blocks,
its result.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from algorithms.errors import FilterRoomError
from backend.db import events, recordings, runs
from backend.db.engine import Database
from backend.errors import StorageError, UnavailableError
from backend.files.store import Store
from backend.jobs import crew, ledger
from backend.jobs.crew import Crew, EngineState
from backend.jobs.flights import Flights
from backend.jobs.live_runs import LiveRuns
from backend.jobs.parsing import Parser
from backend.jobs.reader_process import ReadAnswer
from backend.jobs.schedule import choose, monotonic
from backend.settings import Settings

logger = logging.getLogger(__name__)

# Seconds between two looks at what hangs, while something is under way and while nothing is.
TICK_S = 0.1
IDLE_TICK_S = 2.0


@dataclass(frozen=True)
class EngineStatus:
    """What the engine is doing; `detail` says in words what the state does not, `warning` what is amiss anyway."""

    state: EngineState
    workers: int
    running: int
    queued: int
    detail: str = ""
    warning: str = ""


class Engine:
    """Runs and parse jobs of one server."""

    def __init__(self, database: Database, store: Store, settings: Settings) -> None:
        self._database = database
        self._store = store
        self._parser = Parser(database, store, settings)
        self._inbox: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._live, name="engine", daemon=True)
        self._stopping = threading.Event()
        # What hindered the last round, in words; it is logged once.
        self._trouble = ""
        self._runs = LiveRuns(database, store, lambda run_id: self._flights.leave(run_id))
        self._flights = Flights(database, store, self._runs, self._post)
        self._crew = Crew(settings, self._post, self._flights.progress)

    # What the server calls, from any thread.

    def start(self) -> None:
        """Take up what an earlier server left, and bring the workers up in the background."""
        ledger.recover(self._database, self._store)
        self._parser.resume()
        self._post(self._runs.take_up)
        self._thread.start()

    def stop(self) -> None:
        """End the workers; runs under way stay in the database and go on with the next server."""
        self._stopping.set()
        self._post(lambda: None)
        self._parser.stop()
        if self._thread.ident is not None:
            self._thread.join()
        self._crew.state = "stopped"

    def notify(self) -> None:
        """Say that a run was queued."""
        self._post(self._runs.take_up)

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
            self._post(lambda: self._runs.drop(run_id))
        return changed

    def expect_recording(self) -> None:
        """Say that a recording begins to arrive."""
        self._parser.expect()

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

    @property
    def state(self) -> EngineState:
        """Return whether workers are there, without asking the database."""
        return self._crew.state

    def status(self) -> EngineStatus:
        """Return what the engine is doing."""
        with self._database.read() as connection:
            running, queued = (runs.count_runs(connection, s) for s in ("running", "queued"))
        return EngineStatus(self._crew.state, self._crew.size, running, queued, self._crew.words, self._crew.warning)

    # The engine's thread.

    def _post(self, message: Callable[[], None]) -> None:
        self._inbox.put(message)

    def _live(self) -> None:
        while not self._stopping.is_set():
            try:
                if self._crew.cluster is None:
                    self._connect()
                    continue
                self._round()
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
        self._crew.close(self._flights.tokens)

    def _connect(self) -> None:
        if self._crew.connect():
            self._flights.use(self._crew.cluster)
            return
        # Runs that come meanwhile are taken up, and their logs say why they wait.
        again = monotonic() + crew.RETRY_S
        while not self._stopping.is_set() and (left := again - monotonic()) > 0:
            self._runs.tell_waiting(self._crew.words)
            self._take_messages(left)

    def _round(self) -> None:
        # What an earlier round could not store comes first: nothing is sent while nothing can be kept.
        self._flights.keep_arrived()
        busy = self._flights.under_way or self._crew.is_warming or any(a.waiting for a in self._runs.active.values())
        self._take_messages(TICK_S if busy else IDLE_TICK_S)
        self._look_after_workers()
        self._flights.look_after(self._crew.workers)
        self._runs.report_progress()
        # A worker that is free gets its next block before its last one is stored.
        self._dispatch()
        self._flights.keep_arrived()
        self._runs.finish_complete()
        self._runs.store_failures()

    def _take_messages(self, timeout_s: float) -> None:
        """Wait for a message, then take all that are there."""
        try:
            message = self._inbox.get(timeout=timeout_s)
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

    def _look_after_workers(self) -> None:
        try:
            self._crew.look_after()
        except UnavailableError as error:
            self._crew.disconnect(str(error))
            self._flights.take_back()
            self._runs.tell_waiting(str(error))
            return
        if (failure := self._crew.failure) is not None:
            self._runs.fail_all(failure)
        if self._crew.notice and not self._crew.workers:
            self._runs.tell_waiting(self._crew.notice)

    def _dispatch(self) -> None:
        while (worker := self._crew.free(self._flights.under_way)) is not None:
            choice = choose(self._runs.active.values(), self._flights.under_way)
            if choice is None:
                return
            if self._runs.begin(choice.active):
                self._flights.send(choice, worker)
