"""Forward scatter as a person sees it: the sample's passes, a recording of one's own, trials, a study, Russian."""

from __future__ import annotations

import json
import re
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser.charts import drawn, panel_of
from tests.browser.conftest import Server, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LABELS = ("forward_scatter_ml", "forward_scatter_lines", "forward_scatter_angle")


def test_the_sample_shows_three_passes(visit: Callable[..., Visit], server: Server) -> None:
    visited = visit()
    page = visited.open(f"#/runs/{server.sample_run('base line')['id']}")
    passes = drawn(page, "Passes across the base line")
    for label in LABELS:
        (path,) = passes.traces(role="series", label=label)
        assert path["points"] == 93 + 2, "three passes with a gap between each two"
    assert {t["name"] for t in passes.traces(role="station")} == {"lines of sight", "transmitters and receivers"}
    crossing = drawn(page, "What is known of the crossing")
    assert len(crossing.traces(role="truth")) == 2
    lines = drawn(page, "Dopplers and their lines")
    assert {t["name"] for t in lines.traces(label="forward_scatter_lines")} >= {
        "forward_scatter_lines, line 1",
        "forward_scatter_lines, crossing of receiver 2",
    }
    assert drawn(page, "Azimuth from the base line").traces(role="measurement")
    assert len(drawn(page, "What calibration errors cost").traces(role="series")) == 3
    difference = drawn(page, "Angular velocity")
    assert len(difference.traces(role="truth")) == 2
    assert len(drawn(page, "Bound along the base line").traces(role="series")) == 4
    page.get_by_role("tab", name=re.compile("Decisions")).click()
    expect(page.get_by_role("tabpanel")).to_contain_text("crossing time of this receiver is kept")
    visited.assert_clean()


def test_a_row_of_the_passes_shows_its_time_alone(visit: Callable[..., Visit], server: Server) -> None:
    """By the keyboard: Enter looks at the second pass, also in charts drawn later; Enter again at everything."""
    visited = visit()
    page = visited.open(f"#/runs/{server.sample_run('base line')['id']}")
    whole = drawn(page, "What is known of the crossing")["x_range"]
    assert whole[1] - whole[0] > 250
    page.get_by_role("tab", name=re.compile("Tracks")).click()
    row = page.locator("[data-table=tracks] tbody tr").nth(1)
    expect(row).to_contain_text("120")
    row.press("Enter")
    expect(row).to_have_class(re.compile("current"))
    expect(row).to_be_focused()
    crossing = panel_of(page, "What is known of the crossing").element_handle()
    page.wait_for_function("(p) => p.plot._fullLayout.xaxis.range[0] > 100", arg=crossing)
    assert drawn(page, "What is known of the crossing")["x_range"] == pytest.approx([118.5, 151.5])
    assert drawn(page, "Dopplers and their lines")["x_range"] == pytest.approx([118.5, 151.5])
    assert drawn(page, "Passes across the base line")["x_range"][1] < 100, "kilometres, not seconds"
    row.press("Enter")
    expect(row).not_to_have_class(re.compile("current"))
    page.wait_for_function("(p) => p.plot._fullLayout.xaxis.range[0] < 100", arg=crossing)
    assert drawn(page, "What is known of the crossing")["x_range"] == pytest.approx(whole)
    visited.assert_clean()


def test_places_are_typed_on_the_page(visit: Callable[..., Visit], server: Server) -> None:
    """A file of Dopplers alone becomes a recording that can be run, without a file for its site."""
    sample = Path(__file__).parents[2] / "examples" / "recordings" / "sample_dopplers.csv"
    rows = "".join(sample.read_text().splitlines(keepends=True)[:32]).encode()
    head = {"Authorization": f"Bearer {server.token}", "Content-Type": "application/octet-stream"}
    address = f"{server.url}/api/v1/recordings?name=alone.csv"
    with urllib.request.urlopen(urllib.request.Request(address, rows, head)) as answer:
        recording = json.load(answer)["id"]
    visited = visit()
    page = visited.open(f"#/recordings/{recording}")
    form = page.locator("doppler-site-form")
    form.get_by_label("Transmitters and receivers").select_option("1x2")
    typed = {
        "transmitters.0.east_m": "34641",
        "transmitters.0.north_m": "20000",
        "receivers.0.east_m": "75",
        "receivers.0.north_m": "-129,9",
        "receivers.1.east_m": "-75",
        "receivers.1.north_m": "129.9",
    }
    for field, value in typed.items():
        form.locator(f"[data-field='{field}']").fill(value)
    send = form.get_by_role("button", name="Read again with this site")
    send.click()
    wavelength = form.get_by_label("Wavelength, m")
    expect(form).to_contain_text("Wavelength, m: a number is needed.")
    expect(wavelength).to_be_focused()
    wavelength.fill("1")
    send.click()
    expect(page.get_by_role("region", name="Receivers")).to_contain_text("-129.9")
    read = page.url.rpartition("/")[2]
    assert read != recording
    made = server.ask(f"recordings/{read}")["site"]
    assert made["wavelength_m"] == 1
    run = server.ask("runs", {"recording_id": read, "algorithms": [{"name": "forward_scatter_ml"}]})
    assert "id" in run
    # Now it is folded, and holds what was typed.
    page.get_by_text("Change the places").click()
    expect(page.locator("[data-field='receivers.0.north_m']")).to_have_value("-129.9")
    visited.assert_clean()


def test_the_form_has_the_choices_of_the_paper(visit: Callable[..., Visit], server: Server) -> None:
    """What is chosen there is what the run was given: a formula is a number, a rule a word."""
    visited = visit()
    recordings = server.ask("recordings?kind=doppler_pairs")["items"]
    (recording,) = (r for r in recordings if r["name"] == "sample_dopplers.csv")
    page = visited.open(f'#/new?recording={recording["id"]}&a={{"name":"forward_scatter_lines"}}')
    page.get_by_label("Formula", exact=True).wait_for()
    page.get_by_label("Formula", exact=True).select_option("19")
    page.get_by_label("Crossing is kept", exact=True).select_option("c")
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded"), timeout=120_000)
    run = server.ask(f"runs/{page.url.rpartition('/')[2]}")
    assert run["algorithms"][0]["parameters"] == {"formula": 19, "freeze_rule": "c"}
    visited.assert_clean()


def test_trials_show_both_bounds_and_a_study_its_verdicts(visit: Callable[..., Visit], server: Server) -> None:
    visited = visit()
    study = server.ask("runs", {"study": "forward_scatter_figure_2", "trials": 64})
    page = visited.open(f"#/runs/{study['id']}")
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded"), timeout=180_000)
    errors = drawn(page, "Error of the crossing distance over trials")
    assert {t["name"] for t in errors.traces(role="bound")} == {"bound, course unknown", "bound, course known"}
    labels = {"paper", "all data", "likelihood"}
    assert {t["label"] for t in errors.traces(role="series")} == labels
    middle = drawn(page, "Middle of the errors over trials")
    assert {t["label"] for t in middle.traces(role="interval")} == labels
    assert len(middle.traces(role="series", label="paper")) == 2, "errors, and trials without an answer"
    paths = drawn(page, "Paths of single trials")
    assert {t["label"]: t["points"] for t in paths.traces(role="series")} == dict.fromkeys(labels, 5 * 32)
    assert len(paths.traces(role="truth")) == 1
    page.get_by_role("tab", name=re.compile("Claims")).click()
    panel = page.get_by_role("tabpanel")
    expect(panel).to_contain_text("the accuracy is sufficient and comparable with the potential one")
    expect(panel.locator("tbody tr")).to_have_count(3)
    visited.assert_clean()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_speaks_russian_and_fits_a_telephone(visit: Callable[..., Visit], server: Server, scheme: str) -> None:
    run = server.sample_run("base line")["id"]
    visited = visit(locale="ru-RU", color_scheme=scheme, viewport={"width": 390, "height": 844})
    page = visited.open(f"#/runs/{run}")
    drawn(page, "Пролёты через базу")
    drawn(page, "Что известно о пересечении")
    names = (*LABELS, "TX", "RX", "sample_dopplers", "Sample: three passes across a base line", "sample", "chi2")
    assert english_left(page, names) == []
    overflow = page.evaluate("() => document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert overflow <= 0
    visited.assert_clean()
