"""Recordings: dropped on the page, read again with another site, deleted with and without runs."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import Visit
from tests.browser.test_reprocess import upload

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not

_DROP = """(files) => {
  const carried = new DataTransfer();
  for (const [name, text] of files) {
    carried.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
  }
  for (const type of ['dragenter', 'dragover', 'drop']) {
    document.body.dispatchEvent(new DragEvent(type, { dataTransfer: carried, bubbles: true, cancelable: true }));
  }
}"""


def drop(page: Page, *paths: Path) -> None:
    """Drop files on the page, as the file manager does."""
    page.evaluate(_DROP, [[path.name, base64.b64encode(path.read_bytes()).decode()] for path in paths])


def marks_of_its_own(repository: Path, folder: Path, name: str, rows: int = 200) -> Path:
    """The first rows of the sample under another name; their number makes each a recording of its own."""
    lines = (repository / "examples" / "recordings" / "sample_marks.csv").read_text().splitlines()
    path = folder / name
    path.write_text("\n".join(lines[: rows + 1]) + "\n")
    return path


def site_moved(repository: Path, folder: Path) -> Path:
    """The sample's site with its first station 40 m further up."""
    site = json.loads((repository / "examples" / "recordings" / "sample_site.json").read_text())
    site["stations"][0]["up_m"] = site["stations"][0].get("up_m", 0.0) + 40.0
    path = folder / "moved_site.json"
    path.write_text(json.dumps(site))
    return path


def test_files_dropped_anywhere_are_uploaded(visit: Callable[..., Visit], repository: Path, tmp_path: Path) -> None:
    visited = visit()
    page = visited.open("#/recordings")
    page.get_by_role("link", name="sample_marks.csv").wait_for()
    marks = marks_of_its_own(repository, tmp_path, "dropped_marks.csv", 210)
    drop(page, repository / "examples" / "recordings" / "sample_site.json", marks)
    expect(page).to_have_url(re.compile("#/new"))
    expect(page.get_by_text("dropped_marks.csv")).to_be_visible()
    expect(page.get_by_text("sample_site.json")).to_be_visible()
    page.get_by_role("button", name="Upload and read").click()
    expect(page.get_by_role("region", name="Source").get_by_role("heading", name="dropped_marks.csv")).to_be_visible()
    expect(page.get_by_role("region", name="Source")).to_contain_text("4 stations")
    expect(page.locator("drop-zone")).to_be_hidden()
    visited.assert_clean()


def test_a_recording_is_read_again_with_another_site(
    visit: Callable[..., Visit], repository: Path, tmp_path: Path
) -> None:
    visited = visit()
    page = visited.open("#/new?source=upload")
    site = repository / "examples" / "recordings" / "sample_site.json"
    upload(page, marks_of_its_own(repository, tmp_path, "again.csv", 220), site, "Read twice")
    page.get_by_role("link", name="Open the recording").click()
    again = page.get_by_role("region", name="Read again")
    first = page.url
    again.get_by_label("Site", exact=True).set_input_files(site)
    again.get_by_role("button", name="Read again").click()
    expect(page.locator(".toasts")).to_contain_text("same recording")
    assert page.url == first
    again.get_by_label("Site", exact=True).set_input_files(site_moved(repository, tmp_path))
    again.get_by_role("button", name="Read again").click()
    page.wait_for_url(lambda url: "#/recordings/" in url and url != first)
    expect(page.locator("main h1")).to_have_text("Read twice")
    expect(page.get_by_role("region", name="Site")).to_contain_text("40")
    expect(page.get_by_role("region", name="What was read")).to_contain_text("220")
    visited.assert_clean()


def test_deleting_a_recording_asks_about_its_runs(
    visit: Callable[..., Visit], repository: Path, tmp_path: Path
) -> None:
    visited = visit()
    page = visited.open("#/new?source=upload&a=" + json.dumps({"name": "rdf"}))
    site = repository / "examples" / "recordings" / "sample_site.json"
    upload(page, marks_of_its_own(repository, tmp_path, "doomed.csv", 230), site, "Doomed")
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.locator(".run-head .state")).to_have_text("succeeded")
    run = page.url.split("#")[1]
    page.locator(".run-head").get_by_role("link", name=re.compile("Doomed|Recording")).click()
    # The run bears the recording's name too: only the address says which page this is.
    page.wait_for_url(lambda url: "#/recordings/" in url)
    expect(page.get_by_role("region", name="What was read")).to_be_visible()
    recording = page.url.split("#")[1]

    # No: everything stays.
    page.get_by_role("button", name="Delete", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    question = page.get_by_role("dialog").filter(has_text="Delete the runs of this recording too?")
    expect(question).to_be_visible()
    question.get_by_role("button", name="Keep").click()
    visited.open(f"#{recording}")
    expect(page.locator("main h1")).to_have_text("Doomed")

    # Yes: the runs go with it.
    page.get_by_role("button", name="Delete", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    question.get_by_role("button", name="Delete").click()
    expect(page).to_have_url(re.compile("#/recordings$"))
    expect(page.get_by_role("link", name="sample_marks.csv")).to_be_visible()
    expect(page.get_by_role("link", name="Doomed")).to_have_count(0)
    visited.open(f"#{run}")
    expect(page.locator(".failure")).to_contain_text("run_not_found")
