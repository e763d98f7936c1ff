"""A real server: `filterroom serve` as a process of its own, on a free port, with its own data folder."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import pytest

TOKEN = "token-of-the-tests"
FINAL = ("succeeded", "failed", "cancelled")


@dataclass
class ServerProcess:
    """A running server."""

    url: str
    process: subprocess.Popen[str]
    data: Path
    log: Path

    def client(self, **options: Any) -> httpx2.Client:
        headers = {"Authorization": f"Bearer {TOKEN}", **options.pop("headers", {})}
        return httpx2.Client(base_url=self.url, headers=headers, timeout=60, **options)

    def stop(self) -> int:
        if self.process.poll() is None:
            self.process.terminate()
        try:
            return self.process.wait(30)
        finally:
            self.process.kill()
            if self.process.stdout is not None:
                self.process.stdout.close()


def start_server(data: Path, *arguments: str, **environment: str) -> ServerProcess:
    """Start a server and wait until it listens; what it logged is in the failure."""
    log = data.with_suffix(".log")
    command = [sys.executable, "-m", "backend.cli", "serve", "--json", "--port", "0", "--data", str(data), *arguments]
    clean = {k: v for k, v in os.environ.items() if not k.startswith("FILTERROOM_")}
    with log.open("w") as out:
        process = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=out,
            text=True,
            env={**clean, "FILTERROOM_TOKEN": TOKEN, **environment},
            cwd=Path(__file__).parents[2],
        )
    assert process.stdout is not None
    line = process.stdout.readline()
    if '"url"' not in line:
        process.kill()
        process.wait(10)
        process.stdout.close()
        pytest.fail(f"the server did not start:\n{line}{log.read_text()}")
    return ServerProcess(json.loads(line)["url"].split("?")[0].rstrip("/"), process, data, log)


@pytest.fixture(scope="session")
def database_url(request: pytest.FixtureRequest) -> Iterator[str]:
    """What --database chooses; empty for SQLite in the data folder."""
    if request.config.getoption("--database") == "sqlite":
        yield ""
    else:
        with request.getfixturevalue("postgresql_server").database() as url:
            yield url


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory, database_url: str) -> Iterator[ServerProcess]:
    running = start_server(
        tmp_path_factory.mktemp("server") / "data",
        "--no-samples",
        "--workers",
        "1",
        FILTERROOM_MAX_UPLOAD_BYTES=str(16 * 2**20),
        FILTERROOM_ALLOWED_HOSTS="radar.example",
        FILTERROOM_DATABASE_URL=database_url,
    )
    yield running
    status = running.stop()
    log = running.log.read_text()
    assert status == 0, log
    assert "Traceback" not in log, log


@pytest.fixture(scope="session")
def api(server: ServerProcess) -> Iterator[httpx2.Client]:
    """A client with the token."""
    with server.client() as client:
        yield client


@pytest.fixture(scope="session")
def marks(repository: Path) -> bytes:
    return (repository / "examples" / "recordings" / "sample_marks.csv").read_bytes()


@pytest.fixture(scope="session")
def site(repository: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((repository / "examples" / "recordings" / "sample_site.json").read_text())
    return found


Upload = Callable[..., httpx2.Response]


@pytest.fixture(scope="session")
def upload(api: httpx2.Client, marks: bytes, site: dict[str, Any]) -> Upload:
    """Upload the sample, or something else, with a name of its own: what differs in options is another recording."""

    def send(
        name: str, *, data: bytes = marks, site: Mapping[str, Any] | None = site, **options: Any
    ) -> httpx2.Response:
        files = [("file", (f"{name}.csv", data, "text/csv"))]
        fields = {"options": json.dumps({"name": name, **options})}
        if site is not None:
            fields["site"] = json.dumps(site)
        return api.post("/api/v1/recordings", files=files, data=fields)

    return send


@pytest.fixture(scope="session")
def recording(api: httpx2.Client, upload: Upload) -> dict[str, Any]:
    """The sample as a recording that is ready."""
    answer = upload("sample")
    assert answer.status_code == 201, answer.text
    return ready(api, answer.headers["location"])


@pytest.fixture(scope="session")
def run(api: httpx2.Client, recording: dict[str, Any]) -> dict[str, Any]:
    """A run that succeeded."""
    body = {
        "recording_id": recording["id"],
        "algorithms": [{"name": "rdf"}, {"name": "rdfv", "label": "rdfv 50 m", "parameters": {"sigma_altitude_m": 50}}],
        "label": "finished",
        "tags": ["kept"],
    }
    return finished(api, api.post("/api/v1/runs", json=body).raise_for_status().headers["location"])


def ready(api: httpx2.Client, location: str, within_s: float = 120) -> dict[str, Any]:
    """Wait until a recording is read; where the machine is busy, the answer to an upload may not have waited for it."""
    deadline = time.monotonic() + within_s
    while (found := api.get(location).json())["state"] == "parsing":
        assert time.monotonic() < deadline, f"{location} is not read after {within_s} s"
        time.sleep(0.05)
    assert found["state"] == "ready", found
    return dict(found)


def finished(api: httpx2.Client, location: str, within_s: float = 120) -> dict[str, Any]:
    """Wait until a run is final."""
    deadline = time.monotonic() + within_s
    while time.monotonic() < deadline:
        found: dict[str, Any] = api.get(location).json()
        if found["state"] in FINAL:
            return found
        time.sleep(0.05)
    raise AssertionError(f"{location} is not finished after {within_s} s: {found}")


def problem(answer: httpx2.Response, status: int, code: str, pointer: str | None = None) -> dict[str, Any]:
    """Check that an answer is a complete problem of this kind."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    found: dict[str, Any] = answer.json()
    assert found["code"] == code, found
    assert found["type"] == f"/problems/{code}"
    assert found["status"] == status
    assert found["title"]
    assert found["detail"]
    assert found["instance"].startswith("/")
    if pointer is not None:
        assert pointer in [e["pointer"] for e in found["errors"]], found
    return found
