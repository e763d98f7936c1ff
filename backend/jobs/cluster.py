"""Dask behind five verbs: list the workers, submit to one, signal, restart one, close.

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
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from backend.errors import StateError
from backend.jobs import work
from backend.settings import Settings

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster, Nanny

logger = logging.getLogger(__name__)

# Seconds that a scheduler may take to answer when we connect, workers to hear that their blocks are given up, and
# connections and workers to end.
CONNECT_S = 10
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
}


class Cluster:
    """A Dask cluster: worker processes of our own, or an existing scheduler.

    `on_progress(token, share)` is called from Dask's thread.
    """

    def __init__(self, settings: Settings, on_progress: Callable[[str, float], None]) -> None:
        import dask.config
        from distributed import Client

        self._topic = f"filterroom-{secrets.token_hex(8)}"
        self._local: LocalCluster | None = None
        self._size = settings.workers
        # For the whole process: Dask reads some of it long after the start.
        dask.config.set(_CONFIG)
        if settings.scheduler:
            self._client: Client = Client(
                settings.scheduler, security=_security(settings), timeout=CONNECT_S, set_as_default=False
            )
        else:
            self._local = _local_cluster(settings)
            self._client = Client(self._local, set_as_default=False)

        def progress(event: tuple[float, dict[str, Any]]) -> None:
            on_progress(event[1]["token"], event[1]["share"])

        self._client.subscribe_topic(self._topic, progress)

    def workers(self) -> dict[str, int]:
        """Return the workers that are there now: {address: threads}."""
        return {str(a): int(n) for a, n in self._client.nthreads().items()}

    def submit(self, block: work.Block, worker: str) -> Future:
        """Send a block to a worker."""
        return self._client.submit(
            work.run_on_worker, block, self._topic, key=block.token, workers=[worker], pure=False
        )

    def warm_up(self, worker: str) -> Future:
        """Compile the kernels on a worker, or load them from the cache."""
        return self._client.submit(work.warm_up, workers=[worker], pure=False)

    def signal_cancel(self, tokens: Iterable[str]) -> None:
        """Tell all workers to leave these blocks at their next look; waits for their answer."""
        # Runs in the workers' event loops, beside the computation: a look at the set costs nothing there.
        self._client.run(work.cancel, list(tokens), on_error="ignore")

    def restart(self, worker: str) -> None:
        """Kill a worker that does not come back; its nanny starts a new one under another address."""
        # Dask's own restart asks politely for four seconds first. A worker without a nanny cannot be restarted.
        self._client.run(_kill, workers=[worker], nanny=True, on_error="ignore")

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
        # Ctrl-C in a terminal reaches the whole group; only the server decides when to end.
        # A worker told to stop between two heartbeats logs a traceback as an error; what concerns a run comes back
        # with its block, and lost workers are the engine's to report.
        preload=[
            "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)",
            "import logging; logging.getLogger('distributed.worker').setLevel(logging.CRITICAL)",
        ],
        env={} if settings.kernel_cache is None else {"FILTERROOM_KERNEL_CACHE": str(settings.kernel_cache)},
    )


def _security(settings: Settings) -> Any:
    from distributed.security import Security

    if not settings.scheduler.startswith("tls://"):
        raise StateError(
            f"The scheduler {settings.scheduler!r} would get work unencrypted.",
            remedy="Give an address that begins with tls://",
            code="scheduler_address",
        )
    return Security(
        tls_ca_file=str(settings.tls_ca),
        tls_client_cert=str(settings.tls_cert),
        tls_client_key=str(settings.tls_key),
        require_encryption=True,
    )
