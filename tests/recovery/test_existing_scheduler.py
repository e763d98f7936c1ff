"""A server that uses a Dask scheduler which somebody else runs: processes of their own, joined by certificates."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import pytest
from distributed.security import Security

from backend.db import events
from tests.recovery.conftest import PLUGIN, House, settle, wait_for

pytestmark = [pytest.mark.recovery, pytest.mark.slow]
ROOT = Path(__file__).parents[2]


@dataclass
class Site:
    """A place where a scheduler and workers run, as `dask scheduler` and `dask worker` start them."""

    folder: Path
    port: int
    started: ExitStack = field(default_factory=ExitStack)

    @property
    def settings(self) -> dict[str, object]:
        return {
            "scheduler": f"tls://127.0.0.1:{self.port}",
            **{f"tls_{name}": self.folder / f"{name}.pem" for name in ("ca", "cert", "key")},
        }

    def scheduler(self) -> subprocess.Popen[bytes]:
        return self._start("scheduler", "--host", f"tls://127.0.0.1:{self.port}", "--dashboard-address", "127.0.0.1:0")

    def worker(self, *path: Path) -> subprocess.Popen[bytes]:
        """Start a worker that finds what lies in `path` before anything else."""
        options = ("--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard", "--death-timeout", "60")
        return self._start("worker", f"tls://127.0.0.1:{self.port}", *options, path=path)

    def _start(self, what: str, *options: str, path: tuple[Path, ...] = ()) -> subprocess.Popen[bytes]:
        files = {"--tls-ca-file": "ca", "--tls-cert": "cert", "--tls-key": "key"}
        certificates = [word for name, file in files.items() for word in (name, str(self.folder / f"{file}.pem"))]
        with (self.folder / f"{what}.log").open("ab") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", what, *options, *certificates],
                cwd=self.folder,
                stdout=log,
                stderr=log,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (*path, ROOT, PLUGIN)))},
            )
        self.started.callback(self.kill, process)
        return process

    @staticmethod
    def kill(process: subprocess.Popen[bytes]) -> None:
        """Kill a process with its children: what a nanny started goes with it, as when a machine is lost."""
        if process.poll() is None:
            for one in (*psutil.Process(process.pid).children(recursive=True), process):
                one.kill()
        process.wait()


@pytest.fixture
def site(plugin: None, tmp_path: Path) -> Iterator[Site]:
    security = Security.temporary()
    (tmp_path / "cert.pem").write_text(security.tls_client_cert)
    (tmp_path / "key.pem").write_text(security.tls_client_key)
    (tmp_path / "ca.pem").write_text(security.tls_ca_file)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    site = Site(tmp_path, port)
    with site.started:
        yield site


@pytest.fixture
def house(site: Site, tmp_path: Path) -> Iterator[House]:
    """An engine that is told of the scheduler and not started yet."""
    house = settle(tmp_path / "data", **site.settings)
    yield house
    house.engine.stop()
    house.database.close()


def workers(house: House, n: int) -> None:
    wait_for(lambda: house.engine.status().workers == n, f"{n} workers", 120)


def refusal(house: House, words: str) -> str:
    """Return why workers get no work, when the engine says so in these words."""
    wait_for(lambda: words in house.engine.status().detail, words)
    return house.engine.status().detail


def log(house: House, run_id: str) -> str:
    with house.database.read() as connection:
        return "\n".join(line.text for line in events.log_lines(connection, run_id))


def test_a_worker_killed_during_a_run_costs_its_block_only(site: Site, house: House, tmp_path: Path) -> None:
    site.scheduler()
    first, _ = site.worker(), site.worker()
    house.engine.start()
    workers(house, 2)
    markers = [tmp_path / f"starts {i}" for i in range(4)]
    run_id = house.queue(
        *[{"seconds": s, "marker": str(m)} for m, s in zip(markers, (5.0, 5.0, 0.0, 0.0), strict=True)]
    )
    wait_for(lambda: markers[0].exists() and markers[1].exists(), "two blocks are under way")
    site.kill(first)
    run = house.wait(run_id, "succeeded", "failed")
    assert run.error is None
    assert "the worker died; it is computed again" in log(house, run_id)
    assert sorted(len(m.read_text().splitlines()) for m in markers) == [1, 1, 1, 2]
    undisturbed = house.wait(house.queue({}, {}, {}, {}), "succeeded")
    assert run.result_sha256 == undisturbed.result_sha256
    cancelled = house.queue({"seconds": 60})
    house.wait(cancelled, "running")
    house.engine.cancel(cancelled)
    house.wait(house.queue({}), "succeeded")


def test_goes_on_when_the_scheduler_is_there_or_is_back(
    site: Site, house: House, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("backend.jobs.cluster.CONNECT_S", 1)
    monkeypatch.setattr("backend.jobs.crew.RETRY_S", 0.5)
    house.engine.start()
    wait_for(lambda: house.engine.status().state == "failed", "it is said that nobody answers", 30)
    assert f"The scheduler tls://127.0.0.1:{site.port} does not answer" in house.engine.status().detail
    early = house.queue({})
    never = house.queue({})
    assert house.engine.cancel(never), "a queued run can be cancelled without any worker"

    scheduler = site.scheduler()
    wait_for(lambda: "has no workers" in house.engine.status().detail, "it is said that there are no workers", 60)
    worker = site.worker()
    house.wait(early, "succeeded")
    assert "has no workers. Runs wait for them." in log(house, early)

    marker = tmp_path / "starts"
    run_id = house.queue({"seconds": 2.0, "marker": str(marker)}, {})
    wait_for(marker.exists, "the algorithm runs")
    site.kill(scheduler)
    site.kill(worker)
    wait_for(lambda: house.engine.status().state == "failed", "the loss is noticed", 30)
    assert house.run(run_id).state == "running"
    site.scheduler()
    site.worker()
    run = house.wait(run_id, "succeeded", "failed")
    assert run.error is None
    assert f"The scheduler tls://127.0.0.1:{site.port} does not answer" in log(house, run_id)
    assert run.result_sha256 == house.wait(house.queue({}, {}), "succeeded").result_sha256


def test_other_versions_get_no_work_and_are_named(site: Site, house: House, tmp_path: Path) -> None:
    other = tmp_path / "other" / "filterroom-9.9.dist-info"
    other.mkdir(parents=True)
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: filterroom\nVersion: 9.9\n")
    site.scheduler()
    site.worker(other.parent)
    house.engine.start()
    run_id = house.queue({})
    assert "filterroom 9.9 (here " in refusal(house, "1 of 1 workers get no work")
    wait_for(lambda: "filterroom 9.9 (here " in log(house, run_id), "the run's log says why it waits")
    assert house.run(run_id).state == "queued"
    site.worker()
    assert house.wait(run_id, "succeeded", "failed").error is None
    assert house.engine.status().workers == 1
    assert "1 of 2 workers get no work" in house.engine.status().detail


def test_other_sources_under_the_same_version_get_no_work(site: Site, house: House, tmp_path: Path) -> None:
    other = tmp_path / "checkout"
    (other / "algorithms").mkdir(parents=True)
    (other / "algorithms" / "__init__.py").write_text("")
    site.scheduler()
    site.worker(other)
    house.engine.start()
    assert "has other sources of this program" in refusal(house, "1 of 1 workers get no work")
    assert house.engine.status().workers == 0
