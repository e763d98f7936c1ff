"""Monte Carlo runs as a person makes them: by keyboard, judged, copied, by target, done again."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, Route, expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import WITHOUT_PLOTS, Server, Visit
from tests.browser.keyboard import press, tab_to
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LEGS = [{"name": "first", "start_s": 0, "stop_s": 30}, {"name": "second", "start_s": 30, "stop_s": 60}]
SHORT = {"preset": "four_station_circuit", "parameters": {"duration_s": 59, "legs": LEGS}}
ENTRIES = [{"name": "rdf"}, {"name": "rdfv"}]


def started(server: Server, **changes: Any) -> str:
    body = {"scenario": {"preset": "four_station_circuit"}, "trials": 20, "algorithms": ENTRIES} | changes
    return str(server.ask("runs", {k: v for k, v in body.items() if v is not None})["id"])


def finished(page: Page) -> None:
    # Thousands of trials on a machine that is busy with something else.
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded|выполнен"), timeout=200_000)
    page.locator(".verdict[data-kind]").wait_for()


def test_a_sweep_composed_by_keyboard(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open('#/new?a={"name":"rdf"}&a={"name":"rdfv"}')
    press(page, "[data-mode=scenario]")
    tab_to(page, "scenario-source input[inputmode=numeric]")
    page.keyboard.press("Control+a")
    page.keyboard.type("8")
    page.get_by_role("button", name="Sweep a parameter").focus()
    page.keyboard.press("Enter")
    tab_to(page, "scenario-source select")
    page.locator("scenario-source select").select_option("scenario.sigma_altitude_m")
    page.keyboard.press("Tab")
    page.keyboard.type("10; 3000")
    press(page, ".startbar button.primary")
    finished(page)

    expect(page.locator(".verdict")).to_contain_text("rdfv")
    expect(page.locator(".verdict")).to_contain_text("The error that rdfv claims")
    assert "recording" not in page.locator(".verdict").inner_text()
    for tab, words in (("Comparisons", "rdfv"), ("Honesty", "NEES"), ("Metrics", "rdf")):
        page.get_by_role("tab", name=tab).click()
        expect(page.get_by_role("tabpanel").locator("tbody tr").first).to_contain_text(re.compile("rdf"))
        expect(page.get_by_role("tabpanel")).to_contain_text(words)
    page.get_by_role("tab", name="Export").click()
    expect(page.get_by_role("link", name="report.html")).to_be_visible()

    page.get_by_role("link", name="Run again with changes").click()
    query = parse_qs(urlsplit(page.url).fragment.partition("?")[2])
    assert json.loads(query["sweep"][0]) == {"scenario.sigma_altitude_m": [10, 3000]}
    assert query["trials"] == ["8"]
    expect(page.get_by_label("Values", exact=True)).to_have_value("10; 3000")
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_enabled()
    visited.assert_clean()


def test_what_is_copied_runs(visit: Callable[..., Visit], server: Server) -> None:
    run = started(
        server, scenario=SHORT, trials=3, sweep={"rdfv.sigma_altitude_m": [10, 30.5]}, label='it\'s a "sweep"'
    )
    study = started(server, scenario=None, algorithms=None, study="multilateration_figure_3", trials=2)
    visited = visit()
    visited.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    for one in (run, study):
        page = visited.open(f"#/runs/{one}")
        finished(page)
        sent = server.ask(f"runs/{one}")
        for button, program in (("Copy as curl", ["sh", "-c"]), ("Copy as Python", [sys.executable, "-c"])):
            page.get_by_role("button", name=button).click()
            text = page.evaluate("navigator.clipboard.readText()")
            environment = {"FILTERROOM_TOKEN": server.token, "PATH": "/usr/local/bin:/usr/bin:/bin"}
            done = subprocess.run([*program, text], env=environment, capture_output=True, text=True, timeout=120)
            assert done.returncode == 0, done.stderr + done.stdout
            again = server.ask("runs?limit=1")["items"][0]
            assert again["id"] != one
            assert {k: again["source"].get(k) for k in ("scenario", "sweep", "study")} == {
                k: sent["source"].get(k) for k in ("scenario", "sweep", "study")
            }
            assert (again["trials"], again["seed"], again["label"]) == (sent["trials"], sent["seed"], sent["label"])


def test_a_study_is_run_and_judged(visit: Callable[..., Visit]) -> None:
    visited = visit()
    page = visited.open("#/studies")
    page.get_by_role("link", name=re.compile("Accuracy with and without")).click()
    page.get_by_label("Trials", exact=True).fill("4")
    page.get_by_role("button", name="Run the study").click()
    finished(page)
    expect(page.get_by_role("tab", selected=True)).to_have_text("Claims")
    expect(page.get_by_role("tabpanel").locator("tbody tr")).to_have_count(4)
    assert drawn(page, "Error against the swept value")["traces"]
    page.get_by_role("link", name="Study", exact=True).click()
    expect(page.get_by_role("link", name=re.compile("from the run of"))).to_be_visible()
    visited.assert_clean()


def test_targets_of_a_scenario_and_a_comparison_with_a_sweep(visit: Callable[..., Visit], server: Server) -> None:
    two = started(server, scenario={"preset": "two_aircraft_crossing"}, trials=4)
    swept = started(server, scenario=SHORT, trials=2, sweep={"scenario.sigma_altitude_m": [10, 100]})
    visited = visit()
    page = visited.open(f"#/runs/{two}")
    finished(page)
    page.locator("target-picker select").select_option("A")
    expect(page.locator(".verdict")).to_contain_text("Target A alone.")
    page.locator("legend-chips button").first.click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('chart-panel[data-drawn=yes]')][0].plot._fullData"
        ".filter((t) => t.meta?.label === 'rdf').every((t) => t.visible === false)"
    )
    page = visited.open(f"#/runs/{swept}")
    finished(page)
    page = visited.open(f"#/compare?run={two}&run={swept}")
    expect(page.get_by_text("sweep_not_comparable")).to_be_visible()


ERROR_CHART = "Horizontal error over trials"
# When the browser asked for a chart, by its own clock, ms.
ASKED = """(chart) => performance.getEntriesByType("resource")
  .filter((one) => one.name.includes(`/charts/${chart}.json`)).map((one) => one.startTime)"""


def zoomed(page: Page, heading: str) -> list[float]:
    """Drag over the middle of a chart; return the range of its abscissa then."""
    before = drawn(page, heading)["x_range"]
    box = panel_of(page, heading).locator(".plot .nsewdrag").first.bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.3 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], middle, steps=4)
    page.mouse.up()
    page.mouse.move(0, 0)
    page.wait_for_function(
        "([panel, wide]) => { const r = panel.plot._fullLayout.xaxis.range; return r[1] - r[0] < 0.5 * wide }",
        arg=[panel_of(page, heading).element_handle(), before[1] - before[0]],
    )
    return drawn(page, heading)["x_range"]


def counted(page: Page) -> int:
    """How many trials the page says there are so far."""
    return int(re.sub(r"\D", "", page.locator("trials-so-far .notice").inner_text().split(" of ")[0]))


def test_numbers_grow_while_trials_run(visit: Callable[..., Visit], server: Server) -> None:
    run = started(server, trials=80_000)
    visited = visit()
    page = visited.open(f"#/runs/{run}")
    expect(page.locator("trials-so-far .notice")).to_contain_text(re.compile(r"of 80\s000 trials"))
    drawn(page, ERROR_CHART)
    page.evaluate("""() => { window.redraws = []; document.addEventListener("drawn", (event) => {
      if (event.target.source.endsWith("/trials_error")) window.redraws.push(performance.now()) }, true) }""")
    at_first = counted(page)
    page.locator("[data-table=metrics] select").first.select_option("nis")
    page.locator("[data-table=metrics] select").nth(1).select_option("inbound")
    table = page.get_by_role("tabpanel").locator("tbody tr").first
    expect(table).to_contain_text("inbound")
    marks = table.locator("td").last
    few = marks.inner_text()
    page.locator("[data-table=metrics] select").nth(1).focus()

    kept = zoomed(page, ERROR_CHART)
    page.locator("[data-table=metrics] select").nth(1).focus()
    page.wait_for_function("() => window.redraws.length >= 5")
    assert drawn(page, ERROR_CHART)["x_range"] == pytest.approx(kept)
    assert counted(page) > at_first
    expect(marks).not_to_have_text(few)
    expect(table).to_contain_text("inbound")
    assert page.locator("[data-table=metrics] select").first.input_value() == "nis"
    assert page.evaluate("document.activeElement.value") == "inbound", "the focus stays where it was"
    # The first is fetched when it comes into view, which nobody can plan.
    asked = page.evaluate(ASKED, "trials_error")[1:]
    assert len(asked) >= 5
    assert min(b - a for a, b in pairwise(asked)) >= 500, "at most two a second"
    assert len(page.evaluate("window.redraws")) <= len(asked), "nothing is drawn that was not asked for"

    # A chart that is on its way while the run is cancelled is given up: the run would refuse it.
    held: list[Route] = []
    page.route("**/charts/trials_error.json*", lambda route: held.append(route))

    def cancelled_first(route: Route) -> None:
        answer = route.fetch()
        for chart in held:
            chart.continue_()
        page.wait_for_timeout(500)
        route.fulfill(response=answer)

    page.route("**/cancel", cancelled_first)
    while not held:
        page.wait_for_timeout(50)
    # The page may learn of the end before the answer is there, and the route is needed until then.
    with page.expect_response("**/cancel"):
        page.get_by_role("button", name="Cancel", exact=True).click()
    expect(page.locator(".run-head .state")).to_have_text("cancelled")
    page.unroute_all()
    expect(page.get_by_role("button", name="Cancel", exact=True)).to_have_count(0)
    assert server.ask(f"runs/{run}")["state"] == "cancelled"
    # Its workers are free: another run comes to its end.
    page = visited.open(f"#/runs/{started(server, scenario=SHORT, trials=2)}")
    finished(page)
    visited.assert_clean()


def test_what_is_zoomed_into_stays_when_the_run_ends(visit: Callable[..., Visit], server: Server) -> None:
    page = visit().open(f"#/runs/{started(server, trials=4_000)}")
    kept = zoomed(page, ERROR_CHART)
    assert page.locator("trials-so-far").count(), "the trials still run"
    panel_of(page, ERROR_CHART).locator(".plot").focus()
    finished(page)
    expect(page.locator("trials-so-far")).to_have_count(0)
    assert drawn(page, ERROR_CHART)["x_range"] == pytest.approx(kept)
    expect(panel_of(page, ERROR_CHART).locator(".plot")).to_be_focused()
    # Another theme changes nothing; a double click shows all.
    page.emulate_media(color_scheme="dark")
    assert drawn(page, ERROR_CHART)["x_range"] == pytest.approx(kept)
    panel_of(page, ERROR_CHART).locator(".plot .nsewdrag").first.dblclick()
    page.wait_for_function(
        "(panel) => { const r = panel.plot._fullLayout.xaxis.range; return r[0] < 10 && r[1] > 1800 }",
        arg=panel_of(page, ERROR_CHART).element_handle(),
    )


def test_a_night_of_trials_in_russian(visit: Callable[..., Visit], server: Server) -> None:
    """Composed, watched, judged: nothing is left in English, nothing is too faint, nothing wider than a phone."""
    visited = visit(locale="ru-RU", color_scheme="dark")
    names = [*(leg["name"] for leg in LEGS), "inbound", "weave", "turn", "orbit", "out_near", "out_far", "GDOP"]

    def in_russian(where: str) -> None:
        left = english_left(page, names)
        assert not left, (where, left)
        found = Axe().run(page, WITHOUT_PLOTS, {"runOnly": ["color-contrast"]})
        assert not found.response["violations"], (where, found.generate_report())

    page = visited.open('#/new?a={"name":"rdf"}&a={"name":"rdfv"}')
    page.locator("[data-mode=scenario]").click()
    page.locator("scenario-source input[inputmode=numeric]").first.fill("40000")
    page.get_by_role("button", name="Перебрать параметр").click()
    page.locator("scenario-source select").last.select_option("scenario.sigma_altitude_m")
    page.get_by_label("Значения", exact=True).fill("10; 300")
    in_russian("composing")
    page.locator(".startbar button.primary").click()
    page.locator("trials-so-far chart-panel[data-drawn]").first.wait_for()
    in_russian("while trials run")
    page.get_by_role("button", name="Отменить", exact=True).click()
    expect(page.locator(".run-head .state")).to_have_text("отменён")
    in_russian("cancelled")

    sweep = {"scenario.sigma_altitude_m": [10, 300]}
    page = visited.open(f"#/runs/{started(server, scenario=SHORT, trials=8, sweep=sweep)}")
    finished(page)
    for tab in page.get_by_role("tab").all():
        tab.click()
        expect(page.locator("[role=tabpanel] .skeleton")).to_have_count(0)
        in_russian(tab.inner_text())
    for panel in page.locator("chart-panel").all():
        panel.scroll_into_view_if_needed()
    visited.settle()
    page.set_viewport_size({"width": 360, "height": 780})
    page.wait_for_function("document.documentElement.scrollWidth <= 360")
    visited.assert_clean()


@pytest.mark.parametrize("locale", ["en-GB", "ru-RU"])
def test_a_sweep_over_trackers_is_told_in_two_sentences(
    visit: Callable[..., Visit], server: Server, locale: str
) -> None:
    """Every case of two trackers was listed, line after line; said is what they have in common."""
    run = started(
        server,
        scenario={"preset": "straight_aircraft", "parameters": {}},
        algorithms=[{"name": "imm_tracker"}, {"name": "curvature_tracker"}],
        sweep={
            "curvature_tracker.predictor": ["ml6", "line"],
            "imm_tracker.association": ["nearest", "joint"],
            "scenario.detection_probability": [0.8, 1],
        },
        trials=8,
        seed=1,
    )
    page = visit(locale=locale, viewport={"width": 360, "height": 800}).open(f"#/runs/{run}")
    finished(page)
    first = page.locator(".verdict > span").first
    expect(first).to_contain_text(re.compile("of 8 cases|из 8 случаев"))
    assert len(re.findall(r"\.(?: |$)", first.inner_text())) <= 2
    assert len(first.inner_text()) < 330
