"""The HTTP server around the application: announces itself when it listens, and stops without waiting for listeners."""

from __future__ import annotations

import signal
import socket
from collections.abc import Callable
from types import FrameType

import uvicorn

from backend.app import create_app
from backend.settings import Settings

# A download under way may finish; a stream of events is closed at once.
_GRACE_S = 3


class _Uvicorn(uvicorn.Server):
    """Tells when it is up and when it is asked to stop."""

    def __init__(self, config: uvicorn.Config, on_started: Callable[[], None], on_stopping: Callable[[], None]) -> None:
        super().__init__(config)
        self._on_started = on_started
        self._on_stopping = on_stopping

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._on_started()

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self._on_stopping()
        super().handle_exit(sig, frame)


class Server:
    """Serves on a socket that listens already."""

    def __init__(self, settings: Settings, listening: socket.socket, announce: Callable[[], None]) -> None:
        app = create_app(settings)
        config = uvicorn.Config(
            app,
            log_config=None,
            # The address of the first page carries the token.
            access_log=False,
            server_header=False,
            lifespan="on",
            timeout_graceful_shutdown=_GRACE_S,
        )
        self._listening = listening
        self._server = _Uvicorn(config, announce, app.state.services.changes.close)

    def serve(self) -> int:
        """Serve until a signal comes; return the exit status."""
        # uvicorn raises the signal again after an orderly end; by then there is nothing left to interrupt.
        signal.signal(signal.SIGTERM, _ignore)
        signal.signal(signal.SIGINT, _ignore)
        self._server.run(sockets=[self._listening])
        return 0 if self._server.started else 1


def _ignore(number: int, frame: FrameType | None) -> None:
    """Do nothing."""
