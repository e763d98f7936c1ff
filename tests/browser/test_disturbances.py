"""What goes wrong while a page is open: no blank page, no stale number, and it says so."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import STEP_TIMEOUT_MS, TOKEN, Server, Visit, free_port, wait_for_sample, wait_until_ready
from tests.browser.test_compare import finished_run
from tests.browser.test_page import forwarded, sample_run

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not


@contextmanager
def serving(folder: Path, port: int, token: str = TOKEN) -> Iterator[Server]:
    """A server of one's own, on a data folder that outlives it; it dies as if the power went."""
    url = f"http://127.0.0.1:{port}"
    command = [sys.executable, "-m", "backend.cli", "serve", "--data", str(folder / "data"), "--port", str(port)]
    environment = {**os.environ, "FILTERROOM_TOKEN": token, "FILTERROOM_WORKERS": "1"}
    log = folder / "server.log"
    with log.open("ab") as out:
        process = subprocess.Popen(
            command, cwd=Path(__file__).parent.parent.parent, env=environment, stdout=out, stderr=subprocess.STDOUT
        )
    try:
        wait_until_ready(url, process, log)
        wait_for_sample(Server(url, token))
        yield Server(url, token)
    finally:
        process.kill()
        process.wait()


def row(page: Page, text: str) -> Any:
    return page.locator("main tbody tr").filter(has_text=text)


def uploaded(server: Server, repository: Path, name: str) -> dict[str, Any]:
    """A recording of its own: the sample's marks without the first `len(name)` rows."""
    folder = repository / "examples" / "recordings"
    head, *marks = (folder / "sample_marks.csv").read_text().splitlines()
    text = "\n".join([head, *marks[len(name) :]])
    site = (folder / "sample_site.json").read_text()
    parts = [("file", f"{name}.csv", text), ("site", "site.json", site)]
    border = "border-of-parts"
    body = "".join(
        f'--{border}\r\nContent-Disposition: form-data; name="{field}"; filename="{file}"\r\n\r\n{content}\r\n'
        for field, file, content in parts
    )
    answer = ask_form(server, "recordings", f"{body}--{border}--\r\n".encode(), border)
    deadline = time.monotonic() + 180
    while answer["state"] == "parsing":
        assert time.monotonic() < deadline
        time.sleep(0.05)
        answer = server.ask(f"recordings/{answer['id']}")
    assert answer["state"] == "ready", answer
    return dict(answer)


def ask_form(server: Server, path: str, body: bytes, border: str) -> Any:
    """Send a form as a script does."""
    request = urllib.request.Request(
        f"{server.url}/api/v1/{path}",
        data=body,
        headers={"Authorization": f"Bearer {server.token}", "Content-Type": f"multipart/form-data; boundary={border}"},
    )
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.load(answer)


def test_a_restarted_server_is_found_again_by_every_page(visit: Callable[..., Visit], tmp_path: Path) -> None:
    """A list, a finished run and a form stay as they are, say that the server is away, and go on by themselves."""
    port = free_port()
    visits = {route: visit(url=f"http://127.0.0.1:{port}", known=False) for route in ("#/runs", "run", "#/new")}
    with serving(tmp_path, port) as first:
        pages = {route: visited.open("#/runs", first.token) for route, visited in visits.items()}
        run = sample_run(pages["run"])
        visits["run"].follow(run)
        (marks,) = (r for r in first.ask("recordings")["items"] if r["kind"] == "toa_marks")
        visits["#/new"].follow(f"#/new?recording={marks['id']}")
        expect(pages["run"].locator("chart-panel[data-drawn]").first).to_be_visible()
        pages["#/new"].locator("[data-add=rdf]").click()
        expect(pages["#/new"].locator("[data-algorithm]")).to_have_count(1)
    for page in pages.values():
        expect(page.locator(".lost")).to_be_visible()
        expect(page.locator("main")).to_have_class(re.compile("stale"))
    expect(row(pages["#/runs"], "Sample: three algorithms")).to_be_visible()
    expect(pages["run"].locator(".verdict")).to_be_visible()
    expect(pages["#/new"].locator("[data-algorithm]")).to_have_count(1)
    # What is said for some seconds may be gone again before anybody looks.
    pages["#/runs"].evaluate("""() => { window.said = ""; const area = document.querySelector("toast-area");
      new MutationObserver(() => { window.said += area.innerText }).observe(area, { childList: true }) }""")
    with serving(tmp_path, port) as second:
        for page in pages.values():
            expect(page.locator(".lost")).to_be_hidden()
        pages["#/runs"].wait_for_function("() => window.said.includes('answers again')")
        second.ask(run.removeprefix("#/"), {"label": "after the restart"}, method="PATCH")
        expect(row(pages["#/runs"], "after the restart")).to_be_visible()
        expect(pages["run"].locator(".run-head h1")).to_have_text("after the restart")
        start = pages["#/new"].get_by_role("button", name="Start", exact=True)
        expect(start).to_be_enabled()
        start.click()
        expect(pages["#/new"].locator(".run-head .state")).to_have_text("succeeded")
        for page in pages.values():
            page.context.close()


def test_what_changes_in_one_tab_appears_in_the_other(visit: Callable[..., Visit], server: Server) -> None:
    visited = visit()
    one = visited.open("#/runs")
    sample_run(one)
    other = one.context.new_page()
    other.goto(f"{server.url}/#/runs")
    sample_run(other)
    run = finished_run(server, label="seen in both", algorithms=[{"name": "single_mark"}])
    for page in (one, other):
        expect(row(page, "seen in both").locator(".state")).to_have_text("succeeded")
    row(one, "seen in both").get_by_role("button", name="Edit label").click()
    one.get_by_label("Label of the run").fill("renamed in one")
    one.keyboard.press("Enter")
    expect(row(other, "renamed in one")).to_be_visible()
    one.get_by_label("Theme").select_option("dark")
    expect(other.locator("html")).to_have_attribute("data-theme", "dark")
    other.evaluate("(id) => { location.hash = `#/runs/${id}` }", run["id"])
    expect(other.locator(".verdict")).to_be_visible()
    row(one, "renamed in one").get_by_role("button", name="Delete: renamed in one").click()
    one.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(row(one, "renamed in one")).to_have_count(0)

    # The reader of the other tab is told; nothing of the run stays.
    expect(other.get_by_role("alert")).to_contain_text("it was deleted")
    expect(other.locator("chart-panel, .verdict, .run-head .state")).to_have_count(0)
    other.get_by_role("alert").get_by_role("link", name="Runs").click()
    sample_run(other)


def test_a_recording_is_deleted_while_in_use(visit: Callable[..., Visit], server: Server, repository: Path) -> None:
    recording = uploaded(server, repository, "wanted")
    visited = visit()
    composing = visited.open(f"#/new?recording={recording['id']}")
    composing.locator("[data-add=rdf]").click()
    start = composing.get_by_role("button", name="Start", exact=True)
    expect(start).to_be_enabled()
    expect(composing.locator(".startbar [role=status]")).not_to_have_text("")
    reading = composing.context.new_page()
    reading.goto(f"{server.url}/#/recordings/{recording['id']}")
    expect(reading.get_by_role("heading", name="wanted")).to_be_visible()
    server.ask(f"recordings/{recording['id']}", method="DELETE")
    expect(composing.get_by_role("alert")).to_contain_text("it was deleted")
    expect(start).to_be_disabled()
    expect(composing.locator(".startbar [role=status]")).to_have_text("")
    expect(composing.get_by_text("wanted.csv")).to_have_count(0)
    # A chart that was just being fetched may say first that it is not there.
    expect(reading.get_by_role("alert").filter(has_text="it was deleted")).to_be_visible()
    expect(reading.locator("chart-panel, .tiles")).to_have_count(0)


def test_a_mapping_that_fits_nothing(visit: Callable[..., Visit], tmp_path: Path) -> None:
    """Counts of an earlier choice go; a filter that nothing passes says so, in the dialog and after an upload."""
    marks = tmp_path / "radar.csv"
    marks.write_text("time_s,range_m,azimuth_deg,day\n" + "".join(f"{i},{20000 + i},{i},monday\n" for i in range(9)))
    page = visit().open("#/new?source=upload")
    page.get_by_label("Marks", exact=True).set_input_files(marks)
    page.get_by_role("button", name="Map columns").click()
    dialog = page.get_by_role("dialog", name="What the columns mean")
    expect(dialog).to_contain_text("Of 9 rows: 9 accepted, 0 rejected.")
    dialog.get_by_role("button", name="Read only some rows").click()
    dialog.get_by_label("Column of the row filter").select_option("day")
    dialog.get_by_label("Value of the row filter").fill("sunday")
    expect(dialog.get_by_role("alert")).to_contain_text("No row has the values")
    expect(dialog.get_by_text("9 accepted")).to_have_count(0)
    dialog.get_by_role("button", name="Use this mapping").click()
    page.get_by_role("button", name="Upload and read").click()
    expect(page.locator(".failure")).to_contain_text("No row")
    expect(page.locator(".tiles")).to_have_count(0)
    expect(page.get_by_role("button", name="Map columns")).to_be_enabled()
    page.get_by_role("button", name="Map columns").click()
    dialog.get_by_label("Value of the row filter").fill("monday")
    expect(dialog).to_contain_text("Of 9 rows: 9 accepted, 0 rejected.")


def test_the_way_back_leads_to_what_was_there(visit: Callable[..., Visit]) -> None:
    """Through every kind of page and back again: each stands whole, and in the state it was left in."""
    visited = visit()
    page = visited.open("#/runs")
    run = sample_run(page)
    page.get_by_label("State", exact=True).select_option("succeeded")
    expect(page).to_have_url(re.compile("state=succeeded"))
    places = [page.evaluate("location.hash")]
    recording = page.evaluate("fetch('api/v1/recordings').then((r) => r.json()).then((r) => r.items.at(-1).id)")
    for route in (
        run,
        f'#/new?recording={recording}&a={{"name":"rdf"}}',
        "#/recordings",
        f"#/recordings/{recording}",
        "#/algorithms",
        "#/algorithms/rdf",
        "#/nowhere",
        "#/about",
    ):
        page.evaluate("(route) => { location.hash = route }", route)
        page.locator("main h1").first.wait_for(state="attached")
        visited.settle()
        places.append(page.evaluate("location.hash"))
    page.get_by_role("link", name="Runs").first.click()
    visited.settle()
    for place in reversed(places):
        page.go_back()
        page.wait_for_function("(place) => location.hash === place", arg=place)
        visited.settle()
        expect(page.locator("main"), place).to_contain_text(re.compile(r"\S"))
    expect(page.get_by_label("State", exact=True)).to_have_value("succeeded")
    page.go_forward()
    expect(page.locator(".verdict")).to_be_visible()


def test_two_servers_forwarded_to_one_browser(visit: Callable[..., Visit], server: Server, tmp_path: Path) -> None:
    """Cookies ignore ports: both servers stand at localhost, each with a token of its own, through `ssh -L`."""
    with ExitStack() as stack:
        other = stack.enter_context(serving(tmp_path, free_port(), "another-token"))
        ports = [stack.enter_context(forwarded(one.port, free_port())) for one in (server, other)]
        visited = visit(url=f"http://localhost:{ports[0]}", known=False)
        first = visited.open("#/runs", server.token)
        sample_run(first)
        second = first.context.new_page()
        second.goto(f"http://localhost:{ports[1]}/?token={other.token}#/runs")
        sample_run(second)
        other.ask(sample_run(second).removeprefix("#/"), {"label": "of the other server"}, method="PATCH")
        expect(row(second, "of the other server")).to_be_visible()
        first.reload()
        sample_run(first)
        expect(row(first, "of the other server")).to_have_count(0)
        second.reload()
        expect(row(second, "of the other server")).to_be_visible()
        expect(first.locator("token-form")).to_have_count(0)
        first.context.close()


def test_the_keys_of_a_russian_layout(visit: Callable[..., Visit]) -> None:
    """The letters stand where the Latin ones do; nobody changes the layout to press `g r`."""
    page = visit(locale="ru-RU").open("#/runs")
    sample_run_ru = page.locator("main [data-row-link]").first
    sample_run_ru.wait_for()
    keyboard = page.context.new_cdp_session(page)

    def press(key: str, code: str) -> None:
        for kind in ("keyDown", "keyUp"):
            keyboard.send("Input.dispatchKeyEvent", {"type": kind, "key": key, "code": code})

    press(",", "Slash")
    expect(page.get_by_role("dialog", name="Клавиши")).to_be_visible()
    page.keyboard.press("Escape")
    press("п", "KeyG")
    press("в", "KeyD")
    expect(page).to_have_url(re.compile("#/recordings$"), timeout=STEP_TIMEOUT_MS)
    press("т", "KeyN")
    expect(page).to_have_url(re.compile("#/new"))
