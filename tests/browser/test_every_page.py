"""Every page that the router knows: axe finds nothing, and nothing is wider than the screen.

Pages come from the table in `app-frame.js`, what they show from the API's list of the same name, tabs from the page, so
that a new page or tab is looked at without a line here.
"""

from __future__ import annotations

import contextlib
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, TimeoutError

from tests.browser.conftest import WITHOUT_PLOTS, Server, Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]

FRAME = Path(__file__).parents[2] / "frontend" / "components" / "app-frame.js"
WIDTHS = (360, 768, 1366, 2560)
# The themes differ only in their colours.
RULES: dict[str, dict[str, Any]] = {"light": {}, "dark": {"runOnly": ["color-contrast"]}}
LONG = (
    "a label of one hundred and twenty characters, as somebody writes who wants to say all about a run in the list " * 2
)
UNBROKEN = "flight_2026-11-28T09-15-00_north_sector_second_attempt_with_corrected_site_" * 2


def known_pages() -> dict[str, bool]:
    """First part of each route, and whether the router knows a page of one thing below it."""
    table = re.search(r"const PAGES = .*?\(\{(.*?)\}\)", FRAME.read_text("utf-8"), re.DOTALL)
    assert table
    return {
        name: one != "null"
        for name, one in re.findall(r'^  (\w+): \["[\w-]+", (null|"[\w-]+")\],$', table[1], re.MULTILINE)
    }


PAGES = known_pages()


def test_the_table_of_the_router_is_understood() -> None:
    """Each page module but the one for unknown addresses is in the table, and the table is read whole."""
    modules = {path.stem for path in FRAME.parents[1].joinpath("pages").glob("*-page.js")} - {"missing-page"}
    assert len(PAGES) + sum(PAGES.values()) == len(modules)


@pytest.fixture(scope="module")
def routes(server: Server) -> Iterator[dict[str, list[str]]]:
    """Addresses of each page: its list, each kind of thing in it, and what else it can show."""
    deadline = time.monotonic() + 180
    # The samples of other families may be done sooner.
    while not (done := server.ask("runs?state=succeeded&algorithm=rdf")["items"]):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    sample = done[-1]
    entries = [{"name": entry["name"]} for entry in sample["algorithms"]]
    bodies = (
        {"scenario": {"preset": "four_station_circuit"}, "trials": 3, "algorithms": entries, "label": LONG[:120]},
        {
            "recording_id": sample["source"]["recording_id"],
            "algorithms": entries,
            "label": UNBROKEN[:120],
            "tags": [UNBROKEN[:60]],
        },
    )
    made = [server.ask("runs", body)["id"] for body in bodies]
    while any(server.ask(f"runs/{run}")["state"] in ("queued", "running") for run in made):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    more = {
        "runs": ["#/runs?text=nothing+has+these+words", "#/runs/nothing"],
        "new": [
            "#/new?source=upload",
            "#/new?source=scenario",
            f"#/new?recording={sample['source']['recording_id']}",
        ],
        "compare": [f"#/compare?run={sample['id']}&run={made[1]}"],
    }
    found: dict[str, list[str]] = {}
    for name, has_things in PAGES.items():
        found[name] = [f"#/{name}", *more.get(name, [])]
        if has_things:
            things = server.ask(name)["items"]
            assert things, f"nothing to show on the page of one of {name}"
            found[name] += [f"#/{name}/{thing.get('id') or thing['name']}" for thing in things[:4]]
    found["nowhere"] = ["#/nowhere"]
    yield found
    for run in made:
        server.ask(f"runs/{run}", method="DELETE")


def views(visited: Visit, routes: list[str]) -> Iterator[str]:
    """Open each route, then each of its tabs."""
    for route in routes:
        # A page that is open already would only be told its new query, and `follow` has emptied it.
        visited.follow("#/nowhere/else")
        page = visited.follow(route)
        yield route
        for name in page.get_by_role("tab", selected=False).all_inner_texts():
            page.get_by_role("tab", name=name, exact=True).first.click()
            visited.settle()
            yield f"{route} {name}"


def too_wide(page: Page) -> list[str]:
    """What reaches beyond the screen, where the page can be scrolled sideways."""
    found: list[str] = page.evaluate(
        """() => document.documentElement.scrollWidth <= innerWidth ? [] :
        [...document.querySelectorAll('body *')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1)
        .map((e) => `${e.localName}.${e.className} ${Math.round(e.getBoundingClientRect().right)}`).slice(0, 5)"""
    )
    return found


def follow_the_window(page: Page) -> None:
    """Wait until the page fits the window; charts are drawn anew a while after it has changed."""
    # The frame after next has the new layout.
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    with contextlib.suppress(TimeoutError):
        page.wait_for_function("() => document.documentElement.scrollWidth <= innerWidth", timeout=2_000)


def squeezed(page: Page) -> list[str]:
    """Cells of tables in which the words stand in columns of letters."""
    found: list[str] = page.evaluate(
        """() => [...document.querySelectorAll('main td, main th')].filter((e) => {
            // Of the words themselves: a cell is as high as the highest of its row.
            const words = document.createRange();
            words.selectNodeContents(e);
            return e.checkVisibility() && e.clientWidth < 80 && words.getBoundingClientRect().height > 160;
        })
        .map((e) => `squeezed: ${e.innerText.slice(0, 30)}`).slice(0, 5)"""
    )
    return found


@pytest.mark.parametrize("name", [*PAGES, "nowhere"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(visit: Callable[..., Visit], routes: dict[str, list[str]], name: str, scheme: str) -> None:
    visited = visit(color_scheme=scheme)
    page = visited.open("#/about")
    visited.settle()
    found = []
    for view in views(visited, routes[name]):
        results = Axe().run(page, context=WITHOUT_PLOTS, options=RULES[scheme])
        found += [f"{view}: {v['id']} {[n['target'] for n in v['nodes']][:3]}" for v in results.response["violations"]]
    assert not found, "\n".join(found)


# Pages with charts have width tests of their own: here a chart follows the window later than the eye looks.
@pytest.mark.parametrize("name", [*(p for p in PAGES if p not in ("runs", "recordings", "map")), "nowhere"])
@pytest.mark.parametrize("language", ["en-GB", "ru-RU"])
def test_nothing_is_wider_than_the_screen(
    visit: Callable[..., Visit], routes: dict[str, list[str]], name: str, language: str
) -> None:
    visited = visit(locale=language)
    page = visited.open("#/about")
    visited.settle()
    found = []
    for view in views(visited, routes[name]):
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 844})
            follow_the_window(page)
            found += [f"{view} at {width}: {what}" for what in (*too_wide(page), *squeezed(page))]
        page.set_viewport_size({"width": 1366, "height": 768})
    assert not found, "\n".join(found)
