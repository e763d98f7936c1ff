"""An engine that uses a Dask scheduler which somebody else runs, by its certificates."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import LocalCluster
from distributed.security import Security

from tests.recovery.conftest import settle, wait_for

pytestmark = pytest.mark.recovery


@pytest.fixture(scope="module")
def scheduler(plugin: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, object]]:
    """A scheduler with one worker of two threads; the settings that lead to it."""
    security = Security.temporary()
    folder = tmp_path_factory.mktemp("certificates")
    (folder / "cert.pem").write_text(security.tls_client_cert)
    (folder / "key.pem").write_text(security.tls_client_key)
    (folder / "ca.pem").write_text(security.tls_ca_file)
    with LocalCluster(
        n_workers=1,
        threads_per_worker=2,
        host="127.0.0.1",
        protocol="tls://",
        security=security,
        dashboard_address="127.0.0.1:0",
        local_directory=str(tmp_path_factory.mktemp("scratch")),
    ) as cluster:
        yield {
            "scheduler": cluster.scheduler_address,
            "tls_ca": folder / "ca.pem",
            "tls_cert": folder / "cert.pem",
            "tls_key": folder / "key.pem",
        }


def test_runs_on_an_existing_scheduler_and_leaves_it_alone(scheduler: dict[str, object], tmp_path: Path) -> None:
    for folder in ("first", "second"):
        house = settle(tmp_path / folder, **scheduler)
        house.engine.start()
        try:
            wait_for(lambda engine=house.engine: engine.status().state == "ready", "engine ready", 240)
            assert house.engine.status().workers == 2
            run = house.wait(house.queue({"seconds": 0.4}, {}), "succeeded", "failed")
            assert run.error is None
            cancelled = house.queue({"seconds": 60})
            house.wait(cancelled, "running")
            house.engine.cancel(cancelled)
            house.wait(house.queue({}, {}), "succeeded")
        finally:
            house.engine.stop()
            house.database.close()


def test_a_scheduler_that_does_not_answer_is_reported(scheduler: dict[str, object], tmp_path: Path) -> None:
    house = settle(tmp_path / "data", **{**scheduler, "scheduler": "127.0.0.1:1"})
    house.engine.start()
    try:
        wait_for(lambda: house.engine.status().state == "failed", "failed", 20)
        assert "tls://" in house.engine.status().detail
        run_id = house.queue({})
        assert house.engine.cancel(run_id), "a queued run can be cancelled without any worker"
    finally:
        house.engine.stop()
        house.database.close()
