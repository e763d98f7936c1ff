"""Wakes the streams of events when the database changed, without a thread or a poll per stream."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager


class Changes:
    """`notify` may be called from any thread; `woken` gives a stream its own flag."""

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._flags: set[asyncio.Event] = set()
        self.closed = False

    def attach(self, loop: asyncio.AbstractEventLoop) -> None:
        """Name the event loop in which the streams live."""
        self._loop = loop

    def notify(self) -> None:
        """Wake every stream."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._set_all)

    def close(self) -> None:
        """Let every stream end: a server that stops does not wait for browsers that listen."""
        self.closed = True
        self.notify()

    @contextmanager
    def woken(self) -> Iterator[asyncio.Event]:
        """Give a flag that `notify` sets until the block ends."""
        flag = asyncio.Event()
        self._flags.add(flag)
        try:
            yield flag
        finally:
            self._flags.discard(flag)

    def _set_all(self) -> None:
        for flag in self._flags:
            flag.set()
