"""Before a start the page says what the run would take."""

from __future__ import annotations

import json
import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not


def test_the_estimate_stands_beside_the_start(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    expect(
        page.get_by_role("row", name=re.compile("succeeded|Sample")).filter(has_text="succeeded").first
    ).to_be_visible()
    visited.open("#/new")
    page.get_by_role("radio").first.check()
    told = page.locator(".startbar [role=status]")
    expect(told).to_be_empty()
    page.locator("[data-add=rdf]").click()
    expect(told).to_contain_text(re.compile(r"about .*s · .*in memory"))
    visited.assert_clean()


def test_what_would_be_refused_is_said_at_its_field(visit: Callable[..., Visit]) -> None:
    """An answer, no failure: the console of the browser stays clean, and who types keeps the focus."""
    visited = visit()
    entry = {"name": "multiple_model", "parameters": {"structure": "gpb1", "merging": "modified"}}
    scenario = {"preset": "straight_flight", "parameters": {"rate_hz": 1}}
    page = visited.open(f"#/new?scenario={json.dumps(scenario)}&trials=2&a={json.dumps(entry)}")
    field = page.locator("parameter-form [data-name=merging]")
    told = page.locator(".startbar [role=status]")
    expect(field).to_contain_text("needs a main hypothesis")
    expect(told).to_have_text("The marked fields need a correction.")
    field.locator("select").focus()
    field.locator("select").select_option("moment")
    expect(told).to_contain_text("in memory")
    expect(field).not_to_contain_text("needs a main hypothesis")
    expect(field.locator("select")).to_be_focused()
    visited.assert_clean()
