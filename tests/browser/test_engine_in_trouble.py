"""Kernels that cannot be compiled or kept: `meta`, `/readyz` and the page say so in words, no run waits for ever."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import expect

from tests.api.conftest import TOKEN, ServerProcess, start_server
from tests.browser.conftest import Visit
from tests.recovery.conftest import wait_for

pytestmark = [pytest.mark.browser, pytest.mark.slow]
ROOT = Path(__file__).parents[2]
# An algorithm of a third party whose kernel adds a text and a number.
BROKEN = """
from algorithms.multilateration.rdf import ALGORITHM as RDF
from algorithms.toolbox.kernels import kernel
from dataclasses import replace

@kernel
def sum_of(x):
    return "text" + x

def run(recording, parameters, context):
    sum_of(1.0)
    return RDF.run(recording, parameters, context)

ALGORITHM = replace(RDF, name="broken", run=run)
"""
RUN = {
    "scenario": {"preset": "four_station_circuit", "parameters": {"duration_s": 20, "legs": []}},
    "trials": 2,
    "algorithms": [{"name": "rdfv"}],
}


@contextmanager
def served(folder: Path, **environment: str) -> Iterator[tuple[ServerProcess, httpx2.Client]]:
    running = start_server(folder / "data", "--no-samples", "--workers", "1", **environment)
    try:
        with running.client() as client:
            yield running, client
    finally:
        running.stop()


def test_kernels_that_cannot_be_compiled(tmp_path: Path, visit: Callable[..., Visit]) -> None:
    plugin = tmp_path / "filterroom_broken-1.0.dist-info"
    plugin.mkdir()
    (plugin / "METADATA").write_text("Metadata-Version: 2.1\nName: filterroom-broken\nVersion: 1.0\n")
    (plugin / "entry_points.txt").write_text("[filterroom.algorithms]\nbroken = filterroom_broken\n")
    (tmp_path / "filterroom_broken.py").write_text(BROKEN)
    with served(tmp_path, PYTHONPATH=f"{ROOT}{os.pathsep}{tmp_path}") as (running, client):
        early = client.post("/api/v1/runs", json=RUN).raise_for_status().headers["location"]
        engine = wait_for(
            lambda: found if (found := client.get("/api/v1/meta").json()["engine"])["state"] == "failed" else None,
            "it is noticed",
            180,
        )
        assert "The kernels cannot be loaded: TypingError" in engine["detail"]
        assert "restart the server" in engine["detail"]
        ready = client.get("/readyz")
        assert (ready.status_code, ready.json()["detail"]) == (503, engine["detail"])
        # What a free worker computed before is no matter: a run either has its result or says why it has none.
        wait_for(lambda: client.get(early).json()["state"] in ("succeeded", "failed"), "the early run is final", 30)
        late = client.post("/api/v1/runs", json=RUN).raise_for_status().headers["location"]
        run = wait_for(
            lambda: found if (found := client.get(late).json())["state"] == "failed" else None, "the run fails", 30
        )
        assert run["error"]["code"] == "kernels_not_compiled"
        assert "restart the server" in run["error"]["remedy"]
        assert client.get("/problems/kernels_not_compiled").status_code == 200
        assert "TypingError" in running.log.read_text()
        page = visit(url=running.url, known=False).open("#/runs", token=TOKEN)
        line = page.locator(".trouble:visible")
        expect(line).to_contain_text("The kernels cannot be loaded: TypingError")
        expect(line).to_contain_text("restart the server")


def test_kernels_that_cannot_be_kept(tmp_path: Path, visit: Callable[..., Visit]) -> None:
    """A file stands where the folder would: they are compiled, for minutes; nobody waits for that here."""
    place = tmp_path / "kernels"
    place.touch()
    with served(tmp_path, FILTERROOM_KERNEL_CACHE=str(place)) as (running, client):
        warning = wait_for(lambda: client.get("/api/v1/meta").json()["engine"]["warning"], "it is noticed", 120)
        assert f"cannot be kept in {place}: File exists" in warning
        assert "set FILTERROOM_KERNEL_CACHE" in warning
        ready = client.get("/readyz")
        assert (ready.status_code, ready.json()) == (200, {"status": "ready", "detail": warning})
        visited = visit(
            url=running.url, known=False, locale="ru-RU", color_scheme="dark", viewport={"width": 360, "height": 740}
        )
        page = visited.open("#/runs", token=TOKEN)
        line = page.locator(".trouble:visible")
        expect(line).to_contain_text("Скомпилированные ядра негде хранить")
        expect(line).to_contain_text("укажите другую в FILTERROOM_KERNEL_CACHE")
        overflow = page.evaluate("() => document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert overflow <= 0
        visited.assert_clean()
