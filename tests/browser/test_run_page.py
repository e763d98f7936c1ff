"""The run page as a tool: one instant in all charts."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import Visit
from tests.browser.test_page import sample_run

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not
OVER_TIME = ("Horizontal error", "NIS", "Altitude", "Receptions")


def open_run(visited: Visit, query: str = "") -> Page:
    """The run that a new server comes with, its first charts drawn."""
    page = visited.open("#/runs")
    visited.open(sample_run(page) + query)
    for heading in ("Plan", "Horizontal error", "NIS"):
        drawn(page, heading)
    return page


def hover(page: Page, heading: str, across: float) -> None:
    """Put the mouse into a chart, at a share of its width."""
    page.evaluate("window.scrollTo(0, 0)")
    box = panel_of(page, heading).locator(".plot .nsewdrag").first.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + across * box["width"], box["y"] + box["height"] / 2)


def test_one_instant_in_all_charts(visit: Callable[..., Visit]) -> None:
    visited = visit(viewport={"width": 1366, "height": 1600})
    page = open_run(visited)
    for heading in OVER_TIME:
        drawn(page, heading)
    hover(page, "Horizontal error", 0.5)
    for heading in OVER_TIME:
        expect(panel_of(page, heading).locator(".overlay line")).to_have_count(1)
    expect(panel_of(page, "Plan").locator(".overlay circle").first).to_be_attached()
    strip = panel_of(page, "Horizontal error").locator(".strip")
    expect(strip).to_contain_text(re.compile(r"Time [\d.]+ s"))
    expect(strip).to_contain_text(re.compile(r"rdfv, actual [\d.]+ m"))
    times = [panel_of(page, h).locator(".strip b").first.inner_text() for h in ("Plan", *OVER_TIME)]
    assert len(set(times)) == 1, times

    # A click locks it, the mouse no longer moves it; arrow keys step one mark and say so; Escape frees it.
    page.mouse.down()
    page.mouse.up()
    hover(page, "NIS", 0.8)
    assert strip.locator("b").first.inner_text() == times[0]
    page.keyboard.press("ArrowRight")
    expect(strip.locator("b").first).not_to_have_text(times[0])
    stepped = strip.locator("b").first.inner_text()
    assert float(stepped.split()[0]) > float(times[0].split()[0])
    expect(panel_of(page, "Horizontal error").locator("[aria-live]")).to_contain_text(stepped)
    page.keyboard.press("ArrowLeft")
    expect(strip.locator("b").first).to_have_text(times[0])
    page.keyboard.press("Escape")
    expect(page.locator("chart-panel .overlay line")).to_have_count(0)
    visited.assert_clean()


# The first dot of a crowd that lies well inside a chart, as Plotly places it, and how much paint there is around it.
_DOT = """(panel) => {
  const plot = panel.querySelector('.plot'), canvas = panel.querySelector('canvas.dots');
  const {xaxis, yaxis} = plot._fullLayout;
  const trace = plot._fullData.find((one) => one.meta?.dot && one.mode === 'none');
  const i = trace.x.findIndex((x, k) => {
    const [px, py] = [xaxis.d2p(x), yaxis.d2p(trace.y[k])];
    return px > 40 && px < xaxis._length - 40 && py > 20 && py < yaxis._length - 20;
  });
  const [left, top] = [xaxis._offset + xaxis.d2p(trace.x[i]), yaxis._offset + yaxis.d2p(trace.y[i])];
  const around = canvas.getContext('2d').getImageData(Math.round(left) - 1, Math.round(top) - 1, 3, 3).data;
  const corner = canvas.getContext('2d').getImageData(0, 0, xaxis._offset - 5, 20).data;
  const paint = around.filter((_, k) => k % 4 === 3).reduce((a, b) => a + b);
  return {paint, outside: Math.max(...corner), count: trace.x.length};
}"""


def test_the_chosen_tab_is_in_sight_on_a_phone(visit: Callable[..., Visit]) -> None:
    visited = visit(viewport={"width": 360, "height": 800})
    page = visited.open("#/runs")
    visited.open(sample_run(page) + "?tab=export")
    inside = """(tab) => {
        const [own, box] = [tab.getBoundingClientRect(), tab.parentElement.getBoundingClientRect()];
        return own.left >= box.left && own.right <= box.right + 1;
    }"""
    export = page.get_by_role("tab", name="Export")
    expect(export).to_have_attribute("aria-selected", "true")
    assert export.evaluate(inside)
    export.press("Home")
    metrics = page.get_by_role("tab", name="Metrics")
    expect(metrics).to_be_focused()
    assert metrics.evaluate(inside)
    assert not export.evaluate(inside)


def test_a_crowd_of_marks_is_painted_and_no_burden(visit: Callable[..., Visit]) -> None:
    visited = visit(viewport={"width": 1366, "height": 1600})
    page = open_run(visited)
    errors = panel_of(page, "Horizontal error")
    found = errors.evaluate(_DOT)
    assert found["count"] > 250
    assert found["paint"] > 0
    assert found["outside"] == 0
    drawings = "(all) => Math.max(...all.map((one) => one.querySelectorAll('path.point').length))"
    assert errors.locator(".plot .scatterlayer .trace").evaluate_all(drawings) <= 250
    # Zoomed into, the dots stand where the points are now.
    box = errors.locator(".plot .nsewdrag").first.bounding_box()
    assert box is not None
    before = drawn(page, "Horizontal error")["x_range"]
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 5)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + box["height"] - 5, steps=4)
    page.mouse.up()
    page.wait_for_function(
        "([panel, from]) => panel.querySelector('.plot')._fullLayout.xaxis.range[0] > from",
        arg=[errors.element_handle(), before[0]],
    )
    assert errors.evaluate(_DOT)["paint"] > 0
    # An image holds them too.
    errors.get_by_role("button", name="More about this chart").click()
    with page.expect_download() as download:
        errors.get_by_role("button", name="SVG", exact=True).click()
    assert download.value.path().read_text().count("<path") > 250
    visited.assert_clean()


def test_time_is_stepped_slid_and_replayed(visit: Callable[..., Visit]) -> None:
    page = open_run(visit())
    player = page.get_by_role("group", name="Replay")
    expect(player.get_by_role("button", name="Play")).to_have_count(0)  # reduced motion: nothing moves by itself
    shown = player.get_by_role("status")
    player.get_by_role("button", name="One mark on").click()
    first = shown.inner_text()
    player.get_by_role("button", name="One mark on").click()
    expect(shown).not_to_have_text(first)
    player.get_by_role("slider").fill("300")
    expect(shown).to_have_text("300.00 s")
    expect(panel_of(page, "NIS").locator(".strip b").first).to_have_text("300.00 s")
    expect(panel_of(page, "Plan").locator(".overlay .mark")).not_to_have_count(0)
    expect(panel_of(page, "Plan").locator(".overlay .trail")).not_to_have_count(0)
    page.keyboard.press("Escape")
    expect(panel_of(page, "Plan").locator(".overlay .trail")).to_have_count(0)

    page = open_run(visit(reduced_motion="no-preference"))
    player = page.get_by_role("group", name="Replay")
    shown = player.get_by_role("status")
    player.get_by_label("Speed").select_option("100")
    player.get_by_role("button", name="Play").click()
    page.wait_for_function("() => parseFloat(document.querySelector('time-player output').innerText) > 30")
    player.get_by_role("button", name="Pause").click()
    paused = shown.inner_text()
    page.wait_for_timeout(200)
    assert shown.inner_text() == paused
    # A click in a chart takes over from a running replay.
    player.get_by_role("button", name="Play").click()
    hover(page, "NIS", 0.9)
    page.mouse.down()
    page.mouse.up()
    expect(player.get_by_role("button", name="Play")).to_be_visible()


def test_places_rings_and_distances_in_the_plan(visit: Callable[..., Visit]) -> None:
    page = open_run(visit())
    plan = panel_of(page, "Plan")
    scales = drawn(page, "Plan").scales
    hover(page, "Plan", 0.3)
    expect(plan.locator("span.readout")).to_contain_text(re.compile(r"E .*km.*° from the origin"))
    plan.get_by_role("button", name="Range rings").click()
    expect(plan.locator("circle.ring").first).to_be_attached()
    ring = plan.locator("circle.ring").first
    words = plan.locator("text.ring").first.text_content()
    assert words is not None
    assert float(ring.get_attribute("r") or 0) == pytest.approx(float(words.split()[0]) * scales[0], rel=1e-3)

    plan.get_by_role("button", name="Distance").click()
    box = plan.locator(".plot .nsewdrag").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 100, box["y"] + 300)
    page.mouse.click(box["x"] + 200, box["y"] + 200)
    said = plan.locator(".readout[role=status]")
    expect(said).to_contain_text(re.compile(r"km, azimuth 45\.\d°"))
    assert float(said.inner_text().split()[0]) == pytest.approx(100 * 2**0.5 / scales[0], rel=1e-2)
    expect(plan.locator("line.distance")).to_have_count(1)
    page.keyboard.press("Escape")
    expect(plan.locator("line.distance")).to_have_count(0)
    expect(plan.get_by_role("button", name="Distance")).to_have_attribute("aria-pressed", "false")


def test_a_chart_is_taken_along_and_fills_the_screen(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = open_run(visited)
    plan = panel_of(page, "Plan")
    starts = {"PNG": b"\x89PNG", "SVG": b"<svg", "CSV": b"label,trace", "JSON": b'{"data"', "HTML": b"<!doctype html>"}
    for kind, start in starts.items():
        plan.get_by_role("button", name="More about this chart: Plan").click()
        with page.expect_download() as download:
            plan.locator(".menu").get_by_text(kind, exact=True).click()
        path = download.value.path()
        assert path.read_bytes()[:100].lower().startswith(start.lower()), kind
        assert download.value.suggested_filename.endswith(f".{kind.lower()}"), download.value.suggested_filename

    before = drawn(page, "Plan")["x_length"]
    plan.get_by_role("button", name="Full screen: Plan").click()
    page.wait_for_function("() => document.fullscreenElement?.localName === 'chart-panel'")
    page.wait_for_function(
        "(before) => document.fullscreenElement.querySelector('.plot')._fullLayout.xaxis._length > before * 1.3",
        arg=before,
    )
    plan.get_by_role("button", name="Full screen: Plan").click()
    page.wait_for_function("() => document.fullscreenElement === null")
    visited.assert_clean()
