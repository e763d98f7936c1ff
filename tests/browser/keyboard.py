"""A page worked by keyboard alone: reach something by Tab, choose in a list, answer a dialog."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page

MOST_STOPS = 160
# Where `g` and a letter lead.
PLACES = {
    "r": "runs-page",
    "d": "recordings-page",
    "a": "algorithms-page",
    "s": "scenarios-page",
    "m": "map-page",
    "t": "studies-page",
}


def tab_to(page: Page, selector: str, *, key: str = "Tab") -> None:
    """Press Tab until the focus is on what is wanted; every stop on the way must show its focus."""
    page.locator(selector).first.wait_for(state="attached")
    for _ in range(MOST_STOPS):
        if page.evaluate("(wanted) => document.activeElement.matches(wanted)", selector):
            return
        page.keyboard.press(key)
        # Between the last stop and the first one some browsers leave the focus on the body, which is no stop.
        ring = page.evaluate(
            "document.activeElement === document.body ? '' : getComputedStyle(document.activeElement).outlineStyle"
        )
        assert ring != "none", page.evaluate("document.activeElement.outerHTML.slice(0, 200)")
    pytest.fail(f"{key} never reached {selector}")


def press(page: Page, selector: str) -> None:
    """Reach a button or a link and press it."""
    tab_to(page, selector)
    page.keyboard.press("Enter")


def choose(page: Page, selector: str, text: str) -> None:
    """Reach a list and choose in it by typing the beginning of the words."""
    tab_to(page, selector)
    page.keyboard.type(text)
    chosen = page.evaluate("document.activeElement.selectedOptions[0].text")
    assert chosen.startswith(text), f"{selector}: {chosen}"


def give_file(page: Page, selector: str, *paths: Path) -> None:
    """Reach a field for files and open the system's dialog from it."""
    tab_to(page, selector)
    with page.expect_file_chooser() as chooser:
        page.keyboard.press("Enter")
    chooser.value.set_files(paths)


def go_to(page: Page, second: str) -> None:
    """Leave a field and press `g` and a letter; what is pressed next is meant for the page that comes."""
    page.keyboard.press("Escape")
    page.keyboard.press("g")
    page.keyboard.press(second)
    page.locator(f"main > {PLACES[second]}").wait_for()
