"""The list of runs: filters of the server, label and tags edited in place, running again, comparing."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn
from tests.browser.conftest import Server, Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not


def finished_run(server: Server, **body: Any) -> dict[str, Any]:
    """Run something on the sample's recording and wait for it."""
    deadline = time.monotonic() + 180
    while not (recordings := server.ask("recordings?text=sample_marks")["items"]):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    run: dict[str, Any] = server.ask("runs", {"recording_id": recordings[-1]["id"], **body})
    while run["state"] in ("queued", "running"):
        assert time.monotonic() < deadline, run
        time.sleep(0.05)
        run = server.ask(f"runs/{run['id']}")
    assert run["state"] == "succeeded", run["error"]
    return run


@pytest.fixture(scope="module")
def pair(server: Server) -> list[dict[str, Any]]:
    """Two runs that differ in one parameter, and a third of another algorithm."""
    coarse = {"name": "rdfv", "label": "rdfv", "parameters": {"sigma_altitude_m": 300}}
    return [
        finished_run(server, label="fine", tags=["pair", "night"], algorithms=[{"name": "rdf"}, {"name": "rdfv"}]),
        finished_run(server, label="coarse", tags=["pair"], seed=7, algorithms=[{"name": "rdf"}, coarse]),
        finished_run(server, label="alone", algorithms=[{"name": "single_mark"}]),
    ]


def rows(page: Page) -> Any:
    return page.locator("main tbody tr")


def test_the_server_filters_the_list(visit: Callable[..., Visit], pair: list[dict[str, Any]]) -> None:
    visited = visit()
    page = visited.open("#/runs")
    page.get_by_label("Tag", exact=True).select_option("pair")
    expect(rows(page)).to_have_count(2)
    page.get_by_label("Filter runs").last.fill("NIGHT sample_marks")
    expect(rows(page)).to_have_count(1)
    expect(rows(page)).to_contain_text("fine")
    page.reload()
    expect(rows(page)).to_have_count(1)
    expect(page.get_by_label("Tag", exact=True)).to_have_value("pair")
    page.get_by_role("button", name="Clear filters").click()
    page.get_by_label("Algorithm", exact=True).select_option("single_mark")
    expect(rows(page).filter(has_text="alone")).to_have_count(1)
    expect(rows(page).filter(has_text="coarse")).to_have_count(0)
    page.get_by_label("State", exact=True).select_option("failed")
    expect(page.get_by_text("No run matches the filter")).to_be_visible()
    page.get_by_role("button", name="Clear filters").click()
    recording = page.get_by_label("Recording", exact=True)
    recording.select_option(label="sample_marks.csv")
    expect(rows(page).filter(has_text="coarse")).to_contain_text("MB")
    rows(page).filter(has_text="coarse").get_by_role("link", name="pair").click()
    expect(rows(page)).to_have_count(2)
    expect(page).to_have_url(re.compile(r"#/runs\?tag=pair$"))
    visited.assert_clean()


def test_label_and_tags_are_edited_in_place(visit: Callable[..., Visit], server: Server) -> None:
    finished_run(server, label="draft", tags=["edited"], algorithms=[{"name": "single_mark"}])
    visited = visit()
    page = visited.open("#/runs?tag=edited")
    link = page.get_by_role("link", name="draft", exact=True)
    link.wait_for()
    page.keyboard.press("j")
    page.keyboard.press("e")
    page.keyboard.type("never")
    page.keyboard.press("Escape")
    expect(link).to_be_visible()
    page.keyboard.press("e")
    page.get_by_label("Label of the run").fill("final <b>")
    page.get_by_label("Tags", exact=True).fill("edited, ночь,, edited")
    page.keyboard.press("Enter")
    expect(rows(page)).to_contain_text("final <b>")
    expect(rows(page).locator(".tag")).to_have_text(["edited", "ночь"])
    page.get_by_role("link", name="final <b>").first.click()
    expect(page.locator(".run-head h1")).to_have_text("final <b>")
    page.locator(".run-head [data-edit]").click()
    page.get_by_label("Tags", exact=True).fill(", ".join(f"tag {i}" for i in range(21)))
    page.get_by_role("button", name="Save").click()
    expect(page.locator(".run-head [role=alert]")).to_contain_text("/tags")
    page.get_by_label("Tags", exact=True).fill("edited")
    page.get_by_role("button", name="Save").click()
    expect(page.locator(".run-head .tag")).to_have_text(["edited"])


def test_a_run_is_run_again_with_everything_filled_in(
    visit: Callable[..., Visit], pair: list[dict[str, Any]], server: Server
) -> None:
    page = visit().open("#/runs?tag=pair")
    page.get_by_role("link", name="Run again with changes: coarse").click()
    expect(page.get_by_label("Label of the run")).to_have_value("coarse")
    expect(page.get_by_label("Tags", exact=True)).to_have_value("pair")
    page.get_by_label("Label of the run").fill("again")
    page.get_by_label("Tags", exact=True).fill("second")
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page).to_have_url(re.compile("#/runs/[0-9a-f]+"))
    expect(page.locator(".run-head .state")).to_have_text("succeeded")
    run = server.ask("runs?tag=second")["items"][0]
    assert (run["label"], run["seed"]) == ("again", 7)
    assert run["algorithms"] == pair[1]["algorithms"]


def test_older_runs_are_fetched_on_request(visit: Callable[..., Visit], server: Server) -> None:
    visited = visit()
    page = visited.page
    # One run to a page: what is tested is the way of the cursor, not the size of the page.
    page.route("**/api/v1/runs?*", lambda route: route.continue_(url=route.request.url.replace("limit=50", "limit=1")))
    total = len(server.ask("runs?limit=500")["items"])
    visited.open("#/runs")
    expect(rows(page)).to_have_count(1)
    for count in range(2, min(total, 4) + 1):
        page.get_by_role("button", name="Older runs").click()
        expect(rows(page)).to_have_count(count)


def test_two_runs_are_compared_by_keyboard(visit: Callable[..., Visit], pair: list[dict[str, Any]]) -> None:
    visited = visit()
    page = visited.open("#/runs?tag=pair")
    expect(rows(page)).to_have_count(2)
    tray = page.get_by_role("region", name="Ticked runs")
    page.keyboard.press("j")
    page.keyboard.press("j")
    page.keyboard.press("x")
    expect(tray).to_be_hidden()
    page.keyboard.press("k")
    page.keyboard.press("x")
    expect(tray).to_be_visible()
    expect(tray.get_by_role("listitem")).to_have_text(["fine", "coarse"])
    colours = tray.locator("line").evaluate_all("(lines) => lines.map((one) => one.getAttribute('stroke'))")
    page.reload()
    expect(tray.get_by_role("listitem")).to_have_text(["fine", "coarse"])
    page.keyboard.press("c")
    ids = [run["id"] for run in pair[:2]]
    expect(page).to_have_url(re.compile(f"#/compare\\?run={ids[0]}&run={ids[1]}$"))
    parameters = page.get_by_role("region", name="Parameters").last
    # The two parameters in which these entries differ, and nothing that is the same.
    expect(parameters.locator("[data-line=sigma_altitude_m] td")).to_have_text(["–", "100", "–", "300"])
    expect(parameters.locator("[data-line=sigma_jerk_mps3]")).to_have_count(0)
    expect(parameters.locator("[data-differs=false]")).to_have_count(0)
    page.get_by_label("Only differences").uncheck()
    expect(parameters.locator("[data-line=sigma_jerk_mps3]")).to_have_count(1)
    expect(page).to_have_url(re.compile("all=1"))
    page.get_by_label("Only differences").check()
    metrics = page.get_by_role("region", name="Metrics").last
    error = metrics.locator("[data-line=rms_horizontal_m]")
    summaries = [run["summary"]["rms_horizontal_m"][name]["value"] for run in pair[:2] for name in ("rdf", "rdfv")]
    best = [i for i, value in enumerate(summaries) if value == min(summaries)]
    for i in range(4):
        expect(error.locator("td").nth(i).locator(".best")).to_have_count(int(i in best))
    expect(page.locator(".verdict")).to_contain_text("/ rdfv")
    # One colour for an entry everywhere: tray, head of the tables, chips, every chart.
    for place in ("table.compare thead", "legend-chips"):
        lines = page.locator(place).first.locator("line")
        assert lines.evaluate_all("(lines) => lines.map((one) => one.getAttribute('stroke'))") == colours
    labels = ["fine / rdf", "fine / rdfv", "coarse / rdf", "coarse / rdfv"]
    for heading in ("Plan", "Horizontal error", "NIS", "Altitude"):
        chart = drawn(page, heading)
        for label, colour in zip(labels, colours, strict=True):
            series = chart.traces(role="series", label=label)
            assert {trace["color"].lower() for trace in series} == {colour.lower()}, (heading, label)
    page.locator("legend-chips button").first.click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('chart-panel[data-drawn] .plot')].every((plot) =>"
        " plot._fullData.every((t) => t.meta?.label !== 'fine / rdf' || t.visible !== true))"
    )
    page.get_by_role("link", name="Choose other runs").click()
    expect(tray.get_by_role("listitem")).to_have_text(["fine", "coarse"])
    page.go_back()
    expect(page.locator("legend-chips button").first).to_have_attribute("aria-pressed", "false")
    visited.assert_clean()


def test_data_of_a_compared_chart_are_at_hand(visit: Callable[..., Visit], pair: list[dict[str, Any]]) -> None:
    page = visit().open(f"#/compare?run={pair[0]['id']}&run={pair[1]['id']}")
    drawn(page, "Plan")
    page.get_by_role("button", name="As table: Plan").click()
    expect(page.get_by_role("region", name="As table: Plan")).to_contain_text("fine / rdf")


def test_charts_that_cannot_be_are_named_in_one_line(visit: Callable[..., Visit], server: Server) -> None:
    """Marks of stations beside plots of an antenna: no plan, but errors over time."""
    runs = [server.sample_run(words)["id"] for words in ("on simulated marks", "before an antenna")]
    visited = visit()
    page = visited.open(f"#/compare?run={runs[0]}&run={runs[1]}")
    expect(page.locator("[data-not-drawn]")).to_contain_text(re.compile("^Not drawn: Plan, .*different recordings"))
    drawn(page, "Radial error")
    assert "Plan" not in page.locator("chart-panel h2").all_inner_texts()
    visited.assert_clean()


def test_a_run_that_is_gone_leaves_the_others(
    visit: Callable[..., Visit], server: Server, pair: list[dict[str, Any]]
) -> None:
    doomed = finished_run(server, label="doomed", algorithms=[{"name": "single_mark"}])
    server.ask(f"runs/{doomed['id']}", method="DELETE")
    page = visit().open(f"#/compare?run={pair[0]['id']}&run={doomed['id']}&run={pair[1]['id']}")
    expect(page.get_by_role("alert")).to_contain_text("run_not_found")
    page.get_by_role("link", name="Compare the other 2").click()
    expect(page.locator("table.compare").first).to_contain_text("coarse")
    page.evaluate("location.hash = '#/compare'")
    expect(page.get_by_text("Tick two to ten runs")).to_be_visible()


def test_at_most_ten_runs_are_ticked(visit: Callable[..., Visit], server: Server) -> None:
    for number in range(11):
        finished_run(server, label=f"one of many {number}", tags=["many"], algorithms=[{"name": "single_mark"}])
    page = visit().open("#/runs?tag=many")
    expect(rows(page)).to_have_count(11)
    for box in page.locator("[data-pick]").all():
        box.click()
    expect(page.locator("[data-pick]:checked")).to_have_count(10)
    expect(page.get_by_text("At most 10 runs can be compared")).to_be_visible()
    page.get_by_role("button", name="Clear", exact=True).click()
    expect(page.locator("[data-pick]:checked")).to_have_count(0)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_in_list_and_comparison(
    visit: Callable[..., Visit], pair: list[dict[str, Any]], scheme: str
) -> None:
    ids = [run["id"] for run in pair[:2]]
    visited = visit(color_scheme=scheme)
    page = visited.open("#/about")
    visited.settle()
    for route in (f"#/runs?tag=pair&pick={ids[0]}&pick={ids[1]}", f"#/compare?run={ids[0]}&run={ids[1]}"):
        visited.follow(route)
        page.locator("compare-tray:not([hidden]), table.compare").first.wait_for()
        results = Axe().run(page, context={"include": [["html"]], "exclude": [[".plot > *"]]})
        found = [f"{v['id']} {[n['target'] for n in v['nodes']][:3]}" for v in results.response["violations"]]
        assert not found, (route, found)


@pytest.mark.parametrize("width", [360, 1366])
def test_a_comparison_is_not_cut_off(visit: Callable[..., Visit], pair: list[dict[str, Any]], width: int) -> None:
    visited = visit(viewport={"width": width, "height": 844})
    ids = [run["id"] for run in pair[:2]]
    page = visited.open("#/about")
    visited.settle()
    for route in (f"#/runs?pick={ids[0]}&pick={ids[1]}", f"#/compare?run={ids[0]}&run={ids[1]}"):
        visited.follow(route)
        page.locator("compare-tray:not([hidden]), table.compare").first.wait_for()
        assert page.evaluate("document.documentElement.scrollWidth - window.innerWidth") <= 0, route
