"""Before a start the page says what the run would take."""

from __future__ import annotations

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
