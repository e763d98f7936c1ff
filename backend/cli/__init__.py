"""The command line: `filterroom serve`, `run`, `study`, `algorithms`, `backup`, `migrate`, `openapi`.

Exit status: 0 done, 1 failed, 2 wrong usage. Everything heavy is imported by the command that needs it.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from backend.cli import run, study
from backend.cli.serve import serve
from backend.cli.terminal import FAILED, USAGE, UsageError, report
from backend.cli.upkeep import algorithms, backup, migrate, openapi

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit status."""
    from algorithms.errors import FilterRoomError

    options = _parser().parse_args(arguments)
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except UsageError as error:
        return report(options, str(error), "usage", USAGE)
    except FilterRoomError as error:
        return report(options, str(error), error.code, FAILED)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return report(options, f"{where}{error.strerror or error}", "os_error", FAILED)
    except KeyboardInterrupt:
        return report(options, "Interrupted; nothing was written.", "interrupted", FAILED)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="filterroom", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, command: Callable[[argparse.Namespace], int], words: str) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=words, description=words)
        added.set_defaults(command=command)
        added.add_argument("--json", action="store_true", help="print for scripts: JSON, errors too")
        return added

    serving = add("serve", serve, "Start the server and print its address.")
    serving.add_argument("--host", help="address to listen on (default 127.0.0.1)")
    serving.add_argument("--port", type=int, help="port to listen on; 0 takes a free one (default 8000)")
    serving.add_argument("--workers", type=int, help="worker processes (default: one per processor)")
    serving.add_argument("--no-samples", action="store_true", help="do not import the bundled sample")
    serving.add_argument("--insecure-no-token", action="store_true", help="serve everybody who can reach the address")
    run.add_arguments(add("run", run.run, "Run an algorithm on a recording, without a server."))
    study.add_arguments(add("study", study.study, "Reproduce a figure of a paper, without a server."))
    add("algorithms", algorithms, "List the algorithms.")
    migrating = add("migrate", migrate, "Bring the database to the tables of this version.")
    packing = add("backup", backup, "Pack the data folder into one file, also while a server uses it.")
    packing.add_argument("file", type=Path, metavar="FILE", help="archive to write: .tar, or .tar.gz to compress it")
    add("openapi", openapi, "Print the description of the HTTP API.")
    for command in (serving, migrating, packing):
        command.add_argument("--data", type=Path, metavar="DIR", help="data folder")
    return parser
