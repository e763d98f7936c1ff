"""Whoever works with keys goes on where they were: what a button draws anew does not take the focus to the top."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]


def press(page: Page, selector: str, key: str = "Enter", at: int = 0) -> None:
    """Press a key on what the selector finds."""
    page.locator(selector).nth(at).press(key)


def test_algorithms_and_swept_parameters_of_a_new_run(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/new?source=scenario")
    for name in ("rdf", "rdfv", "mlat_imm"):
        press(page, f"[data-add={name}]")
        expect(page.locator(f"[data-add={name}]")).to_be_focused()
    drops = page.locator("algorithm-entries [data-drop]")
    expect(drops).to_have_count(3)
    drops.nth(1).press("Enter")
    expect(drops).to_have_count(2)
    # What took its place.
    expect(drops.nth(1)).to_be_focused()
    drops.nth(1).press("Enter")
    expect(drops.nth(0)).to_be_focused()
    drops.nth(0).press("Enter")
    expect(page.locator("[data-add=rdf]")).to_be_focused()

    add = page.get_by_role("button", name="Sweep a parameter")
    add.press("Enter")
    expect(page.locator("[data-sweep] select")).to_be_focused()
    add.press("Enter")
    expect(page.locator("[data-sweep] select").nth(1)).to_be_focused()
    press(page, "[data-sweep] button")
    expect(page.locator("[data-sweep] button")).to_be_focused()
    press(page, "[data-sweep] button")
    expect(add).to_be_focused()
    visited.assert_clean()


def test_rows_of_a_scenario(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/scenarios?preset=four_station_circuit")
    drops = page.locator('[data-drop="/stations"]')
    expect(drops).to_have_count(4)
    page.locator('[data-add="/stations"]').press("Enter")
    expect(drops).to_have_count(5)
    expect(page.get_by_role("group", name="Stations").get_by_role("textbox", name="Name 5")).to_be_focused()
    drops.nth(4).press("Enter")
    expect(drops).to_have_count(4)
    expect(drops.nth(3)).to_be_focused()
    page.locator('[data-add="/stations"]').press("Enter")
    expect(drops).to_have_count(5)
    page.get_by_role("button", name="reset: Stations").press("Enter")
    expect(drops).to_have_count(4)
    expect(page.locator('[data-add="/stations"]')).to_be_focused()
    page.locator('[data-add="/targets/0/segments"]').press("Enter")
    expect(page.get_by_role("textbox", name=re.compile("^Duration 10"))).to_be_focused()
    page.locator("section[data-pointer='/targets/0'] select").select_option("points")
    expect(page.locator("section[data-pointer='/targets/0'] .card-head select")).to_be_focused()
    store = page.get_by_role("button", name="Store as recording")
    store.press("Enter")
    expect(page.get_by_role("status").get_by_role("link", name="data.csv")).to_be_visible()
    expect(store).to_be_focused()
    visited.assert_clean()
