"""Regions of the multiple-model filter in the form: corners typed and drawn, a matrix each, faults by their place."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import Server, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

NAMES = ("multiple_model", "ekf", "rate", "imm", "moment", "listed", "auto", "straight_flight", "scenario")
CALM = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
SCENARIO = json.dumps({"preset": "straight_flight", "parameters": {"rate_hz": 1}})


def opened(visited: Visit, *regions: object) -> Page:
    entry = {"name": "multiple_model", "parameters": {"regions": regions}} if regions else {"name": "multiple_model"}
    page = visited.open(f"#/new?scenario={SCENARIO}&trials=2&a={json.dumps(entry)}")
    details = page.locator("parameter-form details").first
    expect(details).to_be_attached()
    if details.get_attribute("open") is None:
        details.locator("summary").click()
    return page


def held(page: Page) -> list[dict[str, Any]]:
    """The regions of the form, as they would be sent."""
    return list(json.loads(page.locator("regions-editor").evaluate("(editor) => editor.value || '[]'")))


def test_a_region_by_keyboard_and_its_faults(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = opened(visited)
    page.get_by_role("button", name="Add: Regions").press("Enter")
    editor = page.locator("regions-editor")
    # The path of the scenario lies behind, and the matrix is the one that holds elsewhere.
    expect(editor.locator("polyline.true-path")).to_have_count(1)
    region = editor.get_by_role("group", name="Region 1", exact=True)
    expect(region.get_by_label("Region 1: Transition probabilities: cv 0.5 → cv 0.5")).to_have_value("0.999")
    page.keyboard.type("valley")
    for corner, (east, north) in enumerate((("-20000", "0"), ("10000", "0"), ("0", "x")), 1):
        region.get_by_role("button", name="Add a corner: Region 1").press("Enter")
        page.keyboard.type(east)
        page.keyboard.press("Tab")
        page.keyboard.type(north)
        if corner < 3:
            expect(editor).to_contain_text("Region 1: a polygon needs three distinct corners")
    expect(editor).to_contain_text("Region 1, corner 3: Not a number")
    wrong = region.get_by_label("Region 1, corner 3: North, m")
    expect(wrong).to_have_attribute("aria-invalid", "true")
    start = page.get_by_role("button", name="Start")
    expect(start).to_be_disabled()
    wrong.fill("90000")
    expect(start).to_be_enabled()
    expect(region.locator("polygon.own")).to_have_count(1)
    region.get_by_label("Region 1: To height, m").fill("-2e6")
    expect(editor).to_contain_text("Region 1: To height, m")
    region.get_by_label("Region 1: To height, m").fill("12000")
    (one,) = held(page)
    assert (one["name"], one["corners"], one["highest_up_m"]) == (
        "valley",
        [[-20000, 0], [10000, 0], [0, 90000]],
        12000,
    )
    start.click()
    expect(page.locator(".run-head .state")).to_contain_text("succeeded")
    visited.assert_clean()


def test_edges_that_cross_are_named_while_the_polygon_is_typed(visit: Callable[..., Visit]) -> None:
    visited = visit()
    bow = {"corners": [[-20000, 0], [10000, 90000], [10000, 0], [-20000, 90000]], "transition": CALM}
    page = opened(visited, {"transition": CALM}, bow)
    editor = page.locator("regions-editor")
    expect(editor).to_contain_text("Region 2: the edges 1–2 and 3–4 cross or touch")
    expect(editor.locator("[aria-invalid=true]")).to_have_count(8)
    start = page.get_by_role("button", name="Start")
    expect(start).to_be_disabled()
    editor.get_by_label("Region 2, corner 2: North, m").fill("0")
    expect(editor.locator("[aria-invalid=true]")).to_have_count(0)
    editor.get_by_label("Region 2, corner 3: North, m").fill("90000")
    expect(start).to_be_enabled()
    editor.get_by_label("Region 2, corner 4: North, m").fill("-90000")
    expect(editor).to_contain_text("Region 2: the edges 1–2 and 3–4 cross or touch")
    expect(start).to_be_disabled()
    visited.assert_clean()


def test_a_polygon_is_drawn_and_moved_by_the_pointer(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = opened(visited, {"transition": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})
    plan = page.locator("region-plan svg")
    expect(plan.locator("polyline.true-path")).to_have_count(1)
    plan.scroll_into_view_if_needed()
    box = plan.bounding_box()
    assert box is not None
    for x, y in ((0.2, 0.2), (0.8, 0.2), (0.8, 0.8)):
        box = plan.bounding_box()
        assert box is not None
        page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
    expect(page.locator("region-plan polygon.own")).to_have_count(1)
    before = held(page)[0]["corners"]
    assert len(before) == 3
    grip = page.locator("region-plan [data-corner='0'] .grip").bounding_box()
    assert grip is not None
    x, y = grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y + 30, steps=3)
    page.mouse.up()
    after = held(page)[0]["corners"]
    assert after[1:] == before[1:]
    assert after[0][0] > before[0][0]
    assert after[0][1] < before[0][1]
    expect(page.get_by_label("Region 1, corner 1: East, m")).to_have_value(str(after[0][0]))
    page.get_by_role("button", name="Remove: Region 1, corner 2").click()
    expect(page.locator("regions-editor")).to_contain_text("a polygon needs three distinct corners")
    page.get_by_role("button", name="Remove: Region 1", exact=True).click()
    assert held(page) == []
    visited.assert_clean()


def test_a_recording_s_path_lies_behind_and_the_server_s_words_stand_at_the_corner(
    visit: Callable[..., Visit], server: Server
) -> None:
    run = server.sample_run("before an antenna")
    far = {"corners": [[0, 0], [50000, 0], [2e7, 3e5]], "transition": CALM}
    entry = {"name": "multiple_model", "parameters": {"regions": [{"transition": CALM}, far]}}
    page = visit().open(f"#/new?recording={run['source']['recording_id']}&a={json.dumps(entry)}")
    expect(page.locator("region-plan polyline.true-path")).to_have_count(2)
    page.get_by_role("button", name="Start").click()
    editor = page.locator("regions-editor")
    expect(editor).to_contain_text("Region 2, corner 3: Input should be less than or equal to 10000000")
    wrong = editor.locator("[aria-invalid=true]")
    expect(wrong).to_have_count(1)
    expect(wrong).to_have_attribute("aria-label", "Region 2, corner 3: East, m")
    expect(wrong).to_be_focused()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_regions_speak_russian_and_fit_a_telephone(visit: Callable[..., Visit], scheme: str) -> None:
    visited = visit(locale="ru-RU", color_scheme=scheme, viewport={"width": 360, "height": 740})
    calm = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    page = opened(
        visited, {"corners": [[-9000, 60000], [4000, 60000], [1000, 75000]], "transition": calm}, {"transition": calm}
    )
    expect(page.locator("region-plan polygon.own")).to_have_count(1)
    expect(page.locator("region-plan polyline.true-path")).to_have_count(2)
    assert english_left(page, NAMES) == []
    overflow = page.evaluate("() => document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert overflow <= 0
    visited.assert_clean()
