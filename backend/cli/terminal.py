"""What every command shares: exit statuses, errors for people and for scripts, settings, the progress bar."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from backend.settings import Settings

DONE, FAILED, USAGE = 0, 1, 2

_BAR_CELLS = 30
# Seconds between two drawings of the bar.
_REDRAW_S = 0.1


class UsageError(Exception):
    """The command line or the environment asks for something that cannot be."""


def report(options: argparse.Namespace, detail: str, code: str, status: int) -> int:
    """Say what went wrong, for people or for scripts, and return the exit status."""
    if options.json:
        print(json.dumps({"error": {"code": code, "detail": detail}}))
    else:
        print(f"filterroom: {detail}", file=sys.stderr)
    return status


def settings_of(**given: Any) -> Settings:
    """Return the settings: arguments win over the environment."""
    from pydantic import ValidationError

    from backend.settings import Settings

    try:
        # Compared by identity: 0 equals False, and port 0 means any free one.
        return Settings(**{name: v for name, v in given.items() if v is not None and v is not False})
    except ValidationError as error:
        first = error.errors()[0]
        name = "_".join(str(p) for p in first["loc"])
        message = str(first["msg"]).removeprefix("Value error, ")
        named = f"FILTERROOM_{name.upper()} (or --{name.replace('_', '-')}): " if name else ""
        raise UsageError(f"{named}{message}") from error


def tell(text: str) -> None:
    """Say something beside the result."""
    print(text, file=sys.stderr)


class ProgressBar:
    """A bar on the standard error of a terminal, and nothing at all where that is a file or a pipe."""

    def __init__(self, words: str) -> None:
        self._words = words
        self._shown = sys.stderr.isatty()
        self._started = time.monotonic()
        self._next = 0.0

    def __enter__(self) -> ProgressBar:
        self.show(0.0)
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away, so that what follows begins on a clean line."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def show(self, share: float) -> None:
        """Draw the finished share, 0 to 1."""
        at = time.monotonic()
        if not self._shown or at < self._next:
            return
        self._next = at + _REDRAW_S
        done = round(_BAR_CELLS * min(max(share, 0.0), 1.0))
        bar = "#" * done + "." * (_BAR_CELLS - done)
        line = f"{self._words} [{bar}] {share:4.0%} {at - self._started:.0f} s"
        # A line that the terminal wraps could not be drawn over.
        sys.stderr.write("\r" + line[: shutil.get_terminal_size().columns - 1] + "\x1b[K")
        sys.stderr.flush()
