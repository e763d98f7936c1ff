"""How much memory a worker may take, and what it does with memory that it is given back.

A run that eats memory fails by itself, before the machine is out of it. The kernel counts what a process can write
(RLIMIT_DATA). The address space (RLIMIT_AS) would also count what is only reserved, such as an arena for every thread
and the code of every library: gigabytes on a machine of many cores. An allocation above the limit raises `MemoryError`
where it is asked for, so the worker lives to say why. Dask's own limit looks at the process every 0.1 s and ends it:
nothing tells that from a crash, and the block would be tried again.
"""

from __future__ import annotations

import contextlib
import ctypes
import resource
from pathlib import Path

# The rest is for the server, the reader of uploads and the system's cache of files.
SHARE = 0.8
# Compiling the kernels takes three quarters of this.
SMALLEST = 2**30
_STATM_DATA = 5

# Parameters of the C library's mallopt (malloc.h of glibc).
_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8
# What a worker keeps for the next batch of trials, and from which size on an array goes back at once all the same.
KEPT = 2**27
RETURNED = 2**25


def memory_of_worker(given: int | None, workers: int) -> int:
    """Return the bytes that one of `workers` may take: what the settings give, else its part of this machine's."""
    if given is not None:
        return given
    # Dask has read it where a container allows less than the machine has.
    from distributed.system import MEMORY_LIMIT

    return max(int(MEMORY_LIMIT * SHARE / workers), SMALLEST)


def keep_freed_memory() -> None:
    """Let the C library keep what is freed, for a worker asks for arrays of the same size batch after batch.

    Given back, each page has to be fetched from the kernel and cleared again: on trials that takes as long as the
    filter. Dask sets the opposite, MALLOC_TRIM_THRESHOLD_=65536, for workers that hold data between tasks. One arena,
    because only one thread computes. Elsewhere than in glibc nothing happens.
    """
    with contextlib.suppress(AttributeError, OSError):
        mallopt = ctypes.CDLL(None).mallopt
        for parameter, value in ((_ARENA_MAX, 1), (_TRIM_THRESHOLD, KEPT), (_MMAP_THRESHOLD, RETURNED)):
            mallopt(parameter, value)


def limit_memory(size_bytes: int) -> None:
    """Let what this process can write grow by this much."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[_STATM_DATA])
    limit = pages * resource.getpagesize() + size_bytes
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))


def lift_limit() -> None:
    """Give a worker that ran out of memory room to say so: what the algorithm keeps leaves none.

    The engine replaces it next.
    """
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (hard, hard))
