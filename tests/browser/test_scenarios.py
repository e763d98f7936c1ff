"""The page of scenarios as a person uses it: choose, type, see, mend, share, keep; by keyboard; in Russian at night."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from urllib.parse import parse_qs, urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn
from tests.browser.conftest import Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]


def fresh(page: Page, state: str = "yes") -> None:
    page.locator(f"scenario-preview[data-fresh={state}]").wait_for()


def parameters(page: Page) -> dict[str, object]:
    query = parse_qs(urlsplit(page.url).fragment.partition("?")[2])
    return json.loads(query.get("parameters", ["{}"])[0])


def test_from_a_preset_to_a_recording(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    page.get_by_role("link", name="Scenarios").click()
    fresh(page)
    expect(page.get_by_role("status").filter(has_text="1900 marks")).to_be_visible()
    assert any(trace["points"] for trace in drawn(page, "Plan")["traces"])

    page.get_by_role("radio", name=re.compile("Two aircraft cross")).check()
    expect(page.get_by_text("1044 marks")).to_be_visible()
    page.get_by_label("Marks come", exact=True).select_option("regular")
    expect(page.get_by_text("1122 marks")).to_be_visible()
    page.get_by_label("Period, s", exact=True).fill("2")
    expect(page.get_by_text("562 marks")).to_be_visible()
    assert parameters(page) == {"timing": "regular", "period_s": 2}

    # What cannot be is said at its place; the charts wait. What cannot be read is not asked for.
    page.get_by_label("Climb rate 2").fill("-160")
    fresh(page, "failed")
    expect(page.get_by_label("Climb rate 2")).to_have_attribute("aria-invalid", "true")
    expect(page.get_by_text("Segment 2 ends at an altitude of -1200 m, below the ground.")).to_be_visible()
    page.get_by_label("Climb rate 2").fill("-6")
    fresh(page)
    expect(page.get_by_label("Climb rate 2")).not_to_have_attribute("aria-invalid", "true")
    page.get_by_label("Duration, s", exact=True).fill("long")
    expect(page.get_by_text("Not a number.")).to_be_visible()
    expect(page.get_by_role("button", name="Store as recording")).to_be_disabled()
    page.get_by_label("Duration, s", exact=True).fill("")
    fresh(page)

    # A station more, and the lists that follow it; a target less.
    page.get_by_role("button", name="Add: Stations").click()
    fresh(page)
    expect(page.get_by_label("Probabilities 1")).to_have_value(re.compile(r"^1\s+0\.2\s+1\s+1\s+1$"))
    page.get_by_label("Name 5").fill("far")
    page.get_by_role("button", name="Remove: Targets 2").click()
    expect(page.get_by_text("281 marks")).to_be_visible()
    assert [s["name"] for s in parameters(page)["stations"]] == ["1", "2", "3", "4", "far"]

    # The address holds it all.
    page.reload()
    expect(page.get_by_text("281 marks")).to_be_visible()
    expect(page.get_by_label("Name 5")).to_have_value("far")
    # So does the link to a new run.
    link = page.get_by_role("link", name="Use in a new run").get_attribute("href")
    assert link is not None
    scenario = json.loads(parse_qs(link.partition("?")[2])["scenario"][0])
    assert scenario == {"preset": "two_aircraft_crossing", "parameters": parameters(page)}

    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename.endswith(".csv")
    page.get_by_role("button", name="Store as recording").click()
    page.get_by_role("link", name="two_aircraft_crossing, seed 0").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("two_aircraft_crossing, seed 0")
    expect(page.get_by_text("ready", exact=True)).to_be_visible()
    # 422 of the impossible climb is in the console of every browser.
    assert all("422" in text for text in visited.complaints), visited.complaints


def test_a_probability_is_taken_to_its_last_digit(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/scenarios?preset=wide_turn")
    # What the address names is in sight in the long list of presets.
    expect(page.locator(".picker label:has(:checked)")).to_be_in_viewport(ratio=0.9)
    field = page.get_by_label("Detection probability", exact=True)
    field.fill("0.91")
    page.wait_for_function("() => decodeURIComponent(location.hash).includes('\"detection_probability\":0.91')")
    field.fill("0.71")
    page.wait_for_function("() => decodeURIComponent(location.hash).includes('\"detection_probability\":0.71')")
    field.fill("1")
    expect(field).not_to_have_attribute("aria-invalid", "true")
    visited.assert_clean()


def test_json_is_pasted_and_a_field_goes_back_by_keyboard(visit: Callable[..., Visit]) -> None:
    page = visit().open("#/scenarios?preset=four_station_incomplete&seed=5")
    fresh(page)
    expect(page.get_by_label("Seed of the noise")).to_have_value("5")
    page.get_by_text("as JSON").click()
    area = page.get_by_role("textbox", name="as JSON")
    area.fill('{"sigma_toa_ns": 77, "targets": [{"points": [{"time_s": 0, "east_m": 9e3, "north_m": 0, "up_m": 900},'
              '{"time_s": 60, "east_m": 0, "north_m": 9e3, "up_m": 900}]}]}')  # fmt: skip
    area.press("Tab")
    fresh(page)
    expect(page.get_by_label("What the target follows")).to_have_value("points")
    field = page.get_by_label("Time-of-arrival error, ns", exact=True)
    expect(field).to_have_value("77")
    page.get_by_role("button", name="reset: Time-of-arrival error").focus()
    page.keyboard.press("Enter")
    expect(field).to_have_value("10")
    assert list(parameters(page)) == ["targets"]
    page.get_by_label("What the target follows").select_option("segments")
    fresh(page)
    expect(page.get_by_label("Duration 1")).to_have_value("60")


def test_it_stands_in_russian_at_night_and_on_a_phone(visit: Callable[..., Visit]) -> None:
    visited = visit(locale="ru-RU", color_scheme="dark")
    page = visited.open("#/scenarios?preset=nowhere&parameters={")
    expect(page.get_by_text("Сценария nowhere нет; показан первый.")).to_be_visible()
    fresh(page)
    page.get_by_label("Скороподъёмность 1", exact=True).fill("-100")
    expect(page.get_by_text("Участок 1 кончается на высоте -30000 м, под землёй.")).to_be_visible()
    results = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa"]})
    assert not results.response["violations"], results.generate_report()
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_function("() => document.documentElement.scrollWidth <= 390")
