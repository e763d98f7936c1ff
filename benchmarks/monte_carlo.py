"""How fast trials are: the paper's experiment over HTTP, one core's share of its own peak, workers, and memory.

One machine, one minute: ratios are the result. What one core needs is processor time, so that it means something on a
busy machine too; times over HTTP depend on what else runs.
Run: uv run --group dev python benchmarks/monte_carlo.py [--trials 1000] [--no-server]
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # one core for everybody

import httpx2
import numpy as np
import psutil

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from algorithms.multilateration import lanes, rdfv
from algorithms.multilateration.conditions import conditions_of
from algorithms.multilateration.filter_kernel import filter_marks
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.multilateration.tracker import filter_setup, started
from algorithms.registry import scenarios_by_name
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels import LANES, kernel
from algorithms.toolbox.monte_carlo.batches import BATCH, batches
from algorithms.toolbox.monte_carlo.running import Running
from algorithms.toolbox.monte_carlo.sums import sums_of
from backend.jobs.worker_memory import keep_freed_memory
from tests.api.conftest import FINAL, ServerProcess, start_server

START = {"mode": "truth", "sd": [500, 50, 1]}
ARTICLE = {"profile": "article", "start": START}
MARKS = 1_900
# Multiplications and additions of one mark with five rows: prediction of three axes, rows, updates of 45 elements.
PREDICT_OPERATIONS = 3 * 6 + 9 * 24 + 6
ROW_OPERATIONS = 9 * 5 + 6 + 12 + 9 * 3 + 45 * 2 + 25


# Timed part by part in loops of their own, of 0.21 us: 0.057 updates, 0.053 rows, 0.035 report, 0.026 prediction.
LOSS = """Where the rest goes: the update by one row reads and writes all 45 covariances, three transfers for two
operations; the rows of a mark take square roots and divisions, which count as one operation and last like ten; the
report leaves the cache for the memory; statuses are compared and chosen, which counts as nothing."""

# Multiply-adds of one call of the kernel below for each lane and round.
CHAIN = 2 * 16


@kernel
def _multiply_add(first, second, b, c, rounds):
    """Two chains of multiply-adds in registers, over lanes that the compiler puts side by side: the core's peak."""
    for _ in range(rounds):
        for lane in range(first.size):
            x = first[lane]
            y = second[lane]
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            x = x * b + c
            y = y * b + c
            first[lane] = x
            second[lane] = y


def best(call: Callable[[], object], repeats: int) -> float:
    """Shortest processor time of several calls, s."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def peak_gflops() -> float:
    """Multiply-adds of this core from the first-level cache, as 10^9 operations a second."""
    first, second = np.ones(256), np.ones(256)
    rounds = 20_000
    _multiply_add(first, second, 0.999, 1e-3, 1)
    seconds = best(lambda: _multiply_add(first, second, 0.999, 1e-3, rounds), 5)
    return rounds * first.size * CHAIN * 2 / seconds / 1e9


def one_core(trials: int) -> None:
    """Print what one core needs for a mark and trial: the filter alone, and each part of the pipeline."""
    parameters = rdfv.RdfvParameters.model_validate(ARTICLE)
    scenario = scenarios_by_name()["four_station_circuit"]
    conditions_in = CircuitParameters()
    recording = simulate(conditions_in, tuple(range(LANES)), 1)
    conditions = conditions_of(recording, parameters, profile="article", with_altitude=True)
    setup = filter_setup(recording, parameters, conditions, altitude=True)
    marks = lanes.decoded_marks(
        np.repeat(recording.time_s[:, None], LANES, axis=1), recording.toa_s, recording.altitude_m
    )
    now, rows = lanes.new_now(4), lanes.new_rows(4)
    report = lanes.new_report(MARKS, 4, LANES, covariance="position", receptions=False)

    def fresh() -> lanes.Track:
        return started(parameters.start, recording, np.zeros(LANES, int), np.arange(LANES), LocalContext())

    tracks = [fresh() for _ in range(21)]
    filter_marks(marks, setup, tracks.pop(), now, rows, report, 0, MARKS)
    alone = best(lambda: filter_marks(marks, setup, tracks.pop(), now, rows, report, 0, MARKS), 20) / (MARKS * LANES)

    spent: dict[str, float] = {}

    def timed(name: str, call: Callable[[], Any]) -> Any:
        begin = time.process_time()
        result = call()
        spent[name] = spent.get(name, 0.0) + time.process_time() - begin
        return result

    for _ in range(2):
        spent.clear()
        running = Running(1)
        for first, stop in batches(0, trials):
            batch = timed("simulate", lambda a=first, b=stop: simulate(conditions_in, tuple(range(a, b)), 1))
            context = LocalContext(1, first)
            scores = timed("filter and score", lambda r=batch, c=context: rdfv.score(r, parameters, c))
            sums = timed("sum up", lambda s=scores, k=first // BATCH: sums_of(s, scenario.legs(conditions_in), batch=k))
            timed("merge", lambda r=running, s=sums: r.add([s]))
        timed("metrics", lambda r=running: r.metrics(0))
    peak = peak_gflops()
    operations = PREDICT_OPERATIONS + 5 * ROW_OPERATIONS
    print(f"\nOne core, RDFV of the article, {trials} trials x {MARKS} marks")
    print(f"{'':28}{'us per mark and trial':>22}{'seconds for all':>18}")
    for name, seconds in (("filter alone", alone * trials * MARKS), *spent.items(), ("all parts", sum(spent.values()))):
        print(f"{name:28}{seconds / trials / MARKS * 1e6:22.3f}{seconds:18.2f}")
    print(f"multiply-adds of this core: {peak:.1f} GFlop/s; the filter's {operations} operations a mark and trial make "
          f"{operations / alone / 1e9:.1f} GFlop/s, {operations / alone / 1e9 / peak:.0%} of it")  # fmt: skip
    print(LOSS)


@contextmanager
def serving(workers: int) -> Iterator[ServerProcess]:
    """A server on a data folder of its own, with warm kernels."""
    with tempfile.TemporaryDirectory() as folder:
        server = start_server(Path(folder) / "data", "--no-samples", "--workers", str(workers))
        try:
            with server.client() as api:
                while (
                    api.get("/readyz").status_code != 200
                    or api.get("/api/v1/meta").json()["engine"]["state"] != "ready"
                ):
                    time.sleep(0.1)
            yield server
        finally:
            server.stop()


def finished(api: httpx2.Client, body: dict[str, Any]) -> dict[str, Any]:
    """Start a run and wait for its end, as a page does: by its events, so that nobody asks all the time."""
    location = api.post("/api/v1/runs", json=body).raise_for_status().headers["location"]
    with api.stream("GET", f"{location}/events") as events:
        for line in events.iter_lines():
            if line.startswith("data:") and any(f'"{state}"' in line for state in FINAL):
                break
    while (found := api.get(location).raise_for_status().json())["state"] in ("queued", "running"):
        time.sleep(0.02)
    if found["state"] != "succeeded":
        raise RuntimeError(found["error"])
    return found


def experiment(trials: int, preset: str, sweep: dict[str, Any]) -> dict[str, Any]:
    """RDF and RDFV of the article on one preset."""
    entries = [{"name": name, "parameters": ARTICLE} for name in ("rdf", "rdfv")]
    return {"algorithms": entries, "scenario": {"preset": preset}, "trials": trials, "seed": 42, "sweep": sweep}


def over_http() -> None:
    """Print the time of the paper's experiments, charts included, and what a second worker is worth."""
    sigmas = {"scenario.sigma_altitude_m": [300, 100, 30, 10]}
    seconds = {}
    only = {"algorithms": [{"name": "rdfv", "parameters": ARTICLE}]}
    print(f"\n{'over HTTP, charts included':52}{'1 worker, s':>12}{'2 workers, s':>14}{'ratio':>8}")
    plans = {
        "8.1: 300 trials, rdf and rdfv, four altitude errors": experiment(300, "four_station_circuit", sigmas),
        "8.2: 200 trials, rdf and rdfv": experiment(200, "four_station_incomplete", {}),
        "1,000 trials of rdfv": experiment(1_000, "four_station_circuit", {}) | only,
    }
    for workers in (1, 2):
        with serving(workers) as server, server.client() as api:
            finished(api, experiment(2, "four_station_circuit", {}))
            for name, body in plans.items():
                begin = time.perf_counter()
                run = finished(api, body)
                for chart in api.get(f"/api/v1/runs/{run['id']}/charts").json()["items"]:
                    api.get(f"/api/v1/runs/{run['id']}/charts/{chart['name']}.json").raise_for_status()
                seconds[name, workers] = time.perf_counter() - begin
    for name in plans:
        one, two = seconds[name, 1], seconds[name, 2]
        print(f"{name:52}{one:12.2f}{two:14.2f}{one / two:8.2f}")


def memory() -> None:
    """Print the largest memory of the workers against the number of trials."""
    print(f"\n{'trials of rdfv':20}{'largest worker, MB':>20}{'server, MB':>12}")
    for trials in (2 * BATCH, 10 * BATCH, 50 * BATCH):
        with serving(2) as server, server.client() as api:
            largest = {"worker": 0, "server": 0}
            stop = threading.Event()
            watcher = threading.Thread(target=_watch, args=(server.process.pid, largest, stop))
            watcher.start()
            body = experiment(trials, "four_station_circuit", {})
            finished(api, body | {"algorithms": [{"name": "rdfv", "parameters": ARTICLE}]})
            stop.set()
            watcher.join()
        print(f"{trials:<20}{largest['worker'] / 1e6:20.0f}{largest['server'] / 1e6:12.0f}")


def _watch(pid: int, largest: dict[str, int], stop: threading.Event) -> None:
    server = psutil.Process(pid)
    while not stop.wait(0.05):
        largest["server"] = max(largest["server"], server.memory_info().rss)
        for child in server.children(recursive=True):
            try:
                largest["worker"] = max(largest["worker"], child.memory_info().rss)
            except psutil.NoSuchProcess:
                continue


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=1_000)
    parser.add_argument("--no-server", action="store_true", help="one core only")
    given = parser.parse_args()
    # As a worker does.
    keep_freed_memory()
    one_core(given.trials)
    if not given.no_server:
        over_http()
        memory()


if __name__ == "__main__":
    main()
