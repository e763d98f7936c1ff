"""Plot tracking as a person sees it: tracks, why a plot went where, what was asked and reached, two radars, Russian."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import Server, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LABELS = ("imm_tracker", "curvature_tracker")


def finished(server: Server, recording: str, algorithms: list[dict[str, Any]]) -> str:
    run = server.ask("runs", {"recording_id": recording, "algorithms": algorithms, "seed": 1})["id"]
    while (state := server.ask(f"runs/{run}")["state"]) not in ("succeeded", "failed"):
        time.sleep(0.2)
    assert state == "succeeded"
    return str(run)


def test_the_sample_shows_tracks_and_tells_what_became_of_every_plot(
    visit: Callable[..., Visit], server: Server
) -> None:
    run = server.sample_run("ten aircraft")["id"]
    visited = visit()
    page = visited.open(f"#/runs/{run}")
    plan = drawn(page, "Plan")
    assert {t["label"] for t in plan.traces(role="series")} == set(LABELS)
    assert plan.traces(role="truth")
    bars = drawn(page, "Continuity").traces(role="series")
    # Each of the ten aircraft has a track of each tracker.
    assert len({t["name"] for t in bars if t["label"] == "imm_tracker"}) >= 10
    assert drawn(page, "Plots in their gates").traces(role="bound")
    drawn(page, "OSPA and GOSPA")
    drawn(page, "Memory of the tracks")
    drawn(page, "Calibration of the gates")
    page.get_by_role("tab", name=re.compile("Decisions")).click()
    panel = page.get_by_role("tabpanel")
    expect(panel).to_contain_text("second plot of a track")
    expect(panel.get_by_role("columnheader", name="Competing tracks")).to_be_visible()
    every = panel.locator("tbody tr").count()
    panel.get_by_label("Track number").fill("3")
    expect(panel.locator("tbody tr td:nth-child(2)").first).to_have_text("3")
    assert panel.locator("tbody tr").count() <= every
    visited.assert_clean()


def test_what_was_asked_is_passed_or_not(visit: Callable[..., Visit], server: Server) -> None:
    source = server.sample_run("ten aircraft")["source"]
    asked = {"required_rms_m": 200, "required_tracked_share": 0.9, "allowed_switches": 0}
    run = finished(server, source["recording_id"], [{"name": "imm_tracker", "parameters": asked}])
    visited = visit()
    page = visited.open(f"#/runs/{run}?tab=requirements")
    panel = page.get_by_role("tabpanel")
    expect(panel).to_contain_text("✓ passed")
    panel.get_by_label("Verdict").select_option("failed")
    expect(panel.locator("tbody tr").first).to_contain_text("✗ failed")
    expect(panel.locator("tbody")).not_to_contain_text("✓ passed")
    visited.assert_clean()


def test_tracks_of_two_radars_are_joined(visit: Callable[..., Visit], server: Server) -> None:
    given = {"preset": "two_radars_tracks", "parameters": {}, "seed": 1, "name": "two radars"}
    recording = server.ask("scenarios/recording", given)["id"]
    run = finished(server, recording, [{"name": "imm_tracker"}])
    visited = visit()
    page = visited.open(f"#/runs/{run}?tab=joins")
    expect(page.get_by_role("tabpanel")).to_contain_text("they are near each other wherever both live")
    drawn(page, "Continuity")
    # A row for each target and radar.
    rows = panel_of(page, "Continuity").locator(".ytick text").all_text_contents()
    assert {"imm_tracker, 1, 1", "imm_tracker, 1, 2"} <= {row.strip() for row in rows}
    visited.assert_clean()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_speaks_russian_and_fits_a_telephone(visit: Callable[..., Visit], server: Server, scheme: str) -> None:
    run = server.sample_run("ten aircraft")["id"]
    visited = visit(locale="ru-RU", color_scheme=scheme, viewport={"width": 390, "height": 844})
    page = visited.open(f"#/runs/{run}?tab=requirements")
    drawn(page, "Непрерывность трасс")
    expect(page.get_by_role("tabpanel")).to_contain_text("не задано")
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    names = (*LABELS, "radar", "clutter", "sample_tracking", "imm", "OSPA", "GOSPA", "sample", "chi2")
    left = english_left(page, names)
    assert left == [], "\n".join(left)
    visited.assert_clean()
