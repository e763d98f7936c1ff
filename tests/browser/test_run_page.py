"""The run page as a tool: one instant in all charts."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import Visit
from tests.browser.test_page import sample_run

pytestmark = pytest.mark.browser
OVER_TIME = ("Horizontal error", "NIS", "Altitude", "Receptions")


def open_run(visited: Visit, query: str = "") -> Page:
    """The run that a new server comes with, its first charts drawn."""
    page = visited.open("#/runs")
    visited.open(sample_run(page) + query)
    for heading in ("Plan", "Horizontal error", "NIS"):
        drawn(page, heading)
    return page


def hover(page: Page, heading: str, across: float) -> None:
    """Put the mouse into a chart, at a share of its width."""
    page.evaluate("window.scrollTo(0, 0)")
    box = panel_of(page, heading).locator(".plot .nsewdrag").first.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + across * box["width"], box["y"] + box["height"] / 2)


def test_one_instant_in_all_charts(visit: Callable[..., Visit]) -> None:
    visited = visit(viewport={"width": 1366, "height": 1600})
    page = open_run(visited)
    for heading in OVER_TIME:
        drawn(page, heading)
    hover(page, "Horizontal error", 0.5)
    for heading in OVER_TIME:
        expect(panel_of(page, heading).locator(".overlay line")).to_have_count(1)
    expect(panel_of(page, "Plan").locator(".overlay circle").first).to_be_attached()
    strip = panel_of(page, "Horizontal error").locator(".strip")
    expect(strip).to_contain_text(re.compile(r"Time [\d.]+ s"))
    expect(strip).to_contain_text(re.compile(r"rdfv, actual [\d.]+ m"))
    times = [panel_of(page, h).locator(".strip b").first.inner_text() for h in ("Plan", *OVER_TIME)]
    assert len(set(times)) == 1, times

    # A click locks it, the mouse no longer moves it; arrow keys step one mark and say so; Escape frees it.
    page.mouse.down()
    page.mouse.up()
    hover(page, "NIS", 0.8)
    assert strip.locator("b").first.inner_text() == times[0]
    page.keyboard.press("ArrowRight")
    expect(strip.locator("b").first).not_to_have_text(times[0])
    stepped = strip.locator("b").first.inner_text()
    assert float(stepped.split()[0]) > float(times[0].split()[0])
    expect(panel_of(page, "Horizontal error").locator("[aria-live]")).to_contain_text(stepped)
    page.keyboard.press("ArrowLeft")
    expect(strip.locator("b").first).to_have_text(times[0])
    page.keyboard.press("Escape")
    expect(page.locator("chart-panel .overlay line")).to_have_count(0)
    visited.assert_clean()
