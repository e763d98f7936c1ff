"""Marks as a person sees them: altitudes that stand in, emitters told apart, receivers; Russian on a telephone."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.browser.charts import drawn
from tests.browser.conftest import Server, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def run(server: Server) -> str:
    recording = server.ask("scenarios/recording", {"preset": "four_station_incomplete", "parameters": {}, "seed": 3})
    algorithms = [
        {"name": "mlat_imm", "parameters": {"missing_altitude": "held"}},
        {"name": "rdfv", "parameters": {"emitters": "separate"}},
    ]
    return str(server.ask("runs", {"algorithms": algorithms, "recording_id": recording["id"]})["id"])


def test_what_stands_in_the_bias_and_the_receivers_are_drawn(
    visit: Callable[..., Visit], server: Server, run: str
) -> None:
    visited = visit()
    page = visited.open(f"#/runs/{run}")
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded"), timeout=180_000)
    plan = drawn(page, "Plan")
    lines, words = plan.traces(role="bound")
    assert (lines["name"], words["name"]) == ("GDOP", "GDOP")
    altitude = drawn(page, "Altitude")
    assert "mlat_imm, altitude held" in {t["name"] for t in altitude.traces(role="measurement")}
    bias = drawn(page, "Altimeter bias")
    assert [t["name"] for t in bias.traces(role="series")] == ["mlat_imm"]
    delays = drawn(page, "Delay of each receiver")
    assert {t["name"] for t in delays.traces(role="series")} == {f"station {i}" for i in (1, 2, 3, 4)}
    page.get_by_role("tab", name=re.compile("Tracks")).click()
    expect(page.get_by_role("tabpanel")).to_contain_text("emitter 1")
    visited.assert_clean()


def test_a_table_of_emitter_types_is_typed_in_the_form(visit: Callable[..., Visit], server: Server) -> None:
    visited = visit()
    page = visited.open("#/new")
    page.get_by_role("button", name="Scenario").click()
    # Of the family one is marked as the one to begin with.
    starred = page.locator(".adder button[title^='Recommended. ']")
    expect(starred.and_(page.locator("[data-add=mlat_imm]"))).to_be_visible()
    expect(page.locator(".adder")).to_contain_text("What we would begin with")
    starred.and_(page.locator("[data-add=mlat_imm]")).click()
    form = page.locator("[data-algorithm=mlat_imm]")
    form.locator("[data-name=missing_altitude] select").select_option("type")
    form.locator("summary", has_text="More").first.click()
    table = form.locator("[data-name=emitter_altitudes]")
    table.get_by_role("button", name="Add").click()
    for column, value in enumerate(("ship", "20", "15")):
        table.locator("tbody input").nth(column).fill(value)
    form.locator("summary", has_text="as JSON").click()
    expect(form.locator("textarea").last).to_have_value(
        re.compile(r'"emitter_altitudes".*"emitter_type":\s*"ship".*"altitude_m":\s*20.*"sigma_m":\s*15', re.DOTALL)
    )
    visited.assert_clean()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_speaks_russian_and_fits_a_telephone(
    visit: Callable[..., Visit], server: Server, run: str, scheme: str
) -> None:
    visited = visit(locale="ru-RU", color_scheme=scheme, viewport={"width": 360, "height": 740})
    page = visited.open(f"#/runs/{run}")
    drawn(page, "Смещение высотомера")
    drawn(page, "Запаздывание пунктов приёма")
    names = ("mlat_imm", "rdfv", "four_station_incomplete, seed 3", "four_station_incomplete")
    assert english_left(page, names) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    visited.assert_clean()
