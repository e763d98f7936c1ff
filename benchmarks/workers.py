"""Where the time of a Monte Carlo run goes, and what a second worker is worth.

For each run, with one worker and with two: the time from the request to the result, the processor seconds of the server
and of the workers, and from the run's own log how long it took to begin, to compute, and to end after the last block.

On a machine where something else runs, times mean nothing; processor seconds still do. From them follows the ratio
that a quiet machine of two cores gives at best: one worker leaves a core to the server, two share both cores with it.

Run: uv run --group dev python benchmarks/workers.py [--repeats 3]
"""

from __future__ import annotations

import argparse
import datetime as dt
import re
import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import psutil

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.monte_carlo import ARTICLE, experiment, finished, serving
from tests.api.conftest import ServerProcess

SIGMAS = {"scenario.sigma_altitude_m": [300, 100, 30, 10]}
RDFV = {"algorithms": [{"name": "rdfv", "parameters": ARTICLE}]}
PLANS = {
    "8.1: 300 trials, rdf and rdfv, four altitude errors": experiment(300, "four_station_circuit", SIGMAS),
    "8.2: 200 trials, rdf and rdfv": experiment(200, "four_station_incomplete", {}),
    "1,000 trials of rdfv": experiment(1_000, "four_station_circuit", {}) | RDFV,
    "10,000 trials of rdfv": experiment(10_000, "four_station_circuit", {}) | RDFV,
}


@dataclass(frozen=True)
class Measured:
    """Seconds of one run; `begin` until its first block was sent, `last` from its last block to its end."""

    wall: float
    charts: float
    server: float
    workers: float
    begin: float
    blocks: int
    computed: float
    last: float


def measure(server: ServerProcess, api: httpx2.Client, body: dict[str, Any]) -> Measured:
    """Run once and take the times."""
    before = _processor_seconds(server)
    begin = time.perf_counter()
    asked = dt.datetime.now(dt.UTC)
    run = finished(api, body)
    wall = time.perf_counter() - begin
    after = _processor_seconds(server)
    begin = time.perf_counter()
    for chart in api.get(f"/api/v1/runs/{run['id']}/charts").json()["items"]:
        api.get(f"/api/v1/runs/{run['id']}/charts/{chart['name']}.json").raise_for_status()
    charts = time.perf_counter() - begin
    lines = [line.split(" ", 2) for line in api.get(f"/api/v1/runs/{run['id']}/log").text.splitlines()]
    found = [(dt.datetime.fromisoformat(line[0]), line[-1]) for line in lines]
    blocks = [(at, float(m[1])) for at, text in found if (m := re.search(r"finished in ([\d.]+) s", text))]
    return Measured(
        wall=wall,
        charts=charts,
        server=after[0] - before[0],
        workers=after[1] - before[1],
        begin=(found[0][0] - asked).total_seconds(),
        blocks=len(blocks),
        computed=sum(seconds for _, seconds in blocks),
        last=(found[-1][0] - max(at for at, _ in blocks)).total_seconds(),
    )


def _processor_seconds(server: ServerProcess) -> tuple[float, float]:
    """Of the server, and of its workers together."""
    own = psutil.Process(server.process.pid)
    below = [p.cpu_times() for p in own.children(recursive=True)]
    times = own.cpu_times()
    return times.user + times.system, sum(t.user + t.system for t in below)


def middle(found: list[Measured]) -> Measured:
    """The run of the middle by its wall time, with the medians of its processor seconds."""
    ordered = sorted(found, key=lambda m: m.wall)
    chosen = ordered[(len(ordered) - 1) // 2]
    medians = {name: statistics.median(getattr(m, name) for m in found) for name in ("server", "workers")}
    return Measured(**{**vars(chosen), **medians})


def main() -> None:
    """Print one table for each run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", default="", help="part of a run's name")
    given = parser.parse_args()
    plans = {name: body for name, body in PLANS.items() if given.only in name}
    found: dict[tuple[str, int], Measured] = {}
    for workers in (1, 2):
        with serving(workers) as server, server.client() as api:
            for _ in range(2 * workers):
                finished(api, experiment(130, "four_station_circuit", {}))
            for name, body in plans.items():
                # The seeds differ, so that no chart is found where an earlier run left it.
                runs = [measure(server, api, body | {"seed": 42 + i}) for i in range(given.repeats)]
                found[name, workers] = middle(runs)
    for name in plans:
        one, two = found[name, 1], found[name, 2]
        print(f"\n{name}")
        print(f"{'':44}{'1 worker':>10}{'2 workers':>11}")
        for words, field in (
            ("request to result, s", "wall"), ("all charts then, s", "charts"),
            ("processor of the server, s", "server"), ("processor of the workers, s", "workers"),
            ("until it began, s", "begin"), ("blocks", "blocks"), ("computed in blocks, s", "computed"),
            ("after the last block, s", "last"),
        ):  # fmt: skip
            print(f"{words:44}{getattr(one, field):10.3f}{getattr(two, field):11.3f}")
        print(f"ratio of the times: {one.wall / two.wall:.2f}; with charts "
              f"{(one.wall + one.charts) / (two.wall + two.charts):.2f}; by processor seconds at best "
              f"{one.workers / ((two.workers + two.server) / 2):.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
