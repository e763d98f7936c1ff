"""Compiled kernels that no program has used for a month are deleted: each edit of a kernel leaves folders behind.

Who uses a set of kernels says so once a day: before it loads them, it touches the set's mark (`KEY.complete`) and its
folders. Only what nobody touched for a month goes. All of this happens under one lock, so a set is either touched
before somebody looks for unused ones, or gone, mark and all, before its next user looks for it.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import time
from contextlib import suppress
from pathlib import Path

from algorithms.toolbox.kernels.cache import folder_of

DAY_S = 86_400.0
UNUSED_S = 30 * DAY_S
_SOURCES = Path(__file__).resolve().parent
# Folders of kernels and marks of complete sets; nothing else is ours to delete.
_OURS = re.compile(r"[0-9a-f]{16}(\.complete)?")


def is_fresh(mark: Path) -> bool:
    """Whether a set is complete and somebody said so, or used it, within a day."""
    try:
        return time.time() - mark.stat().st_mtime < DAY_S
    except FileNotFoundError:
        return False


def keep_used(base: Path, mark: Path) -> None:
    """Touch the folders of this program's kernels in `base`, and their mark where there is one; delete unused ones."""
    with (base / "unused.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for path in (mark, *{base / folder_of(source).name for source in _SOURCES.rglob("*.py")}):
            # There is a folder only of sources that define kernels, and a mark only after the first time.
            with suppress(FileNotFoundError):
                os.utime(path)
        oldest = time.time() - UNUSED_S
        for path in sorted(base.iterdir(), key=lambda path: path.is_dir()):
            if _OURS.fullmatch(path.name) and path.stat().st_mtime < oldest:
                if path.is_dir():
                    shutil.rmtree(path, ignore_errors=True)
                else:
                    path.unlink()
