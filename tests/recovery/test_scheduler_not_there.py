"""A server that is told of a scheduler where none is: it answers, says so in words, takes runs and lets them wait."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest

from tests.api.conftest import ServerProcess, start_server
from tests.recovery.conftest import wait_for

pytestmark = [pytest.mark.recovery, pytest.mark.slow]
SCENARIO = {"preset": "four_station_circuit", "parameters": {"duration_s": 20, "legs": []}}


@pytest.fixture(scope="module")
def address() -> str:
    """Nobody listens there."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return f"tcp://127.0.0.1:{free.getsockname()[1]}"


@pytest.fixture(scope="module")
def server(address: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    running = start_server(
        tmp_path_factory.mktemp("away") / "data",
        "--no-samples",
        FILTERROOM_SCHEDULER=address,
        FILTERROOM_INSECURE_SCHEDULER="true",
    )
    yield running
    assert running.stop() == 0
    assert "Traceback" not in running.log.read_text()


@pytest.fixture(scope="module")
def client(server: ServerProcess) -> Iterator[httpx2.Client]:
    with server.client() as client:
        yield client


def engine(client: httpx2.Client) -> dict[str, Any]:
    found: dict[str, Any] = client.get("/api/v1/meta").raise_for_status().json()["engine"]
    return found


def test_it_says_who_does_not_answer_and_what_to_do(client: httpx2.Client, address: str, server: ServerProcess) -> None:
    assert client.get("/healthz").status_code == 200, "the server itself is well"
    wait_for(lambda: engine(client)["state"] == "failed", "it is noticed", 60)
    ready = client.get("/readyz")
    assert ready.status_code == 503
    for words in (engine(client)["detail"], ready.json()["detail"]):
        assert f"The scheduler {address} does not answer" in words
        assert "FILTERROOM_SCHEDULER" in words
    assert engine(client)["workers"] == 0
    assert server.log.read_text().count(f"The scheduler {address} does not answer") == 1, "said once, not every time"


def test_a_run_waits_with_the_reason_in_its_log_and_can_be_cancelled(client: httpx2.Client, address: str) -> None:
    body = {"scenario": SCENARIO, "trials": 2, "algorithms": [{"name": "rdfv"}]}
    answer = client.post("/api/v1/runs", json=body)
    assert answer.status_code == 202, answer.text
    where = answer.headers["location"]
    wait_for(
        lambda: f"The scheduler {address} does not answer" in client.get(f"{where}/log").text, "the log says why", 60
    )
    assert client.get(where).json()["state"] == "queued"
    assert client.post(f"{where}/cancel").status_code == 202
    run = client.get(where).json()
    assert (run["state"], run["started_at"], run["result_sha256"]) == ("cancelled", None, None)


def test_what_is_wrong_with_a_run_is_still_said_at_once(client: httpx2.Client) -> None:
    before = client.get("/api/v1/runs").json()["items"]
    answer = client.post("/api/v1/runs", json={"scenario": SCENARIO, "trials": 0, "algorithms": [{"name": "rdfv"}]})
    assert answer.status_code == 422
    assert client.get("/api/v1/runs").json()["items"] == before
