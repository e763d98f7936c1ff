"""A PostgreSQL server of its own for the tests: a cluster in a temporary folder, reachable by a Unix socket only."""

from __future__ import annotations

import os
import pwd
import secrets
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psycopg
import pytest

ROOT = Path(__file__).parent.parent
# The newest of what Debian installed or scripts/provide.sh unpacked; names such as 15 and 17 sort as they should.
INSTALLED = ("usr/lib/postgresql/*/bin/initdb", ".tools/postgresql/usr/lib/postgresql/*/bin/initdb")


@dataclass
class PostgreSQL:
    """A server that can be stopped and started."""

    programs: Path
    folder: Path

    def start(self) -> None:
        settings = f"-c listen_addresses= -c unix_socket_directories={self.folder} -c fsync=off -c max_connections=60"
        self.run("pg_ctl", "-D", "data", "-l", "log", "-w", "-o", settings, "start")

    def stop(self) -> None:
        self.run("pg_ctl", "-D", "data", "-m", "immediate", "-w", "stop")

    def run(self, program: str, *arguments: str) -> None:
        """Run one of its programs, not as root, which the server refuses to be."""
        command = [str(self.programs / program), *arguments]
        # What it starts must not hold a pipe of ours open.
        with (self.folder / f"{program}.out").open("w+") as out:
            done = subprocess.run(
                command, cwd=self.folder, env=_environment(), stdout=out, stderr=out, check=False, **_ordinary_user()
            )
            out.seek(0)
            assert done.returncode == 0, out.read()

    def url(self, database: str = "postgres") -> str:
        return f"postgresql://filterroom@/{database}?host={self.folder}"

    def admin(self, statement: str) -> list[Any]:
        """Run a statement outside of the program."""
        with psycopg.connect(self.url(), autocommit=True) as connection:
            done = connection.execute(statement)  # type: ignore[call-overload]
            return done.fetchall() if done.description else []

    @contextmanager
    def database(self, template: str = "template1") -> Iterator[str]:
        """Give the address of a new database; it goes at the end, with whoever is still in it."""
        name = f"t{secrets.token_hex(6)}"
        self.admin(f"CREATE DATABASE {name} TEMPLATE {template}")
        try:
            yield self.url(name)
        finally:
            self.admin(f"DROP DATABASE {name} WITH (FORCE)")


@contextmanager
def running() -> Iterator[PostgreSQL]:
    """Start a server of its own; skip where there is none, but not in CI."""
    programs = _programs()
    if programs is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(
            "PostgreSQL is not installed: sh scripts/test provides it"
        )
    # pytest's own folders are closed to the ordinary user that the server runs as.
    folder = Path(tempfile.mkdtemp(prefix="filterroom-"))
    server = PostgreSQL(programs, folder)
    try:
        if user := _ordinary_user():
            os.chown(folder, user["user"], user["group"])
        server.run(
            "initdb", "-D", "data", "-U", "filterroom", "--auth=trust", "--encoding=UTF8", "--locale=C", "--no-sync"
        )
        server.start()
        yield server
        server.stop()
    finally:
        shutil.rmtree(folder)


def _programs() -> Path | None:
    found = sorted([*Path("/").glob(INSTALLED[0]), *ROOT.glob(INSTALLED[1])], key=lambda p: p.parts[-3])
    on_path = shutil.which("initdb")
    return found[-1].parent if found else Path(on_path).parent if on_path else None


def _ordinary_user() -> dict[str, Any]:
    if os.geteuid() != 0:
        return {}
    for name in ("postgres", "nobody"):
        try:
            user = pwd.getpwnam(name)
        except KeyError:
            continue
        return {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
    pytest.fail("PostgreSQL refuses to run as root, and there is neither a user postgres nor nobody")


def _environment() -> dict[str, str]:
    libraries = [str(p) for p in sorted((ROOT / ".tools" / "postgresql" / "usr" / "lib").glob("*-linux-gnu"))]
    return {**os.environ, "LC_ALL": "C", **({"LD_LIBRARY_PATH": os.pathsep.join(libraries)} if libraries else {})}
