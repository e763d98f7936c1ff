"""Identification as a person sees it: the sample's pairs, a study beside the printed table, Russian, a telephone."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.browser.charts import drawn
from tests.browser.conftest import Server, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LABELS = ("pairwise_test", "assignment", "track_association")


def test_the_sample_shows_pairs_probabilities_and_the_turned_radar(visit: Callable[..., Visit], server: Server) -> None:
    run = server.sample_run("one aircraft")["id"]
    visited = visit()
    page = visited.open(f"#/runs/{run}")
    pairs = drawn(page, "Pairs with the regions of their errors")
    assert {t["label"] for t in pairs.traces(role="series")} == set(LABELS[:2])
    assert {t["name"] for t in pairs.traces(role="measurement")} == {"radar west, plots", "radar east, plots"}
    matrix = drawn(page, "Probabilities of the pairs of one look")
    assert [t["name"] for t in matrix.traces(role="truth")] == ["accepted"]
    assert drawn(page, "Statistic of the pairs").traces(role="bound")
    names = {chart["name"] for chart in server.ask(f"runs/{run}/charts")["items"]}
    assert not {name for name in names if name.startswith("trials_")}, "what trials show has no place on a recording"
    notes = server.ask(f"runs/{run}")["notes"]["assignment"]
    alarms = [note["detail"] for note in notes if note["code"] == "registration_alarm"]
    assert len(alarms) == 1
    assert "east" in alarms[0]
    expect(page.locator("[data-alarms]")).to_contain_text("Radar east is turned by")
    page.get_by_role("tab", name="Agreement of the radars").click()
    first = page.locator("[data-table=registration] tbody tr").first
    expect(first).to_contain_text("turned clockwise")
    expect(first).to_contain_text("east")
    close = drawn(page, "One pair closely: conversions and gate")
    assert {"lin", "paper", "dcm", "ucm", "mucm"} <= {t["name"] for t in close.traces(role="interval")}
    assert [t["name"] for t in close.traces(role="bound")] == ["gate, α = 0.01"]
    page.get_by_role("tab", name=re.compile("Decisions")).click()
    expect(page.get_by_role("tabpanel")).to_contain_text("without a partner")
    visited.assert_clean()


def test_the_paper_s_table_stands_beside_the_printed_one(visit: Callable[..., Visit], server: Server) -> None:
    study = server.ask("runs", {"study": "identification_table_1", "trials": 256})
    visited = visit()
    page = visited.open(f"#/runs/{study['id']}")
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded"), timeout=180_000)
    bars = drawn(page, "Correct, wrong, undecided")
    assert len(bars.traces(role="series")) == 5
    for title in ("Statistic of true and false pairs", "Undecided against wrong", "Reliability of the stated"):
        drawn(page, title)
    page.get_by_role("tab", name=re.compile("Claims")).click()
    panel = page.get_by_role("tabpanel")
    expect(panel).to_contain_text("0.342 / 0.008 / 0.650")
    expect(panel).to_contain_text("is a hypothesis")
    expect(panel.locator("tbody tr")).to_have_count(6)
    # The longest name of a metric is longer than a telephone is wide.
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("tab", name="Metrics", exact=True).click()
    expect(panel.get_by_role("combobox").first).to_be_visible()
    page.wait_for_function("document.documentElement.scrollWidth <= 390")
    visited.assert_clean()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_speaks_russian_and_fits_a_telephone(visit: Callable[..., Visit], server: Server, scheme: str) -> None:
    run = server.sample_run("one aircraft")["id"]
    visited = visit(locale="ru-RU", color_scheme=scheme, viewport={"width": 390, "height": 844})
    page = visited.open(f"#/runs/{run}")
    drawn(page, "Пары с областями их ошибок")
    names = (
        *LABELS,
        "lin",
        "dcm",
        "ucm",
        "mucm",
        "west",
        "east",
        "clutter",
        "AC1",
        "AC2",
        "AC3",
        "AC4",
        "AC5",
        "AC6",
        "sample_plots",
        "Sample: which plots of two radars are one aircraft",
        "sample",
    )
    assert english_left(page, names) == []
    overflow = page.evaluate("() => document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert overflow <= 0
    visited.assert_clean()
