"""One target alone on the whole page: chosen by a click, by keyboard, by the address; and the ways back."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import Server, Visit
from tests.browser.test_compare import finished_run
from tests.browser.test_run_page import open_run

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not

# Where the second target is seen: a point of the plan near its middle.
FIND_POINT = """(panel) => {
  const gd = panel.querySelector('.plot');
  const {xaxis: x, yaxis: y} = gd._fullLayout;
  const trace = gd._fullData.find((t) => t.meta.role === 'truth');
  const names = trace.hovertext;
  const mine = [...names.keys()].filter((i) => names[i] === 'target OVR202');
  const i = mine[Math.floor(mine.length / 2)];
  const box = gd.getBoundingClientRect();
  return [box.left + x._offset + x.d2p(trace.x[i]), box.top + y._offset + y.d2p(trace.y[i])];
}"""


def rows_drawn(page: Page, heading: str) -> int:
    return len({row for t in drawn(page, heading)["traces"] for row in t["rows"] if row > 0})


def click_second_target(page: Page) -> None:
    page.evaluate("window.scrollTo(0, 0)")
    x, y = panel_of(page, "Plan").evaluate(FIND_POINT)
    page.mouse.move(x - 1, y)
    page.mouse.move(x, y)
    expect(panel_of(page, "Plan").locator(".strip b").first).to_contain_text(" s")
    page.mouse.down()
    page.mouse.up()
    page.wait_for_url(re.compile("target=OVR202"))


def test_a_click_in_the_plan_leaves_one_target_everywhere(visit: Callable[..., Visit]) -> None:
    visited = visit(viewport={"width": 1366, "height": 1600})
    page = open_run(visited)
    headings = ("Plan", "Horizontal error", "NIS", "Altitude")
    before = {heading: rows_drawn(page, heading) for heading in headings}
    whole = page.locator(".verdict").inner_text()
    click_second_target(page)
    for heading in headings:
        expect(panel_of(page, heading).locator(".body")).not_to_have_attribute("aria-busy", "true")
        assert 0 < rows_drawn(page, heading) < before[heading], heading
    expect(page.locator(".verdict")).to_contain_text("Target OVR202 alone.")
    assert page.locator(".verdict").inner_text() != whole
    page.get_by_role("tab", name="Tracks").click()
    expect(page.locator("[data-table=tracks] tbody")).to_contain_text("OVR202")
    expect(page.locator("[data-table=tracks] tbody")).not_to_contain_text("ARR101")
    page.get_by_role("tab", name="Export").click()
    expect(page.get_by_role("link", name="CSV", exact=True).first).to_have_attribute(
        "href", re.compile("target=OVR202")
    )
    result = Axe().run(page)
    assert result.violations_count == 0, result.generate_report()

    # The address carries it; the first Escape frees the cursor, the second shows all; the browser's way back works.
    page.reload()
    expect(page.get_by_label("Target", exact=True).get_by_role("combobox")).to_have_value("OVR202")
    assert rows_drawn(page, "NIS") < before["NIS"]
    page.keyboard.press("Escape")
    page.wait_for_url(re.compile(r"runs/\w+(\?tab=export)?$"))
    page.go_back()
    page.wait_for_url(re.compile("target=OVR202"))
    page.get_by_role("button", name="Show all").click()
    expect(page.locator(".verdict")).to_have_text(whole)
    visited.assert_clean()


def test_the_keyboard_chooses_a_target(visit: Callable[..., Visit]) -> None:
    page = open_run(visit())
    picker = page.get_by_label("Target", exact=True).get_by_role("combobox")
    picker.focus()
    page.keyboard.press("ArrowDown")
    page.wait_for_url(re.compile("target=ARR101"))
    expect(page.locator("target-picker [role=status]")).to_have_text("Everything below is about target ARR101 alone.")
    expect(picker).to_be_focused()
    page.keyboard.press("Escape")
    expect(picker).to_have_value("")
    # In a chart: step to a mark, then Enter; in the table of tracks a row.
    panel_of(page, "NIS").locator(".plot").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    page.wait_for_url(re.compile("target="))
    # However soon after: the first Escape frees the cursor, the second shows all.
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    expect(picker).to_have_value("")
    page.get_by_role("tab", name="Tracks").click()
    page.locator("[data-table=tracks] tbody tr").nth(1).press("Enter")
    page.wait_for_url(re.compile("target=OVR202"))
    expect(page.get_by_role("tab", name="Tracks")).to_be_focused()


def test_the_page_is_never_about_something_else_than_its_address(visit: Callable[..., Visit]) -> None:
    page = open_run(visit())
    picker = page.get_by_label("Target", exact=True).get_by_role("combobox")
    # Both are read before the browser has had time to tell of anything.
    address, chosen = picker.evaluate(
        """(select) => {
          select.value = "ARR101";
          select.dispatchEvent(new Event("change"));
          return [location.hash, document.querySelector("target-picker").hasAttribute("data-chosen")];
        }"""
    )
    assert "target=ARR101" in address
    assert chosen
    page.go_back()
    expect(picker).to_have_value("")


def test_an_address_with_an_unknown_target_shows_all_and_says_so(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = open_run(visited, "?target=nobody")
    expect(page.get_by_role("alert")).to_contain_text("no target “nobody”")
    assert rows_drawn(page, "NIS") > 600
    visited.assert_clean()


def test_a_comparison_and_a_recording_follow_a_target_too(server: Server, visit: Callable[..., Visit]) -> None:
    runs = [finished_run(server, label=label, algorithms=[{"name": "rdf"}]) for label in ("left", "right")]
    visited = visit()
    page = visited.open("#/compare?" + "&".join(f"run={run['id']}" for run in runs))
    before = rows_drawn(page, "NIS")
    click_second_target(page)
    expect(panel_of(page, "NIS").locator(".body")).not_to_have_attribute("aria-busy", "true")
    assert 0 < rows_drawn(page, "NIS") < before
    expect(page.locator(".verdict")).to_contain_text("Target OVR202 alone.")

    page = visited.open(f"#/recordings/{runs[0]['source']['recording_id']}?target=ARR101")
    expect(page.get_by_label("Target", exact=True).get_by_role("combobox")).to_have_value("ARR101")
    alone = rows_drawn(page, "Measurements")
    page.get_by_role("button", name="Show all").click()
    expect(panel_of(page, "Measurements").locator(".body")).not_to_have_attribute("aria-busy", "true")
    page.wait_for_timeout(300)
    assert rows_drawn(page, "Measurements") > alone
    visited.assert_clean()
