"""Where a method comes from stands on its page in full."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from algorithms.references import REFERENCES
from algorithms.registry import algorithms_by_name
from tests.browser.conftest import Visit

pytestmark = pytest.mark.browser


def test_an_algorithm_cites_its_papers_in_full(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/algorithms/rdfv")
    cited = algorithms_by_name()["rdfv"].references
    assert len(cited) >= 2
    for reference in cited:
        line = page.locator("main li", has_text=REFERENCES[reference.key])
        expect(line).to_have_count(1)
        expect(line).to_contain_text(reference.place)
    visited.assert_clean()
