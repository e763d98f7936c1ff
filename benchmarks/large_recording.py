"""A long recording from the upload to the charts in the page: seconds and memory of each stage, and how they grow.

Real HTTP, a real Chromium, a data folder of its own. Wall times depend on who else uses the machine; processor seconds
(of the server, its workers, its reader, the browser) hardly do. Peak memory is the resident set of the largest process
of each kind during the stage.
Run: uv run --group dev python benchmarks/large_recording.py [--marks 10000 100000 1000000] [--algorithms rdfv]
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
from playwright.sync_api import Page

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.server import chromium, finished, long_recording, serving, upload

KINDS = ("server", "worker", "reader", "browser")
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# Charts are drawn as they come into view; this is how far the page is moved at once.
STEP_PX = 500


@dataclass(frozen=True)
class Stage:
    """What one stage took: seconds by the clock, processor seconds and peak memory (MB) by kind of process."""

    name: str
    wall_s: float
    cpu_s: Mapping[str, float]
    peak_mb: Mapping[str, float]
    remark: str = ""


@dataclass
class Watch:
    """Processes of a server and what they use, read from /proc."""

    server: int
    stages: list[Stage] = field(default_factory=list)
    kinds: dict[int, str] = field(default_factory=dict)
    last: dict[int, float] = field(default_factory=dict)

    def look(self, kind: str) -> None:
        """Take up the processes that are there and not known yet: they are of this kind."""
        for pid in (self.server, *descendants(self.server)):
            self.kinds.setdefault(pid, "server" if pid == self.server else kind)
        for pid in descendants(os.getpid()):
            if "chrom" in command_of(pid):
                self.kinds.setdefault(pid, "browser")

    @contextmanager
    def stage(self, name: str, kind: str = "worker") -> Iterator[dict[str, str]]:
        """Measure what happens inside; processes that appear meanwhile are of this kind."""
        said: dict[str, str] = {}
        self.look(kind)
        before = {pid: cpu_of(pid) for pid in self.kinds}
        for pid in before:
            forget_peak(pid)
        begin = time.perf_counter()
        yield said
        wall = time.perf_counter() - begin
        self.look(kind)
        cpu, peak = dict.fromkeys(KINDS, 0.0), dict.fromkeys(KINDS, 0.0)
        for pid, what in self.kinds.items():
            cpu[what] += max(cpu_of(pid) - before.get(pid, 0.0), 0.0)
            peak[what] = max(peak[what], peak_of(pid))
        self.stages.append(Stage(name, wall, cpu, peak, said.get("remark", "")))


def descendants(pid: int) -> list[int]:
    """Processes below this one."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            for child in task.read_text().split():
                found += [int(child), *descendants(int(child))]
    return found


def command_of(pid: int) -> str:
    """Command line of a process; empty where it is gone."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_text().replace("\0", " ")
    return ""


def cpu_of(pid: int) -> float:
    """Processor seconds of a process so far; 0 where it is gone."""
    with contextlib.suppress(OSError):
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / TICKS_PER_S
    return 0.0


def peak_of(pid: int) -> float:
    """Largest resident set of a process since `forget_peak`, MB."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1e3
    return 0.0


def forget_peak(pid: int) -> None:
    """Let the peak of a process begin anew."""
    with contextlib.suppress(OSError):
        Path(f"/proc/{pid}/clear_refs").write_text("5")


def through_http(api: httpx2.Client, watch: Watch, files: tuple[Path, Path], algorithms: list[str]) -> str:
    """Upload, read, run and draw over HTTP; return the run's id."""
    content, site = (path.read_bytes() for path in files)
    with watch.stage("upload and read", "reader") as said:
        recording = upload(api, content, site, files[0].stem)
        said["remark"] = f"{len(content) / 1e6:.1f} MB"
    body = {"recording_id": recording["id"], "algorithms": [{"name": name} for name in algorithms]}
    with watch.stage("run, result stored") as said:
        run = finished(api, api.post("/api/v1/runs", json=body).raise_for_status().headers["location"])
        blocks = ", ".join(f"{label} {seconds:.1f} s" for label, seconds in run["seconds"].items())
        said["remark"] = f"{run['result_bytes'] / 1e6:.0f} MB, {blocks}" if "result_bytes" in run else blocks
    for owner in (f"/api/v1/recordings/{recording['id']}", f"/api/v1/runs/{run['id']}"):
        sizes = {}
        with watch.stage(f"charts of the {owner.split('/')[3][:-1]} as JSON") as said:
            for chart in api.get(f"{owner}/charts").raise_for_status().json()["items"]:
                answer = api.get(f"{owner}/charts/{chart['name']}.json", params={"points": 1500}).raise_for_status()
                sizes[chart["name"]] = len(answer.content) / 1e3
            largest = max(sizes, key=lambda name: sizes[name])
            said["remark"] = f"{len(sizes)}, the largest {largest} {sizes[largest]:.0f} kB"
    return str(run["id"])


def through_page(page: Page, url: str, watch: Watch, run_id: str) -> None:
    """Open the run in the page and go down to the end: every chart is drawn."""
    page.add_init_script(
        "window.blocked = 0; new PerformanceObserver((list) => { for (const task of list.getEntries())"
        " window.blocked = Math.max(window.blocked, task.duration) }).observe({ type: 'longtask', buffered: true })"
    )
    with watch.stage("page: opened"):
        page.goto("about:blank")
        page.goto(f"{url}/#/runs")
        # What a person waits for; the library of the charts comes when the page has nothing else to do, or with the
        # first chart: then it is part of the next stage.
        page.locator("runs-page tbody tr").first.wait_for()
        page.evaluate("window.blocked = 0")
    with watch.stage("page: first screen of the run drawn") as said:
        page.evaluate(f"location.hash = '#/runs/{run_id}'")
        page.wait_for_function("() => document.querySelectorAll('chart-panel[data-drawn]').length >= 3")
        said["remark"] = blocked(page)
    with watch.stage("page: all charts drawn") as said:
        count = page.locator("chart-panel").count()
        for position in range(count):
            page.locator("chart-panel").nth(position).scroll_into_view_if_needed()
        page.wait_for_function(
            "() => [...document.querySelectorAll('chart-panel')].every("
            "(e) => e.dataset.drawn || e.querySelector('.not-applicable'))",
            timeout=120_000,
        )
        said["remark"] = f"{count} charts, {blocked(page)}"
    with watch.stage("page: a table of the run opened") as said:
        page.get_by_role("tab", name="Decisions").click()
        page.locator("data-table tbody tr").first.wait_for()
        said["remark"] = blocked(page)


def blocked(page: Page) -> str:
    """Longest time for which the page did not answer, in words."""
    return f"blocked for {page.evaluate('Math.round(window.blocked)')} ms at most"


def print_table(marks: int, stages: list[Stage]) -> None:
    """Print the stages of one recording."""
    print(f"\n{marks} marks{'':22s} {'wall s':>7s}   processor s: " + " ".join(f"{k:>7s}" for k in KINDS), end="")
    print("   peak MB: " + " ".join(f"{k:>7s}" for k in KINDS))
    for s in stages:
        cpu = " ".join(f"{s.cpu_s[k]:7.2f}" for k in KINDS)
        peak = " ".join(f"{s.peak_mb[k]:7.0f}" for k in KINDS)
        print(f"{s.name:36s} {s.wall_s:7.2f}                {cpu}            {peak}   {s.remark}")
    total = " ".join(f"{sum(s.cpu_s[k] for s in stages):7.2f}" for k in KINDS)
    most = " ".join(f"{max(s.peak_mb[k] for s in stages):7.0f}" for k in KINDS)
    print(f"{'all':36s} {sum(s.wall_s for s in stages):7.2f}                {total}            {most}", flush=True)


def print_growth(found: Mapping[int, list[Stage]]) -> None:
    """Print processor time per mark of each stage: rising figures are growth worse than linear."""
    sizes = sorted(found)
    print(f"\n{'processor us per mark':36s} " + " ".join(f"{n:>10d}" for n in sizes))
    for position, stage in enumerate(found[sizes[0]]):
        shares = [sum(found[n][position].cpu_s.values()) / n * 1e6 for n in sizes]
        print(f"{stage.name:36s} " + " ".join(f"{share:10.1f}" for share in shares))


def measure(marks: int, algorithms: list[str], folder: Path, with_browser: bool) -> list[Stage]:
    """Measure the whole way of one recording with a fresh server."""
    files = long_recording(marks, folder)
    with serving(folder / f"data{marks}") as server, server.client() as api:
        # What a server does once in its life is no part of a recording's way.
        while api.get("/api/v1/meta").raise_for_status().json()["engine"]["state"] != "ready":
            time.sleep(0.2)
        watch = Watch(server.process.pid)
        watch.look("worker")
        run_id = through_http(api, watch, files, algorithms)
        if with_browser:
            with chromium(server.url) as page:
                through_page(page, server.url, watch, run_id)
    return watch.stages


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--marks", type=int, nargs="*", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--algorithms", nargs="*", default=["rdfv"])
    parser.add_argument("--no-browser", action="store_true")
    options: Any = parser.parse_args()
    found: dict[int, list[Stage]] = {}
    for marks in options.marks:
        with tempfile.TemporaryDirectory() as name:
            found[marks] = measure(marks, options.algorithms, Path(name), not options.no_browser)
        print_table(marks, found[marks])
    if len(found) > 1:
        print_growth(found)


if __name__ == "__main__":
    main()
