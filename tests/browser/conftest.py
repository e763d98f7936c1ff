"""A real server in a process of its own and an installed Chromium; what a page asked for and said is kept."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

from backend.api.samples import SAMPLES

START_TIMEOUT_S = 180
# Nothing of a healthy page takes longer on two cores that others keep busy too.
STEP_TIMEOUT_MS = 45_000
# Playwright keeps a limit of its own for expectations, 5 s, whatever that of the context is.
expect.set_options(timeout=STEP_TIMEOUT_MS)
TOKEN = "browser-test-token"
# For axe: what a chart draws is an image to a screen reader.
WITHOUT_PLOTS = {"include": [["html"]], "exclude": [[".plot > *"]]}
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@dataclass(frozen=True)
class Server:
    """Where the server answers, and its token."""

    url: str
    token: str

    @property
    def port(self) -> int:
        """The port it listens on."""
        port = urlsplit(self.url).port
        assert port is not None
        return port

    def ask(self, path: str, body: Any = None, method: str | None = None) -> Any:
        """Ask the API as a script does; with a body it is told something."""
        head = {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json"}
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(f"{self.url}/api/v1/{path}", data, head, method=method)
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.loads(answer.read() or b"null")

    def sample_run(self, words: str) -> dict[str, Any]:
        """The run on the sample whose name holds these words."""
        (run,) = (run for run in self.ask("runs?tag=sample")["items"] if words in run["label"])
        return dict(run)


@dataclass
class Visit:
    """A page with everything it asked for and everything it complained about."""

    page: Page
    url: str
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def open(self, route: str = "", token: str | None = None) -> Page:
        """Go to a route of the page; with a token, through the address that the server prints."""
        query = f"?token={token}" if token else ""
        self.page.goto("about:blank")
        self.page.goto(f"{self.url}/{query}{route}")
        return self.page

    def follow(self, route: str) -> Page:
        """Go to a route inside the open page, as a link does, and wait until it stands."""
        self.page.evaluate(
            "(route) => { document.querySelector('main').replaceChildren(); location.hash = route }", route
        )
        self.settle()
        return self.page

    def settle(self) -> None:
        """Wait until the page of the route stands; charts below the fold are drawn only when they come into view."""
        self.page.wait_for_function(
            "() => document.querySelector('main')?.innerText.trim()"
            " && ![...document.querySelectorAll('main .skeleton')].some((e) => !e.closest('chart-panel'))"
        )

    def assert_clean(self) -> None:
        """Nothing was asked of another origin, and the console stayed silent."""
        origin = urlsplit(self.url).netloc
        foreign = [r for r in self.requests if urlsplit(r).scheme in ("http", "https") and urlsplit(r).netloc != origin]
        assert not foreign, foreign
        assert not self.complaints, self.complaints


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """`filterroom serve` on a free port with a new data folder, ready for runs."""
    folder = tmp_path_factory.mktemp("browser")
    log = folder / "server.log"
    url = f"http://127.0.0.1:{free_port()}"
    command = [
        sys.executable,
        "-m",
        "backend.cli",
        "serve",
        "--data",
        str(folder / "data"),
        "--port",
        url.rsplit(":", 1)[1],
    ]
    environment = {**os.environ, "FILTERROOM_TOKEN": TOKEN, "FILTERROOM_WORKERS": "2"}
    root = Path(__file__).parent.parent.parent
    with log.open("wb") as out:
        process = subprocess.Popen(command, cwd=root, env=environment, stdout=out, stderr=subprocess.STDOUT)
    try:
        wait_until_ready(url, process, log)
        wait_for_sample(Server(url, TOKEN))
        yield Server(url, TOKEN)
    finally:
        process.terminate()
        try:
            process.wait(15)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def wait_until_ready(url: str, process: subprocess.Popen[bytes], log: Path) -> None:
    """Wait for the workers; what the server said stands in the failure."""
    deadline = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < deadline:
        if process.poll() is not None:
            pytest.fail(f"the server ended with status {process.returncode}:\n{log.read_text()}")
        try:
            with urllib.request.urlopen(f"{url}/readyz", timeout=2):
                return
        except (urllib.error.URLError, OSError):
            time.sleep(0.1)
    pytest.fail(f"the server was not ready after {START_TIMEOUT_S} s:\n{log.read_text()}")


def chromium_program() -> str | None:
    """Chromium, from FILTERROOM_CHROMIUM or the search path."""
    return os.environ.get("FILTERROOM_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")


def wait_for_sample(server: Server) -> None:
    """Wait for the runs that a new server starts by itself, a while after it is ready: tests begin with them."""
    deadline = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < deadline:
        if len(server.ask("runs?state=succeeded")["items"]) >= len(SAMPLES):
            return
        time.sleep(0.1)
    states = {run["label"]: (run["state"], run["error"]) for run in server.ask("runs")["items"]}
    pytest.fail(f"the samples were not run after {START_TIMEOUT_S} s: {states}, {server.ask('meta')['engine']}")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium; without one these tests fail."""
    program = chromium_program()
    if program is None:
        pytest.fail("no Chromium: install `chromium`, or name the program in FILTERROOM_CHROMIUM")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield chromium
        chromium.close()


@pytest.fixture
def visit(server: Server, browser: Browser) -> Iterator[Callable[..., Visit]]:
    """Open a fresh browser profile that knows the token (`known=False`: does not)."""
    contexts: list[BrowserContext] = []

    def start(*, url: str = server.url, known: bool = True, **options: Any) -> Visit:
        options.setdefault("viewport", {"width": 1366, "height": 768})
        options.setdefault("locale", "en-GB")
        options.setdefault("reduced_motion", "reduce")
        context = browser.new_context(**options)
        context.set_default_timeout(STEP_TIMEOUT_MS)
        contexts.append(context)
        context.add_init_script(
            "document.addEventListener('securitypolicyviolation', (event) => "
            "console.error('policy', event.violatedDirective, event.blockedURI))"
        )
        visited = Visit(context.new_page(), url)
        visited.page.on("request", lambda request: visited.requests.append(request.url))
        visited.page.on(
            "console", lambda message: visited.complaints.append(message.text) if message.type == "error" else None
        )
        visited.page.on("pageerror", lambda error: visited.complaints.append(str(error)))
        if known:
            # The profile gets its cookie without a page being built for it; it shares cookies with its requests.
            context.request.get(f"{url}/?token={server.token}", max_redirects=0)
        return visited

    yield start
    for context in contexts:
        context.close()


@pytest.fixture
def broken_marks(repository: Path, tmp_path: Path) -> Path:
    """The sample's marks with three rows that cannot be read: data rows 5, 9 and 12."""
    lines = (repository / "examples" / "recordings" / "sample_marks.csv").read_text().splitlines()
    cells = [line.split(",") for line in lines]
    cells[5][0] = "noon"
    cells[9][2] = "12a4"
    cells[12] = cells[11]
    path = tmp_path / "broken_marks.csv"
    path.write_text("\n".join(",".join(row) for row in cells) + "\n")
    return path
