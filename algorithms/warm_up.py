"""Compile every kernel once, so that the first run of a user does not wait for the compiler.

A process that compiles a function runs the copies that stand alone; one that loads it from the cache runs the copies
that were put into their callers. Both are right, but they may differ in the last digit, so nobody computes in a process
that has compiled: `have_compiled` leaves that to a process of its own.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import signal
import subprocess
import sys
from functools import cache

import numpy as np

from algorithms.recording import ToaMarks
from algorithms.registry import algorithms_by_name
from algorithms.site import Site
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.cache import kernel_cache_folder

_SITE = {
    "origin": {"latitude_deg": 55.0, "longitude_deg": 37.0},
    "stations": [
        {"name": "1", "east_m": 5000, "north_m": 8660, "up_m": 15},
        {"name": "2", "east_m": 5000, "north_m": -8660, "up_m": 15},
        {"name": "3", "east_m": -10000, "north_m": 0, "up_m": 15},
        {"name": "4", "east_m": 0, "north_m": 0, "up_m": 15},
    ],
}


def warm_up() -> None:
    """Run, tabulate and score every algorithm on a few marks; the compiled kernels stay in the kernel cache."""
    site = Site.model_validate(_SITE)
    marks = 4
    truth = np.stack([30_000.0 + 200 * np.arange(marks), np.full(marks, 9_000.0), np.full(marks, 8_000.0)], axis=1)
    toa = np.linalg.norm(truth[:, None] - site.station_positions(), axis=2) / 299_792_458.0
    recording = ToaMarks(
        time_s=np.arange(marks, dtype=float),
        row=np.arange(1, marks + 1),
        target=np.zeros(marks, np.int64),
        truth_m=truth,
        site=site,
        toa_s=toa[:, :, None],
        altitude_m=np.full((marks, 1), 8_090.0),
        stations=tuple(s.name for s in site.stations),
    )
    for algorithm in algorithms_by_name().values():
        if recording.kind in algorithm.takes:
            result = algorithm.run(recording, algorithm.parameters(), LocalContext())
            algorithm.tabulate(recording, result)
            if algorithm.score is not None:
                algorithm.score(recording, algorithm.parameters(), LocalContext())
            if algorithm.bound is not None:
                algorithm.bound(recording, algorithm.parameters())


@cache
def have_compiled() -> None:
    """Return when every kernel is in the cache; where they are not, have them compiled by another process.

    Several processes that ask at once wait for the one that compiles. Where the cache folder cannot be written each
    process compiles for itself, and results repeat to the ninth digit only.

    Raises
    ------
    RuntimeError
        Compiling failed; the message holds what the compiler said.
    """
    folder = kernel_cache_folder()
    done = folder / "complete"
    if done.exists() or not os.access(folder, os.W_OK):
        return
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if done.exists():
            return
        found = subprocess.run(
            [sys.executable, "-c", "from algorithms.warm_up import warm_up; warm_up()"],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            preexec_fn=_end_with_parent,
            check=False,
        )
        if found.returncode != 0:
            raise RuntimeError(f"the kernels cannot be compiled: {found.stderr.strip()[-2000:]}")
        done.touch()


def _end_with_parent() -> None:
    """Have Linux end this process with the one that started it: a server that is killed leaves no compiler behind."""
    if sys.platform == "linux":
        pr_set_pdeathsig = 1
        ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)
