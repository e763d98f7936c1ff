"""Large pieces of memory go back to the system as soon as they are free.

glibc raises the size from which it maps a block by itself to that of the largest one that was freed. Arrays of a long
recording then come from heaps that every thread has, and leave holes there: a server that has drawn its charts kept
half a gigabyte. With a fixed size they do not.
"""

from __future__ import annotations

import contextlib
import ctypes
import sys

_M_MMAP_THRESHOLD = -3
_LARGE_BYTES = 4 << 20


def give_back_large_blocks() -> None:
    """Have this process map blocks from 4 MiB on by themselves; other C libraries than glibc have nothing to set."""
    if sys.platform == "linux":
        with contextlib.suppress(AttributeError, OSError):
            ctypes.CDLL(None).mallopt(_M_MMAP_THRESHOLD, _LARGE_BYTES)
