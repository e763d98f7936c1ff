"""A run that eats memory fails by itself, with the reason in words; its worker is replaced and nobody else suffers."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from backend.jobs.worker_memory import SMALLEST, memory_of_worker
from tests.recovery.conftest import House, settle, wait_for

pytestmark = pytest.mark.recovery
LIMIT = 2**30
GREEDY = """
import sys
import numpy as np
from backend.jobs.worker_memory import limit_memory
reserved = np.empty(2**25)  # counts as what the process has already
limit_memory(2**26)
kept = np.ones(2**22)  # 32 MiB
try:
    np.ones(2**23)
except MemoryError:
    print("refused")
"""


def test_the_kernel_refuses_what_is_above_the_limit() -> None:
    done = subprocess.run([sys.executable, "-c", GREEDY], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "refused"), done.stderr


def test_workers_share_the_memory_of_the_machine() -> None:
    total = psutil.virtual_memory().total
    assert memory_of_worker(None, 1) <= 0.8 * total
    assert memory_of_worker(None, 2) == pytest.approx(memory_of_worker(None, 1) / 2, abs=1)
    assert memory_of_worker(None, 1000) == SMALLEST
    assert memory_of_worker(LIMIT, 1000) == LIMIT


@pytest.fixture(scope="module")
def narrow(plugin: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    """An engine whose two workers may take little."""
    house = settle(tmp_path_factory.mktemp("narrow"), worker_memory_bytes=LIMIT)
    house.engine.start()
    wait_for(lambda: house.engine.status().state == "ready", "engine ready", 240)
    yield house
    house.engine.stop()
    house.database.close()


@pytest.mark.slow
@pytest.mark.parametrize("behaviour", ["eat", "nibble"])
def test_a_run_that_eats_memory_fails_and_spares_the_others(narrow: House, tmp_path: Path, behaviour: str) -> None:
    marker = tmp_path / "starts"
    beside = narrow.queue({"seconds": 2.0})
    narrow.wait(beside, "running")
    greedy = narrow.queue({"behaviour": behaviour, "marker": str(marker)})
    after = [narrow.queue({"seconds": 0.2}) for _ in range(3)]
    run = narrow.wait(greedy, "failed", "succeeded")
    assert run.error is not None
    assert run.error["code"] == "out_of_memory", run.error
    assert run.error["label"] == "entry 0"
    assert "FILTERROOM_WORKER_MEMORY_BYTES" in run.error["remedy"]
    (pid,) = marker.read_text().split()
    wait_for(lambda: not psutil.pid_exists(int(pid)), "its worker is gone", 10)
    for other in (beside, *after):
        assert narrow.wait(other, "succeeded", "failed").state == "succeeded"
    wait_for(lambda: narrow.engine.status().workers == 2, "both workers are there", 30)
