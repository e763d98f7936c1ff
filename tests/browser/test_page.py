"""The page itself: first start, origin, token, keyboard, a forwarded port, phones, unknown addresses, accessibility."""

from __future__ import annotations

import re
import selectors
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn
from tests.browser.conftest import WITHOUT_PLOTS, Server, Visit, free_port
from tests.browser.keyboard import tab_to

pytestmark = pytest.mark.browser


def sample_run(page: Page) -> str:
    """The route of the run that a new server comes with."""
    link = page.get_by_role("link", name=re.compile("^Sample: three algorithms")).last
    link.wait_for()
    route = link.get_attribute("href")
    assert route is not None
    return route


def test_the_sample_is_there_and_nothing_leaves_the_origin(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    route = sample_run(page)
    expect(page.get_by_role("row", name=re.compile("succeeded.*Sample: three algorithms"))).to_be_visible()
    visited.follow(route)
    for heading in ("Plan", "Horizontal error", "NIS", "Altitude", "Receptions"):
        assert any(trace["points"] for trace in drawn(page, heading)["traces"]), heading
    for other in ("#/new", "#/recordings", "#/algorithms", "#/algorithms/rdfv", "#/about"):
        visited.follow(other)
        expect(page.locator("main h1")).to_have_count(1)
    visited.assert_clean()


def test_an_unknown_browser_is_asked_for_the_token(visit: Callable[..., Visit], server: Server) -> None:
    visited = visit(known=False)
    page = visited.open("#/recordings")
    page.get_by_label("Token").fill("wrong")
    page.get_by_role("button", name="Enter").click()
    expect(page.get_by_role("alert")).to_contain_text("did not accept")
    page.get_by_label("Token").fill(server.token)
    page.get_by_role("button", name="Enter").click()
    expect(page.get_by_role("link", name="sample_marks.csv")).to_be_visible()
    assert "token" not in page.url
    assert page.url.endswith("#/recordings"), "one stays where one wanted to go"


def test_a_run_is_started_by_keyboard_alone(visit: Callable[..., Visit]) -> None:
    page = visit().open("#/runs")
    sample_run(page)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keyboard")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog", name="Keyboard")).to_be_hidden()
    page.keyboard.press("Tab")
    page.keyboard.press("n")
    expect(page).to_have_url(re.compile("#/new"))
    page.get_by_role("radio").first.wait_for()
    tab_to(page, "input[type=radio]")
    page.keyboard.press("Space")
    tab_to(page, "[data-add=single_mark]")
    page.keyboard.press("Enter")
    # Tab passes over a button that is still disabled.
    expect(page.locator(".startbar button").first).to_be_enabled()
    tab_to(page, ".startbar button")
    expect(page.locator(":focus")).to_be_enabled()
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("#/runs/"))
    expect(page.locator(".run-head .state")).to_have_text("succeeded")
    plan = page.locator("chart-panel .plot").first
    plan.wait_for()
    drawn(page, "Plan")
    plan.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(page.locator("chart-panel .strip").first).to_contain_text("km")


@pytest.mark.slow
def test_the_address_holds_the_state_of_the_page(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    route = sample_run(page)
    visited.open(f"{route}?tab=parameters&hide=rdf")
    expect(page.get_by_role("tab", name="Parameters")).to_have_attribute("aria-selected", "true")
    expect(page.locator("legend-chips [aria-pressed=false]")).to_have_text("rdf")
    page.get_by_role("link", name="Run again").click()
    expect(page.locator("[data-algorithm]")).to_have_count(3)
    page.reload()
    expect(page.locator("[data-algorithm]")).to_have_count(3)
    visited.open("#/runs/nothing")
    expect(page.locator(".failure")).to_contain_text("not_found")
    visited.open("#/nowhere")
    expect(page.get_by_text("names no page")).to_be_visible()


# Every page, tab, width and theme is looked at in test_every_page.py; here, quickly, what is used most.


def test_nothing_is_cut_off(visit: Callable[..., Visit]) -> None:
    visited = visit(viewport={"width": 360, "height": 844})
    page = visited.open("#/runs")
    run = sample_run(page)
    for route in (run, "#/new", "#/recordings", "#/algorithms", "#/algorithms/rdfv", "#/about"):
        visited.follow(route)
        overflow = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
        assert overflow <= 0, (route, overflow)


def test_a_run_fits_the_first_screen(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    visited.follow(sample_run(page))
    for heading in ("Plan", "Horizontal error", "NIS"):
        drawn(page, heading)
    bottoms = page.evaluate(
        "[...document.querySelectorAll('.verdict, chart-panel.first, chart-panel.time')]"
        ".map((e) => e.getBoundingClientRect().bottom)"
    )
    assert len(bottoms) == 4
    assert max(bottoms) <= 768


@pytest.mark.slow
def test_axe_finds_nothing(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    routes = ("#/new?source=upload", sample_run(page), "#/runs")
    found = []
    for route in routes:
        visited.follow(route)
        results = Axe().run(page, context=WITHOUT_PLOTS)
        found += [f"{route}: {v['id']} {[n['target'] for n in v['nodes']][:3]}" for v in results.response["violations"]]
    assert not found, "\n".join(found)


@pytest.mark.slow
def test_the_theme_recolours_the_charts(visit: Callable[..., Visit]) -> None:
    visited = visit(color_scheme="light")
    page = visited.open("#/runs")
    visited.follow(sample_run(page))
    light = drawn(page, "Plan").traces(role="truth")[0]["color"]
    page.get_by_label("Theme").select_option("dark")
    page.wait_for_function(
        "(light) => document.querySelector('chart-panel .plot')._fullData"
        ".find((t) => t.meta.role === 'truth').line.color !== light",
        arg=light,
    )
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(14, 17, 19)"


def test_russian(visit: Callable[..., Visit]) -> None:
    page = visit(locale="ru-RU").open("#/runs")
    expect(page.get_by_role("link", name="Новый расчёт").first).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == "ru"
    page.get_by_label("Язык").select_option("en")
    expect(page.get_by_role("link", name="New run").first).to_be_visible()


@contextmanager
def forwarded(target_port: int, port: int) -> Iterator[int]:
    """Forward another local port to the server, as `ssh -L` does."""
    listener = socket.create_server(("127.0.0.1", port))
    listener.settimeout(0.2)
    stopped = threading.Event()

    def pump(near: socket.socket) -> None:
        with near, socket.create_connection(("127.0.0.1", target_port)) as far, selectors.DefaultSelector() as ready:
            ready.register(near, selectors.EVENT_READ, far)
            ready.register(far, selectors.EVENT_READ, near)
            while not stopped.is_set():
                for key, _ in ready.select(0.2):
                    assert isinstance(key.fileobj, socket.socket)
                    try:
                        data = key.fileobj.recv(65536)
                        if not data:
                            return
                        key.data.sendall(data)
                    except OSError:
                        return

    def accept() -> None:
        while not stopped.is_set():
            try:
                near, _ = listener.accept()
            except TimeoutError:
                continue
            near.setblocking(True)
            threads.append(threading.Thread(target=pump, args=(near,)))
            threads[-1].start()

    threads = [threading.Thread(target=accept)]
    threads[0].start()
    try:
        yield port
    finally:
        stopped.set()
        for thread in threads:
            thread.join()
        listener.close()


@pytest.mark.slow
def test_a_forwarded_port_changes_nothing(visit: Callable[..., Visit], server: Server) -> None:
    with forwarded(server.port, free_port()) as port:
        visited = visit(url=f"http://localhost:{port}")
        page = visited.open("#/runs")
        visited.follow(sample_run(page))
        assert drawn(page, "Plan").traces(role="series")
        page.get_by_role("link", name="Run again").click()
        expect(page.locator("[data-algorithm]")).to_have_count(3)
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.locator(".run-head .state")).to_have_text("succeeded")
        visited.assert_clean()
        page.context.close()


@pytest.mark.slow
def test_a_lost_server_is_said_and_found_again(visit: Callable[..., Visit], server: Server) -> None:
    """The forwarded port goes away and comes back, as a server that is restarted does."""
    port = free_port()
    visited = visit(url=f"http://127.0.0.1:{port}", known=False)
    page = visited.page
    with forwarded(server.port, port):
        visited.open("#/runs", server.token)
        sample_run(page)
        # The other pages are fetched in the background, so that one can still go to them.
        page.wait_for_function("() => customElements.get('recordings-page')")
    page.evaluate("location.hash = '#/recordings'")
    expect(page.locator(".lost")).to_be_visible()
    expect(page.locator(".failure")).to_contain_text("does not answer")
    with forwarded(server.port, port):
        expect(page.locator(".lost")).to_be_hidden()
        expect(page.get_by_role("link", name="sample_marks.csv")).to_be_visible()
        page.context.close()
