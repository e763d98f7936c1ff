"""The accuracy map: a station is dragged, moved by keys and left out, subsets are compared; in Russian, on a phone."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.conftest import WITHOUT_PLOTS, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

# Plotly has taken the base64 apart; the shades are logarithms.
_CELLS = """() => { const { z } = document.querySelector('map-page .plot')._fullData[0];
    const values = [...z].flatMap((row) => [...row]), known = values.filter(Number.isFinite);
    return { cells: values.length, known: known.length, low: Math.min(...known), high: Math.max(...known) }; }"""


def fresh(page: Page) -> None:
    page.locator("map-page[data-fresh=yes]").wait_for()


def drawn(page: Page) -> dict[str, Any]:
    found: dict[str, Any] = page.evaluate(_CELLS)
    return found


def place_of(page: Page, station: str) -> str:
    words = page.locator(f"station-handles [data-name='{station}']").get_attribute("aria-label")
    assert words
    return words


def test_a_station_follows_the_pointer_and_the_keys(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/map?source=scenario:four_station_circuit")
    fresh(page)
    before = drawn(page)
    assert before["cells"] == before["known"] == 200 * 200
    handle = page.locator("station-handles [data-name='1']")
    expect(handle).to_have_attribute("aria-label", re.compile("5.000 km east, 8.660 km north"))
    box = handle.bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y - 40, steps=6)
    page.mouse.up()
    expect(handle).not_to_have_attribute("aria-label", re.compile("5.000 km east"))
    page.wait_for_function(
        "() => document.querySelector('map-page').dataset.fresh === 'yes'"
        " && document.querySelector('map-page .plot')._fullData[0].x.length === 200"
    )
    assert drawn(page) != before, "the map followed the station"
    moved = place_of(page, "1")
    handle.focus()
    page.keyboard.press("ArrowLeft")
    expect(handle).not_to_have_attribute("aria-label", moved)
    # The address holds the changed site: the page comes back as it was.
    fresh(page)
    here = place_of(page, "1")
    page.reload()
    fresh(page)
    assert place_of(page, "1") == here

    page.get_by_label("Map of").select_option("altitude_known")
    page.get_by_role("button", name="Compare subsets").click()
    rows = page.locator("map-page data-table tbody tr")
    expect(rows).to_have_count(5)
    rows.filter(has_text="1, 2, 3").last.click()
    expect(page.get_by_role("checkbox", name="4", exact=True)).not_to_be_checked()
    fresh(page)
    page.get_by_label("Map of").select_option("space")
    nowhere = page.get_by_text("Nowhere on this map can the stations tell a position")
    expect(nowhere).to_be_visible()
    page.reload()
    expect(nowhere).to_be_visible()
    expect(page.get_by_role("checkbox", name="4", exact=True)).not_to_be_checked()
    page.get_by_role("checkbox", name="4", exact=True).check()
    expect(page.locator("map-page .plot .heatmaplayer image")).to_have_count(1)
    # A number typed into the table moves the station, and the clocks beside it follow while it has the focus.
    north = page.get_by_label("North, m, 4")
    clock = page.locator("map-page table.edit tbody tr").last.locator("td").last
    before_move = clock.inner_text()
    north.fill("4000")
    north.press("Enter")
    expect(clock).not_to_have_text(before_move)
    expect(north).to_be_focused()
    page.get_by_label("Altitude of the emitter, m").fill("high")
    expect(page.locator("map-page chart-panel.stale")).to_have_count(1)
    expect(page.get_by_label("Altitude of the emitter, m")).to_have_attribute("aria-invalid", "true")
    visited.assert_clean()


def test_it_stands_in_russian_at_night_and_on_a_phone(visit: Callable[..., Visit]) -> None:
    visited = visit(locale="ru-RU", color_scheme="dark")
    page = visited.open("#/map?variant=clock")
    fresh(page)
    page.get_by_role("button", name="Сравнить наборы").click()
    page.locator("map-page data-table tbody tr").first.wait_for()
    names = page.evaluate(
        "() => fetch('api/v1/recordings').then((r) => r.json()).then((a) => a.items.map((one) => one.name))"
    )
    assert not english_left(page, names)
    assert not Axe().run(page, context=WITHOUT_PLOTS).response["violations"]
    page.set_viewport_size({"width": 360, "height": 780})
    page.wait_for_function("() => document.documentElement.scrollWidth <= 360")
