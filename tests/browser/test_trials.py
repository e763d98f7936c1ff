"""Monte Carlo runs as a person makes them: by keyboard, judged, copied, by target, done again."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import urllib.request
from collections.abc import Callable
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn
from tests.browser.conftest import Server, Visit
from tests.browser.keyboard import press, tab_to

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LEGS = [{"name": "first", "start_s": 0, "stop_s": 30}, {"name": "second", "start_s": 30, "stop_s": 60}]
SHORT = {"preset": "four_station_circuit", "parameters": {"duration_s": 59, "legs": LEGS}}
ENTRIES = [{"name": "rdf"}, {"name": "rdfv"}]


def ask(server: Server, path: str, body: Any = None) -> Any:
    head = {"Authorization": f"Bearer {server.token}", "Content-Type": "application/json"}
    data = None if body is None else json.dumps(body).encode()
    with urllib.request.urlopen(urllib.request.Request(f"{server.url}/api/v1/{path}", data, head)) as answer:
        return json.load(answer)


def started(server: Server, **changes: Any) -> str:
    body = {"scenario": {"preset": "four_station_circuit"}, "trials": 20, "algorithms": ENTRIES} | changes
    return str(ask(server, "runs", {k: v for k, v in body.items() if v is not None})["id"])


def finished(page: Page) -> None:
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded|завершён|готов"), timeout=120_000)
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
        sent = ask(server, f"runs/{one}")
        for button, program in (("Copy as curl", ["sh", "-c"]), ("Copy as Python", [sys.executable, "-c"])):
            page.get_by_role("button", name=button).click()
            text = page.evaluate("navigator.clipboard.readText()")
            environment = {"FILTERROOM_TOKEN": server.token, "PATH": "/usr/local/bin:/usr/bin:/bin"}
            done = subprocess.run([*program, text], env=environment, capture_output=True, text=True, timeout=120)
            assert done.returncode == 0, done.stderr + done.stdout
            again = ask(server, "runs?limit=1")["items"][0]
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
