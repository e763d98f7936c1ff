"""`filterroom serve`: settings, the listening socket, the address that is printed."""

from __future__ import annotations

import argparse
import errno
import json
import logging
import os
import socket
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING
from urllib.parse import quote

from backend.cli.large_blocks import give_back_large_blocks
from backend.cli.terminal import UsageError, settings_of

if TYPE_CHECKING:
    from backend.settings import Settings


def serve(options: argparse.Namespace) -> int:
    """Serve until the process is told to end."""
    settings = settings_of(
        host=options.host,
        port=options.port,
        data_dir=options.data,
        workers=options.workers,
        insecure_no_token=options.insecure_no_token,
    )
    if options.no_samples:
        settings = settings.model_copy(update={"samples": False})
    if not (settings.is_loopback or settings.has_own_token or settings.insecure_no_token):
        raise UsageError(
            f"{settings.host} can be reached from other machines, so it needs a token of yours: set FILTERROOM_TOKEN "
            "or FILTERROOM_TOKEN_FILE, or say --insecure-no-token to serve everybody."
        )
    _log_to_stderr()
    listening = _listen(settings)
    give_back_large_blocks()
    # A client that connects from now on waits in the socket's queue until the server is up.
    from backend.server import Server

    with listening:
        return Server(settings, listening, _announcement(settings, listening, options.json)).serve()


def _listen(settings: Settings) -> socket.socket:
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    # Named, or asyncio leaves Nagle's algorithm on: each answer in two pieces then waits 40 ms for the client's kernel.
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((settings.host, settings.port))
        listening.listen(128)
    except OSError as error:
        listening.close()
        if error.errno == errno.EADDRINUSE:
            reason = "Something else listens there already: stop it, or choose another port with --port."
        elif error.errno == errno.EACCES:
            reason = "Ports below 1024 need special rights: choose another one with --port."
        else:
            reason = f"{error.strerror or error}."
        raise _failure(f"{settings.host} port {settings.port} cannot be used. {reason}") from error
    return listening


def _failure(message: str) -> Exception:
    from backend.errors import StateError

    return StateError(message, code="port")


def _announcement(settings: Settings, listening: socket.socket, as_json: bool) -> Callable[[], None]:
    port = listening.getsockname()[1]
    host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(settings.host, settings.host)  # noqa: S104
    host = f"[{host}]" if ":" in host and not host.startswith("[") else host
    token = None if settings.insecure_no_token else settings.read_token()
    url = f"http://{host}:{port}/" + ("" if token is None else f"?token={quote(token, safe='')}")

    def announce() -> None:
        print(json.dumps({"url": url, "port": port, "pid": os.getpid()}) if as_json else url, flush=True)

    return announce


def _log_to_stderr() -> None:
    logging.basicConfig(
        stream=sys.stderr, level=logging.INFO, format="%(asctime)s %(levelname)-7s %(name)s: %(message)s"
    )
    # These tell of every step of their own.
    os.environ.setdefault("DASK_LOGGING__DISTRIBUTED", "warning")
    for name in ("alembic", "uvicorn.error", "asyncio"):
        logging.getLogger(name).setLevel(logging.WARNING)
