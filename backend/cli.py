"""The command line: `filterroom serve`, `algorithms`, `backup`, `migrate`, `openapi`.

Exit status: 0 done, 1 failed, 2 wrong usage. Everything heavy is imported by the command that needs it.
"""

from __future__ import annotations

import argparse
import errno
import json
import logging
import os
import socket
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

if TYPE_CHECKING:
    from backend.settings import Settings

DONE, FAILED, USAGE = 0, 1, 2


class UsageError(Exception):
    """The command line or the environment asks for something that cannot be."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit status."""
    from algorithms.errors import FilterRoomError

    options = _parser().parse_args(arguments)
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except UsageError as error:
        return _report(options, str(error), "usage", USAGE)
    except FilterRoomError as error:
        return _report(options, str(error), error.code, FAILED)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _report(options, f"{where}{error.strerror or error}", "os_error", FAILED)
    except KeyboardInterrupt:
        return FAILED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="filterroom", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, command: Callable[[argparse.Namespace], int], words: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=words, description=words)
        added.set_defaults(command=command)
        added.add_argument("--json", action="store_true", help="print for scripts: JSON, errors too")
        return added

    serve = add("serve", _serve, "Start the server and print its address.")
    serve.add_argument("--host", help="address to listen on (default 127.0.0.1)")
    serve.add_argument("--port", type=int, help="port to listen on; 0 takes a free one (default 8000)")
    serve.add_argument("--workers", type=int, help="worker processes (default: one per processor)")
    serve.add_argument("--no-samples", action="store_true", help="do not import the bundled sample")
    serve.add_argument("--insecure-no-token", action="store_true", help="serve everybody who can reach the address")
    listing = add("algorithms", _algorithms, "List the algorithms.")
    migrate = add("migrate", _migrate, "Bring the database to the tables of this version.")
    backup = add("backup", _backup, "Pack the data folder into one file, also while a server uses it.")
    backup.add_argument("file", type=Path, metavar="FILE", help="archive to write: .tar, or .tar.gz to compress it")
    add("openapi", _openapi, "Print the description of the HTTP API.")
    for command in (serve, migrate, backup):
        command.add_argument("--data", type=Path, metavar="DIR", help="data folder")
    listing.set_defaults(data=None)
    return parser


def _report(options: argparse.Namespace, detail: str, code: str, status: int) -> int:
    if options.json:
        print(json.dumps({"error": {"code": code, "detail": detail}}))
    else:
        print(f"filterroom: {detail}", file=sys.stderr)
    return status


def _settings(**given: Any) -> Settings:
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


def _serve(options: argparse.Namespace) -> int:
    settings = _settings(
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


def _algorithms(options: argparse.Namespace) -> int:
    from algorithms.registry import algorithms_by_name

    found = algorithms_by_name().values()
    if options.json:
        items = [
            {"name": a.name, "title": a.title, "family": a.family, "takes": list(a.takes), "summary": a.summary}
            for a in found
        ]
        print(json.dumps({"items": items}, indent=2, ensure_ascii=False))
        return DONE
    width = max((len(a.name) for a in found), default=0)
    for algorithm in found:
        print(f"{algorithm.name:<{width}}  {algorithm.title}")
    return DONE


def _migrate(options: argparse.Namespace) -> int:
    from backend.db.engine import Database
    from backend.db.migrate import upgrade
    from backend.files.lock import DataFolderLock

    settings = _settings(data_dir=options.data)
    with DataFolderLock(settings.data_dir):
        database = Database(settings.url)
        try:
            upgrade(database)
        finally:
            database.close()
    where = settings.data_dir if not settings.database_url else "the given database"
    print(json.dumps({"migrated": True}) if options.json else f"{where} is up to date.")
    return DONE


def _backup(options: argparse.Namespace) -> int:
    from backend.backup import back_up

    settings = _settings(data_dir=options.data)
    if settings.database_url:
        raise UsageError(
            "FILTERROOM_DATABASE_URL names a database of its own: back it up with its tools, such as pg_dump, and then "
            f"copy the folder {settings.store_dir}; delete nothing in between."
        )
    done = back_up(settings.data_dir, options.file)
    lost = {"missing": list(done.missing), "damaged": list(done.damaged)}
    if options.json:
        print(json.dumps({"file": str(options.file), "files": done.files, "bytes": done.size_bytes, **lost}))
    else:
        print(f"{options.file}: the database and {done.files} files, {done.size_bytes / 2**20:.1f} MiB.")
        for what, hashes in lost.items():
            if hashes:
                print(f"filterroom: {len(hashes)} stored files are {what}: {', '.join(hashes)}", file=sys.stderr)
    return FAILED if done.missing or done.damaged else DONE


def _openapi(options: argparse.Namespace) -> int:
    from backend.app import api_description

    print(json.dumps(api_description(), indent=2, ensure_ascii=False))
    return DONE


if __name__ == "__main__":
    sys.exit(main())
