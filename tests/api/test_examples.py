"""The examples of the README do what they say, against a real server."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.api.conftest import TOKEN, ServerProcess

ALGORITHMS = ("single_mark", "rdf", "rdfv")


def execute(command: list[str], token: str, **more: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "FILTERROOM_TOKEN": token, **more}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)


def test_python_example(server: ServerProcess, repository: Path) -> None:
    script = [sys.executable, str(repository / "examples" / "run_marks.py"), server.url]
    done = execute(script, TOKEN)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    errors = {words[1]: float(words[2]) for words in lines if words[0] == "rms_horizontal_m"}
    assert tuple(errors) == ALGORITHMS
    assert errors["rdfv"] < errors["rdf"] < errors["single_mark"]
    assert done.stdout.splitlines()[-1].startswith(f"{server.url}/#/runs/")


def test_python_example_says_what_is_wrong(server: ServerProcess, repository: Path) -> None:
    done = execute([sys.executable, str(repository / "examples" / "run_marks.py"), server.url], "wrong")
    assert done.returncode == 1
    assert "(token_wrong)" in done.stderr
    # Nobody listens on the port of discarding.
    done = execute(
        [sys.executable, str(repository / "examples" / "run_marks.py")], TOKEN, FILTERROOM_URL="http://127.0.0.1:9"
    )
    assert done.returncode == 1
    assert done.stderr.startswith("No server answers at http://127.0.0.1:9: ")


@pytest.mark.skipif(shutil.which("curl") is None, reason="curl is not installed")
def test_shell_example(server: ServerProcess, repository: Path, tmp_path: Path) -> None:
    script = ["sh", str(repository / "examples" / "run_marks.sh"), server.url, str(tmp_path)]
    done = execute(script, TOKEN)
    assert done.returncode == 0, done.stderr
    assert "has succeeded" in done.stdout
    metrics = (tmp_path / "metrics.csv").read_text()
    assert all(f"rms_horizontal_m,{name},,," in metrics for name in ALGORITHMS)
    assert "<html" in (tmp_path / "plan.html").read_text()[:200].lower()

    refused = execute(script, "wrong")
    assert refused.returncode == 1
    assert "token_wrong" in refused.stderr
