"""How long the server and the page take: the list of many stored runs, and a long recording from upload to charts.

Real HTTP, a real Chromium, a data folder of its own. Times depend on the machine, growth does not.
Run: uv run --group dev python benchmarks/server.py [--runs 10000] [--marks 25000 50000 100000] [--no-browser]
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
from playwright.sync_api import Page, expect, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from algorithms.multilateration.scenario import CircuitParameters, simulate
from backend.db import runs
from backend.db.engine import Database
from backend.files.native_csv_writer import write_native_csv
from backend.settings import Settings
from tests.api.conftest import TOKEN, ServerProcess, start_server
from tests.browser.conftest import FLAGS, chromium_program

SAMPLES = ROOT / "examples" / "recordings"
ALGORITHMS = ("single_mark", "rdf", "rdfv")
TAGS = ("may", "june", "site B", "calibration", "report")
# Runs per transaction while they are made.
BATCH = 500
SETTLING_S = 15
CIRCUIT_MARKS = 1900


@contextmanager
def serving(data: Path) -> Iterator[ServerProcess]:
    """A server on this data folder, ready for runs."""
    server = start_server(data, "--no-samples", "--workers", "2")
    try:
        with server.client() as api:
            while api.get("/readyz").status_code != 200:
                time.sleep(0.1)
        yield server
    finally:
        server.stop()


def finished(api: httpx2.Client, location: str) -> dict[str, Any]:
    """Wait until a run has succeeded."""
    while (found := api.get(location).raise_for_status().json())["state"] in ("queued", "running"):
        time.sleep(0.05)
    if found["state"] != "succeeded":
        raise SystemExit(f"the run has {found['state']}: {found['error']}")
    return dict(found)


def upload(api: httpx2.Client, marks: bytes, site: bytes, name: str) -> dict[str, Any]:
    """Upload marks with their site and wait until they are read."""
    files = [("file", (f"{name}.csv", marks, "text/csv")), ("site", ("site.json", site, "application/json"))]
    answer = api.post("/api/v1/recordings", files=files, data={"options": json.dumps({"name": name})})
    found = answer.raise_for_status().json()
    while found["state"] == "parsing":
        time.sleep(0.05)
        found = api.get(f"/api/v1/recordings/{found['id']}").json()
    return dict(found)


# The list of runs.


def varied(summary: dict[str, Any], labels: set[str], random: np.random.Generator) -> dict[str, Any]:
    """Return a summary of these labels with other numbers: equal ones would compress to nothing."""
    return {
        metric: {
            label: {
                "value": None if one["value"] is None else one["value"] * random.uniform(0.5, 2.0),
                "ci95": None if one["ci95"] is None else [bound * random.uniform(0.5, 2.0) for bound in one["ci95"]],
                "unit": one["unit"],
            }
            for label, one in found.items()
            if label in labels
        }
        for metric, found in summary.items()
    }


def store_runs(data: Path, count: int) -> None:
    """Store copies of one real run that differ in name, tags, algorithms, numbers and state."""
    with serving(data) as server, server.client() as api:
        marks, site = ((SAMPLES / name).read_bytes() for name in ("sample_marks.csv", "sample_site.json"))
        body = {
            "recording_id": upload(api, marks, site, "sample")["id"],
            "algorithms": [{"name": a} for a in ALGORITHMS],
        }
        model_id = finished(api, api.post("/api/v1/runs", json=body).headers["location"])["id"]
    random = np.random.default_rng(1)
    database = Database(Settings(data_dir=data).url)
    with database.read() as connection:
        model = runs.get_run(connection, model_id)
        recording_ids = runs.recording_ids_of(connection, model_id)
    for start in range(0, count, BATCH):
        with database.write() as connection:
            for i in range(start, min(start + BATCH, count)):
                kept = max(1, int(random.integers(4)))
                run = runs.create_run(
                    connection,
                    algorithms=model.algorithms[:kept],
                    source=model.source,
                    recording_ids=recording_ids,
                    label=f"flight {i % 365} of series {i // 365}",
                    tags=[str(t) for t in random.permutation(TAGS)[: random.integers(3)]],
                    progress_total=model.progress_total,
                )
                runs.start_run(connection, run.id)
                if random.random() < 0.05:
                    runs.fail_run(connection, run.id, {"code": "singular", "detail": "The geometry is singular."})
                    continue
                runs.finish_run(
                    connection,
                    run.id,
                    result_sha256=model.result_sha256 or "",
                    summary=varied(dict(model.summary or {}), {e.label for e in run.algorithms}, random),
                    entries=(model.entries or ())[:kept],
                    software=model.software or {},
                )
    database.close()


def timed(ask: Callable[[], Any], repeats: int) -> tuple[float, float]:
    """Median and 95th percentile of a call, ms."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        ask()
        times.append((time.perf_counter() - begin) * 1e3)
    return statistics.median(times), float(np.percentile(times, 95))


def time_lists(api: httpx2.Client, repeats: int) -> None:
    """Print how long lists take."""
    first = api.get("/api/v1/runs").raise_for_status().json()
    cases: dict[str, dict[str, Any]] = {
        "first page": {},
        "next page": {"cursor": first["next_cursor"]},
        "state=failed": {"state": "failed"},
        "algorithm=rdfv": {"algorithm": "rdfv"},
        "tag=may": {"tag": "may"},
        "recording": {"recording": first["items"][0]["source"]["recording_id"]},
        "text, many match": {"text": "flight"},
        "text, 28 match": {"text": "flight 364"},
        "text, none matches": {"text": "nowhere"},
        "tag and text": {"tag": "report", "text": "series 3"},
        "limit=500": {"limit": 500},
    }
    print(f"\n{'GET /api/v1/runs':34s} {'rows':>5s} {'kB':>7s} {'median ms':>10s} {'95 % ms':>8s}")
    for name, query in cases.items():
        answer = api.get("/api/v1/runs", params=query).raise_for_status()
        median, high = timed(lambda query=query: api.get("/api/v1/runs", params=query), repeats)
        print(
            f"{name:34s} {len(answer.json()['items']):5d} {len(answer.content) / 1e3:7.1f} {median:10.1f} {high:8.1f}"
        )
    for path in ("/healthz", "/api/v1/tags", f"/api/v1/runs/{first['items'][0]['id']}"):
        median, high = timed(lambda path=path: api.get(path), repeats)
        print(f"{path[:34]:34s} {'':5s} {'':7s} {median:10.1f} {high:8.1f}")


def time_list_page(page: Page, url: str) -> None:
    """Print how long the page takes to draw the list, in a fresh tab and by a filter."""
    times = []
    for _ in range(5):
        page.goto("about:blank")
        begin = time.perf_counter()
        page.goto(f"{url}/#/runs", wait_until="commit")
        page.locator("runs-page tbody tr").nth(49).wait_for()
        times.append(time.perf_counter() - begin)
    print(f"{'run list drawn, page opened':60s} {statistics.median(times) * 1e3:8.0f} ms")
    begin = time.perf_counter()
    page.get_by_label("State", exact=True).select_option("failed")
    page.wait_for_function(
        "() => [...document.querySelectorAll('runs-page tbody .state')].every((e) => e.textContent.includes('failed'))"
    )
    print(f"{'run list drawn anew by a filter':60s} {(time.perf_counter() - begin) * 1e3:8.0f} ms")


# A long recording.


def long_recording(marks: int, folder: Path) -> tuple[Path, Path]:
    """Write marks of many aircraft on the circuit, one after another every 40 s, and their site."""
    one = simulate(CircuitParameters(), tuple(range(-(-marks // CIRCUIT_MARKS))), 1)
    trials = one.toa_s.shape[2]
    time_s = (one.time_s[:, None] + 40.0 * np.arange(trials)).ravel()
    order = np.argsort(time_s, kind="stable")[:marks]
    mark, trial = order // trials, order % trials
    recording = replace(
        one,
        time_s=time_s[order],
        row=np.arange(1, order.size + 1),
        target=trial,
        targets=tuple(f"aircraft {i + 1}" for i in range(trials)),
        truth_m=one.truth_m[mark],
        truth_velocity_mps=one.truth_velocity_mps[mark],
        toa_s=one.toa_s[mark, :, trial][:, :, None],
        altitude_m=one.altitude_m[mark, trial][:, None],
        emitter_type=np.full(order.size, -1),
    )
    assert recording.site is not None
    paths = folder / f"marks_{marks}.csv", folder / "site.json"
    with paths[0].open("w") as out:
        write_native_csv(recording, out)
    paths[1].write_text(json.dumps(recording.site.to_json()))
    return paths


def time_recording(api: httpx2.Client, marks: int, files: tuple[Path, Path]) -> None:
    """Print what each step takes over HTTP, without a page."""
    content, site = (path.read_bytes() for path in files)
    begin = time.perf_counter()
    recording = upload(api, content, site, f"by HTTP {marks}")
    steps = {f"upload and read {len(content) / 1e6:.1f} MB": time.perf_counter() - begin}
    body = {"recording_id": recording["id"], "algorithms": [{"name": name} for name in ALGORITHMS]}
    begin = time.perf_counter()
    run = finished(api, api.post("/api/v1/runs", json=body).raise_for_status().headers["location"])
    steps["run, result stored"] = time.perf_counter() - begin
    for label, seconds in run["seconds"].items():
        steps[f"  of it {label} on its worker"] = seconds
    sizes = {}
    for owner in (f"/api/v1/recordings/{recording['id']}", f"/api/v1/runs/{run['id']}"):
        for chart in api.get(f"{owner}/charts").raise_for_status().json()["items"]:
            begin = time.perf_counter()
            answer = api.get(f"{owner}/charts/{chart['name']}.json").raise_for_status()
            name = f"chart {owner.split('/')[3][:-1]} {chart['name']}"
            steps[name], sizes[name] = time.perf_counter() - begin, len(answer.content)
    print(f"\n{marks} marks over HTTP")
    for name, seconds in steps.items():
        size = f"{sizes[name] / 1e3:8.0f} kB" if name in sizes else ""
        print(f"{name:60s} {seconds * 1e3:8.0f} ms {size}")


def time_recording_page(page: Page, url: str, marks: int, files: tuple[Path, Path]) -> None:
    """Print how long a user waits from the upload to the charts."""
    page.goto("about:blank")
    page.goto(f"{url}/#/new?source=upload")
    page.get_by_label("Marks", exact=True).set_input_files(files[0])
    page.get_by_label("Site", exact=True).set_input_files(files[1])
    page.get_by_label("Name").fill(f"by page {marks}")
    begin = time.perf_counter()
    page.get_by_role("button", name="Upload and read").click()
    button = page.get_by_role("button", name=ALGORITHMS[0], exact=True)
    expect(page.get_by_role("heading", name=f"by page {marks}", exact=True)).to_be_visible(timeout=120_000)
    read = time.perf_counter()
    for name in ALGORITHMS:
        page.get_by_role("button", name=name, exact=True).click()
    expect(button).to_be_visible()
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.locator(".run-head .state")).to_have_text("succeeded", timeout=300_000)
    computed = time.perf_counter()
    # Those on the first screen; the others are drawn as the reader comes to them.
    page.wait_for_function("() => document.querySelectorAll('chart-panel .plot svg').length >= 3", timeout=120_000)
    drawn = time.perf_counter()
    print(f"\n{marks} marks in the page")
    for what, seconds in (
        ("from the click on upload until it is read", read - begin),
        ("algorithms chosen, run computed", computed - read),
        ("three charts drawn", drawn - computed),
        ("from upload to charts", drawn - begin),
    ):
        print(f"{what:60s} {seconds * 1e3:8.0f} ms")


@contextmanager
def chromium(url: str) -> Iterator[Page]:
    """A page of a fresh browser that knows the token."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_program(), args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1366, "height": 768}, locale="en-GB", reduced_motion="reduce")
        page.set_default_timeout(60_000)
        page.goto(f"{url}/?token={TOKEN}")
        yield page
        browser.close()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10_000, help="stored runs; 0 leaves the lists out")
    parser.add_argument("--marks", type=int, nargs="*", default=[25_000, 50_000, 100_000])
    parser.add_argument("--repeats", type=int, default=60)
    parser.add_argument("--no-browser", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.runs:
            store_runs(folder / "lists", options.runs)
            with serving(folder / "lists") as server, server.client() as api:
                print(f"{options.runs} stored runs")
                # Just started it imports the charts besides; people work with one that has done so.
                time.sleep(SETTLING_S)
                time_lists(api, options.repeats)
                if not options.no_browser:
                    with chromium(server.url) as page:
                        time_list_page(page, server.url)
        if options.marks:
            with serving(folder / "marks") as server, server.client() as api:
                for marks in options.marks:
                    files = long_recording(marks, folder)
                    time_recording(api, marks, files)
                    if not options.no_browser:
                        with chromium(server.url) as page:
                            time_recording_page(page, server.url, marks, files)


if __name__ == "__main__":
    main()
