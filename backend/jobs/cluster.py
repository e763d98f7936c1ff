"""Dask behind a few verbs: list the workers, submit to one, signal, restart one, close.

The engine decides which worker computes what, so it always knows what a worker that died or hangs was doing.
Nothing here is imported before the server answers: Dask takes a second.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import secrets
import signal
import threading
import warnings
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from backend.errors import StateError, UnavailableError
from backend.jobs import fitness, work
from backend.jobs.worker_memory import memory_of_worker
from backend.settings import Settings

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster, Nanny

logger = logging.getLogger(__name__)

# Seconds that a scheduler may take to answer when we connect and later, workers to hear that their blocks are given
# up, and connections and workers to end.
CONNECT_S = 10
ANSWER_S = 15
SIGNAL_S = 0.5
CLOSE_S = 5

_CONFIG = {
    # The default, 3, lets one deadly block take three workers with it before it is given up; the engine
    # counts.
    "distributed.scheduler.allowed-failures": 0,
    # Even without a dashboard these ports would show logs to every user of the machine.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.nanny.http.routes": [],
    # A block carries its recording, so that it can be sent again whole when a worker dies.
    "distributed.admin.large-graph-warning-threshold": "4GiB",
    # Progress goes through the event log; a long history of it is of no use.
    "distributed.admin.low-level-log-length": 100,
    # What nobody looks at without a dashboard costs each process a few per cent: a look at every thread a hundred times
    # a second, at every event loop fifty times, at the machine twice, and at workers with less to do than others.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.scheduler.work-stealing": False,
}


class Cluster:
    """A Dask cluster: worker processes of our own, or an existing scheduler.

    `on_progress(token, share)` is called from Dask's thread.
    """

    def __init__(self, settings: Settings, on_progress: Callable[[str, float], None]) -> None:
        import dask.config
        from distributed import Client

        self._client: Client
        self._topic = f"filterroom-{secrets.token_hex(8)}"
        self._local: LocalCluster | None = None
        self._size = settings.workers
        # For the whole process: Dask reads some of it long after the start.
        dask.config.set(_CONFIG)
        if settings.scheduler:
            self._client = _connected(settings)
        else:
            self._local = _local_cluster(settings)
            # Results come straight from the workers: through the scheduler, which lives in this process too, they would
            # be sent, encrypted and held twice.
            self._client = Client(self._local, set_as_default=False, direct_to_workers=True)
        self._connection = self._client.scheduler_comm
        # Workers that somebody else runs: what speaks against each, "" where nothing does.
        self._examined: dict[str, str] = {}
        self._address = settings.scheduler

        def progress(event: tuple[float, dict[str, Any]]) -> None:
            on_progress(event[1]["token"], event[1]["share"])

        self._client.subscribe_topic(self._topic, progress)

    @property
    def is_same_machine(self) -> bool:
        """Whether the workers are our own processes, which see the data folder."""
        return self._local is not None

    @property
    def is_connected(self) -> bool:
        """Whether the connection of the start still holds; Dask makes a new one, but what was under way is lost."""
        return self._client.status == "running" and self._client.scheduler_comm is self._connection

    def workers(self) -> dict[str, int]:
        """Return the workers that are there now and may compute for this server: {address: threads}.

        Raises
        ------
        UnavailableError
            The scheduler does not answer: this cluster is of no use any more.
        """
        try:
            if not self.is_connected:
                raise OSError("the connection is lost")
            if self._local is not None:
                # Its scheduler is an object of this process: no question over the wire in every round.
                return {str(a): int(w.nthreads) for a, w in list(self._local.scheduler.workers.items())}
            ask = self._client.scheduler.ncores
            there = {str(a): int(n) for a, n in self._client.sync(ask, callback_timeout=ANSWER_S).items()}
            self._examined = {a: why for a, why in self._examined.items() if a in there}
            if new := [a for a in there if a not in self._examined]:
                self._examine(new)
        except (OSError, TimeoutError) as error:
            raise _away(self._address or "of this server", error) from error
        return {a: n for a, n in there.items() if self._examined.get(a) == ""}

    def notice(self) -> str:
        """Return in words why workers that are there get no work, or that there is none; empty where all is well."""
        if self._local is not None:
            return ""
        if not self._examined:
            return f"The scheduler {self._address} has no workers. Runs wait for them."
        unfit = {a: why for a, why in self._examined.items() if why}
        if not unfit:
            return ""
        address, why = next(iter(unfit.items()))
        return (
            f"{len(unfit)} of {len(self._examined)} workers get no work from this server: {address} {why}. "
            "Install the same versions on server and workers."
        )

    def _examine(self, new: list[str]) -> None:
        """Compare versions, then sources: nothing of ours is sent to a worker whose versions differ."""
        from distributed.versions import get_versions

        message = {"op": "versions", "packages": fitness.PACKAGES}
        answers = self._client.sync(
            self._client.scheduler.broadcast,
            msg=message,
            workers=new,
            on_error="ignore",
            callback_timeout=ANSWER_S,
        )
        here = fitness.versions_of(get_versions(fitness.PACKAGES))
        # One that does not answer is asked again at the next look.
        differing = {a: fitness.differences(here, fitness.versions_of(answer)) for a, answer in answers.items()}
        self._examined |= {a: f"has {words}" for a, words in differing.items() if words}
        if alike := [a for a, words in differing.items() if not words]:
            self._examined |= self._compare_sources(alike)

    def _compare_sources(self, workers: list[str]) -> dict[str, str]:
        found = self._client.run(fitness.sources, workers=workers, on_error="return")
        own = fitness.sources()
        return {
            a: ""
            if there == own
            else "has other sources of this program under the same version"
            if isinstance(there, str)
            else f"cannot load this program ({there!r})"
            for a, there in found.items()
        }

    def submit(self, block: work.Block, worker: str) -> Future:
        """Send a block to a worker."""
        return self._client.submit(
            work.run_on_worker, block, self._topic, key=block.token, workers=[worker], pure=False
        )

    def warm_up(self, worker: str) -> Future:
        """Compile the kernels on a worker, or load them from the cache."""
        return self._client.submit(work.warm_up, workers=[worker], pure=False)

    def fault_of_kernel_folder(self, worker: str) -> Future:
        """Ask a worker why it cannot keep compiled kernels."""
        return self._client.submit(work.fault_of_kernel_folder, workers=[worker], pure=False)

    def signal_cancel(self, tokens: Iterable[str]) -> None:
        """Tell all workers to leave these blocks at their next look; waits for their answer."""
        # Runs in the workers' event loops, beside the computation: a look at the set costs nothing there.
        self._client.run(work.cancel, list(tokens), on_error="ignore")

    def restart(self, worker: str) -> None:
        """Kill a worker that does not come back; its nanny starts a new one under another address."""
        # Dask's own restart asks politely for four seconds first. A worker without a nanny cannot be restarted.
        self._client.run(_kill, workers=[worker], nanny=True, on_error="ignore")

    @property
    def is_restarting(self) -> bool:
        """Whether nannies of our own cluster are at work, each of which starts its worker again when that has ended."""
        if self._local is None:
            return False
        return any(n.status.name in ("init", "starting", "running") for n in list(self._local.workers.values()))

    def heal(self) -> bool:
        """Start the workers of our own cluster again where all are gone; False where that is not ours to do."""
        if self._local is None:
            return False
        self._local.scale(0)
        self._local.scale(self._size)
        return True

    def close(self, tokens: list[str]) -> None:
        """End the connection, and the workers that are ours; blocks under way (`tokens`) are given up."""
        if self._local is None and tokens:
            hint = threading.Thread(target=self.signal_cancel, args=(tokens,), daemon=True)
            hint.start()
            # A worker that hangs does not answer.
            hint.join(SIGNAL_S)
        self._client.close(timeout=CLOSE_S)
        if self._local is not None:
            with contextlib.suppress(TimeoutError):
                self._local.sync(_end, list(self._local.workers.values()), callback_timeout=CLOSE_S)
            self._local.close(timeout=CLOSE_S)


async def _end(nannies: list[Nanny]) -> None:
    """Kill our own workers; Dask's way out asks each of them politely for up to four seconds."""
    closing = [asyncio.ensure_future(nanny.close()) for nanny in nannies]
    # Each begins to close now: a nanny that does not would start another worker.
    await asyncio.sleep(0)
    for nanny in nannies:
        _kill(nanny)
    await asyncio.gather(*closing)


def _kill(dask_worker: Nanny) -> None:
    """Kill the worker of a nanny; run in a nanny, Dask gives it as `dask_worker`."""
    if dask_worker.pid is not None:
        os.kill(dask_worker.pid, signal.SIGKILL)


def _local_cluster(settings: Settings) -> LocalCluster:
    from distributed import LocalCluster
    from distributed.security import Security

    scratch = settings.data_dir / "scratch"
    scratch.mkdir(parents=True, exist_ok=True, mode=0o700)
    memory = memory_of_worker(settings.worker_memory_bytes, settings.workers)
    return LocalCluster(
        n_workers=settings.workers,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        # A loopback port is open to every user of the machine: only who has this certificate gets in.
        protocol="tls://",
        security=Security.temporary(),
        dashboard_address="127.0.0.1:0",
        local_directory=str(scratch),
        silence_logs=logging.ERROR,
        # The limit is ours (see `backend.jobs.worker_memory`). Dask's would also stop giving blocks to a worker that
        # is four fifths full, and the engine would wait for it.
        memory_limit=0,
        # Ctrl-C in a terminal reaches the whole group; only the server decides when to end.
        # A worker told to stop between two heartbeats logs a traceback as an error; what concerns a run comes back
        # with its block, and lost workers are the engine's to report.
        preload=[
            "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)",
            "import logging; logging.getLogger('distributed.worker').setLevel(logging.CRITICAL)",
            "from backend.jobs.worker_memory import keep_freed_memory; keep_freed_memory()",
            f"from backend.jobs.worker_memory import limit_memory; limit_memory({memory})",
        ],
        env={} if settings.kernel_cache is None else {"FILTERROOM_KERNEL_CACHE": str(settings.kernel_cache)},
    )


def _connected(settings: Settings) -> Client:
    from distributed import Client

    security = _security(settings)
    try:
        # Versions are compared by `Cluster._examine`, worker by worker; Dask would only warn.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return Client(settings.scheduler, security=security, timeout=CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise _away(settings.scheduler, error) from error


def _away(address: str, error: Exception) -> UnavailableError:
    why = " ".join(str(error).split()).rstrip(".") or "no answer"
    return UnavailableError(
        f"The scheduler {address} does not answer: {why}.",
        remedy="Start it or correct FILTERROOM_SCHEDULER; the server tries again by itself, and runs wait.",
        code="scheduler_unreachable",
    )


def _security(settings: Settings) -> Any:
    from distributed.security import Security

    if settings.scheduler.startswith("tcp://"):
        return Security(require_encryption=False)
    files = {"tls_ca_file": settings.tls_ca, "tls_client_cert": settings.tls_cert, "tls_client_key": settings.tls_key}
    for path in files.values():
        if path is None or not path.is_file():
            raise StateError(
                f"The certificate file {path} is not there.",
                remedy="Give PEM files in FILTERROOM_TLS_CA, FILTERROOM_TLS_CERT and FILTERROOM_TLS_KEY.",
                code="scheduler_address",
            )
    return Security(require_encryption=True, **{name: str(path) for name, path in files.items()})
