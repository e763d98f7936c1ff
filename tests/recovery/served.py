"""The real server in a process of its own, to be killed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import psutil

from tests.recovery.conftest import PLUGIN, House, wait_for

TOKEN = "recovery"
ROOT = Path(__file__).parents[2]


@dataclass
class Server:
    """A server process that answers."""

    process: subprocess.Popen[str]
    url: str
    recording_id: str

    def queue(self, *parameters: dict[str, Any], seed: int = 7) -> str:
        entries = [{"name": "rehearsal", "label": f"entry {i}", "parameters": p} for i, p in enumerate(parameters)]
        return self.start({"recording_id": self.recording_id, "algorithms": entries, "seed": seed})

    def start(self, body: dict[str, Any]) -> str:
        """Queue a run; return its id."""
        request = urllib.request.Request(
            f"{self.url}/api/v1/runs",
            data=json.dumps(body).encode(),
            headers={"Authorization": f"Bearer {TOKEN}", "Content-Type": "application/json"},
        )
        # The first request of a server waits for its algorithms to be imported: long beside other work.
        with urllib.request.urlopen(request, timeout=120) as answer:
            return str(json.load(answer)["id"])

    def family(self) -> list[psutil.Process]:
        return psutil.Process(self.process.pid).children(recursive=True)

    def kill(self) -> None:
        children = self.family()
        self.process.kill()
        self.process.wait()
        wait_for(lambda: gone(children), "no process stays behind", 10)


@contextmanager
def server(house: House, workers: int = 2) -> Iterator[Server]:
    """Serve a data folder until the end of the block at the latest."""
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "backend.cli", "serve", "--no-samples", "--port", "0", "--workers", str(workers)),
            *("--data", str(house.settings.data_dir)),
        ],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{PLUGIN}", "FILTERROOM_TOKEN": TOKEN},
    )
    with process:
        try:
            assert process.stdout is not None
            address = urlsplit(process.stdout.readline().strip())
            yield Server(process, f"http://{address.netloc}", house.recording_id)
        finally:
            process.kill()


def gone(processes: list[psutil.Process]) -> bool:
    return all(not p.is_running() or p.status() == psutil.STATUS_ZOMBIE for p in processes)
