"""Compile every kernel once, so that the first run of a user does not wait for the compiler.

A process that compiles a function runs the copies that stand alone; one that loads it from the cache runs the copies
that were put into their callers. Both are right, but they may differ in the last digit, so nobody computes in a process
that has compiled: `have_compiled` leaves that to a process of its own.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import re
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np

from algorithms.errors import CompilationError
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.cache import base_folder, key_of_all
from algorithms.unused_kernels import is_fresh, keep_used

# So many rows of a recording reach every kernel.
ROWS = 4
_ERROR_LINE = re.compile(r"^[\w.]*(?:Error|Exception|Interrupt)\b.*", re.M)


def warm_up(family: str | None = None) -> None:
    """Run, tabulate and score every algorithm (of `family`) on a few simulated rows; the kernels stay in the cache.

    Each algorithm gets the first scenario of its family that makes a recording it takes.
    """
    for algorithm in algorithms_by_name().values():
        if family not in (None, algorithm.family):
            continue
        fitting = (
            s for s in scenarios_by_name().values() if s.family == algorithm.family and s.kind in algorithm.takes
        )
        scenario = next(fitting, None)
        if scenario is None:
            continue
        recording = scenario.simulate(scenario.parameters(), (0,), 0)
        recording = recording.take(np.arange(min(ROWS, len(recording))))
        parameters = algorithm.parameters()
        result = algorithm.run(recording, parameters, LocalContext())
        algorithm.tabulate(recording, result)
        if algorithm.score is not None:
            algorithm.score(recording, parameters, LocalContext())
        if algorithm.bound is not None:
            algorithm.bound(recording, parameters)


@cache
def have_compiled() -> None:
    """Return when every kernel is in the cache; where they are not, have each family compiled by another process.

    Several processes that ask at once wait for the one that compiles. Where the cache folder cannot be written each
    process compiles for itself, and results repeat to the ninth digit only.

    Raises
    ------
    CompilationError
        Compiling failed.
    """
    folder = base_folder()
    done = folder / f"{key_of_all()}.complete"
    if fault_of_folder() or is_fresh(done):
        return
    with (folder / f"{key_of_all()}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if is_fresh(done):
            return
        keep_used(folder, done)
        if done.exists():
            return
        families = sorted({algorithm.family for algorithm in algorithms_by_name().values()})
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            for family, said in zip(families, threads.map(_compile, families), strict=True):
                if said:
                    raise compilation_error(family, said)
        done.touch()


def fault_of_folder() -> str:
    """Say in words that compiled kernels cannot be kept, what that costs and what to do; empty where they can."""
    folder = base_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        why = "" if os.access(folder, os.W_OK) else "no permission to write"
    except OSError as error:
        why = error.strerror or str(error)
    if not why:
        return ""
    return (
        f"Compiled kernels cannot be kept in {folder}: {why}. Each worker compiles them anew at its start, which takes "
        "minutes, and results repeat to the ninth digit only. Make the folder writable or set FILTERROOM_KERNEL_CACHE "
        "to one that is, and restart the server."
    )


def compilation_error(family: str, said: str) -> CompilationError:
    """Return the error for what a compiler said: its first line in the message, all of it in a note."""
    found = _ERROR_LINE.search(said)
    short = (found.group() if found else said.strip().splitlines()[-1])[:300].rstrip(".")
    error = CompilationError(
        f"The kernels of {family} cannot be compiled: {short}.",
        remedy=(
            "The server's log holds all that the compiler said. Look for free space and memory, install the program "
            "with the versions of numba and llvmlite that it names, and restart the server."
        ),
    )
    error.add_note(said)
    return error


def _compile(family: str) -> str:
    """Warm `family` up in a process of its own; return what it said if it failed, else nothing."""
    found = subprocess.run(
        [sys.executable, "-c", "from algorithms.warm_up import warm_up; warm_up(input())"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        input=family,
        capture_output=True,
        text=True,
        preexec_fn=_end_with_parent,
        check=False,
    )
    return found.stderr.strip()[-20_000:] or f"status {found.returncode}" if found.returncode else ""


def _end_with_parent() -> None:
    """Have Linux end this process with the one that started it: a server that is killed leaves no compiler behind."""
    if sys.platform == "linux":
        pr_set_pdeathsig = 1
        ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)
