"""The command line: exit statuses, what it prints, and that starting is quick."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import httpx2
import pytest

from backend.api.samples import SAMPLES
from tests.api.conftest import TOKEN, ServerProcess, finished, start_server


def run_command(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    clean = {k: v for k, v in os.environ.items() if not k.startswith("FILTERROOM_")}
    return subprocess.run(
        [sys.executable, "-m", "backend.cli", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env={**clean, **environment},
        cwd=Path(__file__).parents[2],
        check=False,
    )


def processor_seconds(pid: int) -> float:
    """Time that a process has computed so far, in all its threads."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_algorithms_are_listed() -> None:
    plain = run_command("algorithms")
    assert plain.returncode == 0
    assert "rdfv" in plain.stdout
    found = json.loads(run_command("algorithms", "--json").stdout)
    assert {"single_mark", "rdf", "rdfv"} <= {a["name"] for a in found["items"]}


def test_description_is_printed() -> None:
    assert json.loads(run_command("openapi").stdout)["info"]["title"] == "Filter Room"


def test_migrate_makes_the_database(tmp_path: Path) -> None:
    done = run_command("migrate", "--data", str(tmp_path / "data"), "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"migrated": True}
    assert (tmp_path / "data" / "filterroom.sqlite").exists()


def test_wrong_usage_is_status_2() -> None:
    assert run_command("nonsense").returncode == 2
    assert run_command().returncode == 2


@pytest.mark.parametrize(
    ("environment", "word"),
    [
        ({"FILTERROOM_PORT": "99999"}, "FILTERROOM_PORT"),
        ({"FILTERROOM_WORKERS": "0"}, "FILTERROOM_WORKERS"),
        ({"FILTERROOM_SCHEDULER": "tls://x:1"}, "tls_ca"),
        ({"FILTERROOM_SCHEDULER": "tcp://x:1"}, "FILTERROOM_INSECURE_SCHEDULER"),
        ({"FILTERROOM_SCHEDULER": "x:1"}, "no address"),
        ({"FILTERROOM_HOST": "0.0.0.0"}, "FILTERROOM_TOKEN"),
    ],
)
def test_wrong_setting_is_named(tmp_path: Path, environment: dict[str, str], word: str) -> None:
    done = run_command("serve", "--data", str(tmp_path), **environment)
    assert done.returncode == 2
    assert word in done.stderr
    assert "Traceback" not in done.stderr


def test_port_in_use_is_said_plainly(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        done = run_command("serve", "--data", str(tmp_path), "--port", port)
        as_json = run_command("serve", "--data", str(tmp_path), "--port", port, "--json")
    assert done.returncode == 1
    assert port in done.stderr
    assert "--port" in done.stderr
    assert "Traceback" not in done.stderr
    assert json.loads(as_json.stdout)["error"]["code"] == "port"


def test_data_folder_has_one_server(server: ServerProcess) -> None:
    done = run_command("serve", "--data", str(server.data), "--port", "0")
    assert done.returncode == 1
    assert str(server.data) in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_first_start_shows_the_sample_and_keeps_its_token(tmp_path: Path) -> None:
    first = start_server(tmp_path / "data", "--workers", "1", FILTERROOM_TOKEN="")
    try:
        httpx2.get(f"{first.url}/healthz")
        # Two seconds by the clock on a quiet machine; processor time says the same on a busy one.
        assert processor_seconds(first.process.pid) < 2
        token_file = tmp_path / "data" / "token"
        assert token_file.stat().st_mode & 0o777 == 0o600
        token = token_file.read_text().strip()
        assert len(token) >= 40
        with httpx2.Client(base_url=first.url, headers={"Authorization": f"Bearer {token}"}, timeout=60) as api:
            deadline = time.monotonic() + 30
            while len(items := api.get("/api/v1/runs").json()["items"]) < len(SAMPLES):
                assert time.monotonic() < deadline
                time.sleep(0.1)
            assert [e["name"] for e in items[0]["algorithms"]] == ["single_mark", "rdf", "rdfv"]
            for item in items:
                run = finished(api, f"/api/v1/runs/{item['id']}")
                assert run["state"] == "succeeded", run["error"]
                assert api.delete(f"/api/v1/runs/{run['id']}").status_code == 204
    finally:
        assert first.stop() == 0, first.log.read_text()
    again = start_server(tmp_path / "data", "--workers", "1", FILTERROOM_TOKEN="")
    try:
        with httpx2.Client(base_url=again.url, headers={"Authorization": f"Bearer {token}"}) as api:
            time.sleep(1)
            assert api.get("/api/v1/runs").json()["items"] == [], "what was deleted stays deleted"
            assert len(api.get("/api/v1/recordings").json()["items"]) == len(SAMPLES)
    finally:
        assert again.stop() == 0, again.log.read_text()


def test_answers_do_not_wait_for_an_acknowledgement(server: ServerProcess) -> None:
    """With Nagle's algorithm on, each takes 40 ms and more on a connection that is kept."""
    with server.client() as api:
        times = []
        for _ in range(40):
            started = time.monotonic()
            assert api.get("/healthz").status_code == 200
            times.append(time.monotonic() - started)
    assert min(times[2:]) < 0.035


def test_stopping_does_not_wait_for_listeners(tmp_path: Path) -> None:
    running = start_server(tmp_path / "data", "--no-samples", "--workers", "1")
    with running.client() as api, api.stream("GET", "/api/v1/events") as stream:
        lines = stream.iter_lines()
        next(lines)
        started = time.monotonic()
        assert running.stop() == 0, running.log.read_text()
        assert time.monotonic() - started < 8
    assert "Traceback" not in running.log.read_text()


def test_heavy_libraries_wait_for_the_first_answer(tmp_path: Path) -> None:
    """What the application imports before it can answer decides how long a user waits."""
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from backend.settings import Settings\n"
        "from backend.app import create_app\n"
        f"create_app(Settings(data_dir=Path({str(tmp_path / 'data')!r})))\n"
        "print([m for m in ('numba', 'dask', 'distributed', 'plotly', 'scipy') if m in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


def test_insecure_mode_has_to_be_asked_for(tmp_path: Path) -> None:
    running = start_server(tmp_path / "data", "--no-samples", "--workers", "1", "--insecure-no-token")
    try:
        assert httpx2.get(f"{running.url}/api/v1/runs").status_code == 200
        assert TOKEN not in running.url
    finally:
        running.stop()
