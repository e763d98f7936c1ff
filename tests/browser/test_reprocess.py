"""What a person does: upload marks, see what was read, choose algorithms, watch, and look at what came of it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import Visit

pytestmark = pytest.mark.browser
ALGORITHMS = ("single_mark", "rdf", "rdfv")


def upload(page: Page, marks: Path, site: Path, name: str) -> None:
    page.get_by_label("Marks", exact=True).set_input_files(marks)
    page.get_by_label("Site", exact=True).set_input_files(site)
    page.get_by_label("Name").fill(name)
    page.get_by_role("button", name="Upload and read").click()


def test_upload_to_result(visit: Callable[..., Visit], broken_marks: Path, repository: Path) -> None:
    visited = visit()
    page = visited.open("#/new?source=upload")
    upload(page, broken_marks, repository / "examples" / "recordings" / "sample_site.json", "Broken sample")

    # What was read, and each row that was not, with its reason.
    report = page.get_by_role("region", name="Source")
    expect(report.get_by_role("heading", name="Broken sample")).to_be_visible()
    rejected = report.get_by_role("region", name="Rejected rows").locator("tbody tr")
    expect(rejected).to_have_count(3)
    assert [int(row.locator("td").first.inner_text()) for row in rejected.all()] == [5, 9, 12]
    expect(rejected.nth(0)).to_contain_text("noon")
    expect(rejected.nth(1)).to_contain_text("12a4")
    expect(rejected.nth(2)).to_contain_text(re.compile("duplicate", re.I))
    tiles = dict(
        zip(report.locator(".tiles dt").all_inner_texts(), report.locator(".tiles dd").all_inner_texts(), strict=True)
    )
    assert int(tiles["Rows read"]) == int(tiles["Accepted"]) + 3

    # Three algorithms; what is wrong with a number is said under its field.
    start = page.get_by_role("button", name="Start", exact=True)
    expect(start).to_be_disabled()
    for name in ALGORITHMS:
        page.get_by_role("button", name=name, exact=True).click()
    form = page.locator("[data-algorithm=rdfv] [data-name=sigma_altitude_m]")
    expect(form.locator("input")).to_have_attribute("placeholder", "100")
    expect(form).to_contain_text("From the site")
    form.locator("input").fill("tall")
    expect(form.locator(".error")).to_contain_text("Not a number")
    expect(start).to_be_disabled()
    form.locator("input").fill("1,2e2 m")
    expect(form.locator(".dot")).to_be_visible()
    expect(start).to_be_enabled()
    assert "sigma_altitude_m" in page.url, "the form's state is in the address"
    start.click()

    # Progress, then the answer: a sentence before everything else.
    expect(page.locator(".run-head .state")).to_have_text(re.compile("queued|running|succeeded"))
    expect(page.locator(".run-head .state")).to_have_text("succeeded")
    expect(page.locator(".verdict")).to_contain_text("most accurate")

    plan = drawn(page, "Plan")
    assert (plan["x_title"], plan["y_title"]) == ("East, km", "North, km")
    assert "x" in (plan["x_scaleanchor"], plan["y_scaleanchor"]) or "y" in (
        plan["x_scaleanchor"],
        plan["y_scaleanchor"],
    )
    assert plan.scales[0] == pytest.approx(plan.scales[1], rel=1e-3), "a plan has equal axes"
    assert len(plan.traces(role="station")) == 1
    assert plan.traces(role="station")[0]["points"] == 4
    assert plan.traces(role="truth")
    for name in ALGORITHMS:
        assert sum(t["points"] for t in plan.traces(role="series", label=name)) > 300, name

    error = drawn(page, "Horizontal error")
    assert (error["x_title"], error["y_title"], error["y_type"]) == ("Time, s", "Horizontal error, m", "log")
    for name in ALGORITHMS:
        assert len(error.traces(role="series", label=name)) >= 2, "actual and claimed"
    nis = drawn(page, "NIS")
    assert nis["x_title"] == "Time, s"
    assert nis.traces(role="bound"), "the band is drawn"
    assert {t["label"] for t in nis.traces(role="series")} == set(ALGORITHMS)

    # A chip hides its entry in every chart.
    page.locator("legend-chips button", has_text=re.compile("^rdf$")).click()
    expect(page.locator("legend-chips button", has_text=re.compile("^rdf$"))).to_have_attribute("aria-pressed", "false")
    page.wait_for_function(
        "() => document.querySelector('chart-panel .plot')._fullData.some((t) => t.visible === false)"
    )
    assert not any(t["visible"] for t in drawn(page, "Plan").traces(label="rdf"))
    assert any(t["visible"] for t in drawn(page, "Plan").traces(label="rdfv"))
    assert "hide=rdf" in page.url
    page.locator("legend-chips button", has_text=re.compile("^rdf$")).click()

    # A row of the decisions and its point in the charts select each other.
    page.get_by_role("tab", name=re.compile("^Decisions")).click()
    table = page.locator("data-table[data-table=decisions]")
    table.get_by_role("button", name="Entry").click()
    plotted = {r for t in error.traces(label="rdf") for r in t["rows"]}
    row = next(
        r
        for r in table.locator("tbody tr").all()
        if int(r.locator("td").nth(1).inner_text().replace("\u202f", "")) in plotted
    )
    row.click()
    expect(table.locator("tr.current")).to_have_count(1)
    expect(panel_of(page, "Horizontal error").locator(".overlay line")).to_have_count(1)
    expect(panel_of(page, "Horizontal error").locator(".strip")).to_contain_text("rdf")

    # The numbers as a table, the settings that were used and where they came from.
    panel_of(page, "Plan").get_by_role("button", name="As table: Plan").click()
    expect(panel_of(page, "Plan").locator(".as-table tbody tr").first).to_be_visible()
    page.get_by_role("tab", name="Parameters").click()
    used = page.locator("section[aria-label=rdfv] tr", has_text="sigma_altitude_m")
    expect(used).to_contain_text("120")
    expect(used).to_contain_text("given in the run")
    page.get_by_role("tab", name="Metrics").click()
    expect(page.locator("table[data-table=metrics] tr", has_text="Position error (3-D), rms")).to_contain_text(" m")
    visited.assert_clean()


def test_what_cannot_be_read_says_why(visit: Callable[..., Visit], tmp_path: Path) -> None:
    page = visit().open("#/new?source=upload")
    nonsense = tmp_path / "nonsense.csv"
    nonsense.write_text("colour,shape\nred,round\n")
    page.get_by_label("Marks", exact=True).set_input_files(nonsense)
    page.get_by_role("button", name="Upload and read").click()
    failure = page.locator(".failure")
    expect(failure).to_be_visible()
    assert len(failure.inner_text()) > 40, "title, detail and code"
    expect(failure.get_by_role("button", name="Copy")).to_be_visible()


@pytest.mark.slow
def test_a_cancelled_run_says_so(visit: Callable[..., Visit], repository: Path, tmp_path: Path) -> None:
    """A recording fifty times as long as the sample, so that the run lives long enough to be cancelled."""
    samples = repository / "examples" / "recordings"
    head, *rows = (samples / "sample_marks.csv").read_text().splitlines()
    long_marks = tmp_path / "long_marks.csv"
    with long_marks.open("w") as out:
        print(head, file=out)
        for lap in range(50):
            for row in rows:
                time_s, rest = row.split(",", 1)
                print(f"{float(time_s) + 800 * lap:.6f},{rest}", file=out)
    page = visit().open("#/new?source=upload&" + "&".join(f'a={{"name":"rdfv","label":"rdfv {i}"}}' for i in range(20)))
    upload(page, long_marks, samples / "sample_site.json", "Long")
    page.get_by_role("button", name="Start", exact=True).click()
    page.locator(".run-head").get_by_role("button", name="Cancel", exact=True).click()
    expect(page.locator(".run-head .state")).to_have_text("cancelled")
    expect(page.locator(".notice")).to_contain_text("cancelled before it was done")
    expect(page.locator(".run-head").get_by_role("button", name="Cancel", exact=True)).to_have_count(0)
    page.locator(".run-head").get_by_role("button", name="Delete", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page).to_have_url(re.compile("#/runs$"))
