"""Disks that refuse: a small one that can be filled, and one that takes no changes. Both have to be mounted."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


def _mount(*words: str) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root can mount a disk")
    done = subprocess.run(["mount", *words], capture_output=True, text=True, timeout=20, check=False)
    if done.returncode != 0:
        pytest.skip(f"no disk can be mounted here: {done.stderr.strip()}")


def _unmount(folder: Path) -> None:
    # Lazily: somebody may still hold a file open.
    subprocess.run(["umount", "--lazy", str(folder)], capture_output=True, timeout=20, check=True)


@contextmanager
def small_disk(folder: Path, size_mib: int) -> Iterator[Path]:
    """Mount a disk of this size at a new folder."""
    folder.mkdir()
    _mount("-t", "tmpfs", "-o", f"size={size_mib}m", "tmpfs", str(folder))
    try:
        yield folder
    finally:
        _unmount(folder)


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """Let nobody change a folder from now on; files that are open already can still be written."""
    _mount("--bind", str(folder), str(folder))
    try:
        _mount("-o", "remount,ro,bind", str(folder))
        yield
    finally:
        _unmount(folder)


@contextmanager
def filled(folder: Path, left: int = 0) -> Iterator[None]:
    """Fill the disk of a folder until so many bytes are left; in the end the space is free again."""
    filler = folder / "filler"
    try:
        with filler.open("wb", buffering=0) as out:
            free = os.statvfs(folder)
            size = free.f_bavail * free.f_frsize - left
            while size > 0:
                try:
                    size -= out.write(bytes(min(size, 2**16)))
                except OSError:
                    break
        yield
    finally:
        filler.unlink(missing_ok=True)
