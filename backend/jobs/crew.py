"""The workers as the engine sees them: they come up, warm up, take blocks, go away with their scheduler, come back."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Literal

from algorithms.errors import CompilationError, FilterRoomError
from backend.jobs.schedule import Flight, monotonic
from backend.settings import Settings

logger = logging.getLogger(__name__)

EngineState = Literal["starting", "warming_up", "ready", "failed", "stopped"]

# Seconds until our own workers are started again where all are gone, the same while their nannies see to it (on a busy
# machine a new worker takes its time, and who interferes kills it at birth), and between two tries to start a cluster.
MISSING_S = 3.0
RESTARTING_S = 30.0
RETRY_S = 10.0
# Workers that may die while they compile kernels before nothing is tried any more.
DEATHS = 3
_DIED = CompilationError(
    f"A worker died {DEATHS} times while it compiled the kernels.",
    remedy=(
        "Most often for want of memory: use fewer workers or raise FILTERROOM_WORKER_MEMORY_BYTES, "
        "then restart the server."
    ),
)


class Crew:
    """The workers of one server.

    `post` hands a message to the engine's thread; `on_progress(token, share)` is called there. Only that thread comes
    here, but for `state`, `words` and `size`, which anybody may read.
    """

    def __init__(
        self,
        settings: Settings,
        post: Callable[[Callable[[], None]], None],
        on_progress: Callable[[str, float], None],
    ) -> None:
        self._settings = settings
        self._post = post
        self._on_progress = on_progress
        self.state: EngineState = "starting"
        self._detail = ""
        # Why workers that are there get no work, in words.
        self.notice = ""
        # Why a worker cannot keep compiled kernels.
        self._folder = ""
        # Workers whose kernels cannot be compiled, by address.
        self._broken: dict[str, FilterRoomError] = {}
        self._died_warming = 0
        self.cluster: Any = None
        self.workers: dict[str, int] = {}
        """Threads by address."""
        self._none_since: float | None = None
        # Workers that compile kernels now, and those that still have to.
        self._warming: dict[str, Any] = {}
        self._cold: deque[str] = deque()

    @property
    def words(self) -> str:
        """What the state does not say."""
        return self._detail or self.warning

    @property
    def warning(self) -> str:
        """What is amiss though runs are computed, with the remedy."""
        return " ".join(words for words in (self.notice, self._folder) if words)

    @property
    def failure(self) -> FilterRoomError | None:
        """Why no worker that is there can compute anything: their kernels cannot be compiled."""
        if not self.workers or any(w not in self._broken for w in self.workers):
            return None
        return next(iter(self._broken.values()))

    @property
    def size(self) -> int:
        """Blocks that can be under way at once."""
        return sum(self.workers.values())

    @property
    def is_warming(self) -> bool:
        """Whether a worker compiles or loads kernels now."""
        return bool(self._warming)

    def connect(self) -> bool:
        """Start workers, or connect to a scheduler; False where that failed and is to be tried again."""
        from backend.jobs.cluster import Cluster

        try:
            self.cluster = Cluster(
                self._settings, lambda token, share: self._post(lambda: self._on_progress(token, share))
            )
        except FilterRoomError as error:
            self._report_failure(str(error))
            return False
        except Exception as error:
            logger.exception("the workers cannot be started")
            self.state, self._detail = "failed", f"The workers cannot be started: {error}"
            return False
        self.state, self._detail = "warming_up", "Compiling the kernels."
        self._cold = deque(self.cluster.workers())
        return True

    def disconnect(self, words: str) -> None:
        """Leave a scheduler that went away; `connect` tries it again."""
        self._report_failure(words)
        cluster, self.cluster = self.cluster, None
        threading.Thread(target=cluster.close, args=([],), daemon=True).start()
        self.workers = {}
        self._warming.clear()
        self._cold.clear()
        self._broken.clear()

    def close(self, tokens: list[str]) -> None:
        """End the workers that are ours; blocks under way (`tokens`) are given up."""
        cluster, self.cluster = self.cluster, None
        if cluster is not None:
            cluster.close(tokens)
        self.workers = {}

    def look_after(self) -> None:
        """See who is there; start our own workers again where all are gone.

        Raises
        ------
        UnavailableError
            The scheduler went away.
        """
        self.workers = self.cluster.workers()
        notice = self.cluster.notice()
        if notice and notice != self.notice:
            logger.warning("%s", notice)
        self.notice = notice
        at = monotonic()
        if self.workers:
            self._none_since = None
        elif self._none_since is None:
            self._none_since = at
        elif at - self._none_since > (RESTARTING_S if self.cluster.is_restarting else MISSING_S):
            self._none_since = at
            if self.cluster.heal():
                logger.error("no worker was left; they are started again")
                self.workers = self.cluster.workers()
        self._warm_up()

    def free(self, under_way: Iterable[Flight]) -> str | None:
        """Return a worker that has nothing to do."""
        taken = [f.worker for f in under_way] + list(self._warming)
        usable = ((w, threads) for w, threads in self.workers.items() if w not in self._broken)
        return next((w for w, threads in usable if taken.count(w) < threads), None)

    def _report_failure(self, words: str) -> None:
        if (self.state, self._detail) != ("failed", words):
            logger.error("%s", words)
        self.state, self._detail = "failed", words

    def _warm_up(self) -> None:
        """Compile on one worker first; the others then only load from the cache, and until then take blocks."""
        self._lose_broken_and_dead()
        if self.state == "failed" and self.failure is None and self.workers:
            # One came that has not tried yet.
            self.state, self._detail = "warming_up", "Compiling the kernels."
            self._cold = deque(w for w in self.workers if w not in self._broken)
        if self.state != "warming_up":
            return
        while self._cold and not self._warming:
            first = len(self._cold) == len(self.workers)
            batch = [self._cold.popleft()] if first else list(self._cold)
            self._cold = deque(w for w in self._cold if w not in batch)
            for worker in batch:
                if worker in self.workers:
                    if first:
                        asked = self.cluster.fault_of_kernel_folder(worker)
                        asked.add_done_callback(lambda f: self._post(lambda: self._told_of_folder(f)))
                    self._warming[worker] = future = self.cluster.warm_up(worker)
                    future.add_done_callback(lambda f, w=worker: self._post(lambda: self._warmed(w, f)))
        if not self._cold and not self._warming:
            failure = self.failure
            self.state, self._detail = ("ready", "") if failure is None else ("failed", str(failure))

    def _lose_broken_and_dead(self) -> None:
        """Forget broken workers that went away, and send another in place of one that died while it compiled."""
        if self._broken and self.cluster.is_same_machine:
            # The others of this machine, and those that come in their place, would compile the same with the same end.
            self._broken = dict.fromkeys(self.workers or self._broken, next(iter(self._broken.values())))
            self._cold.clear()
        else:
            self._broken = {w: error for w, error in self._broken.items() if w in self.workers}
        for worker in [w for w in self._warming if w not in self.workers]:
            self._warming.pop(worker).cancel()
            self._died_warming += 1
            if self._died_warming >= DEATHS:
                self._broken |= dict.fromkeys(self.workers, _DIED)
            elif self.workers:
                self._cold = deque(self.workers)

    def _told_of_folder(self, future: Any) -> None:
        self._folder = future.result() if future.status == "finished" else ""
        if self._folder:
            logger.warning("%s", self._folder)

    def _warmed(self, worker: str, future: Any) -> None:
        self._warming.pop(worker, None)
        if future.status != "error":
            return
        cause = future.exception()
        logger.error("compiling the kernels on %s failed", worker, exc_info=cause)
        self._broken[worker] = cause if isinstance(cause, FilterRoomError) else _not_loaded(cause)


def _not_loaded(cause: BaseException) -> CompilationError:
    said = (str(cause).strip().splitlines() or [""])[0][:300].rstrip(".")
    return CompilationError(
        f"The kernels cannot be loaded: {type(cause).__name__}: {said}.",
        remedy="The server's log holds all of it. Install the program anew and restart the server.",
    )
