"""Files as people have them: recorded tracks to fly again or as truth, several files as one recording."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.charts import drawn
from tests.browser.conftest import Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture
def tracks(tmp_path: Path) -> Path:
    """OpenARIA: two aircraft fly north and east, one of them longer; feet; a line that is none."""
    path = tmp_path / "tracks.csv"
    lines = [
        f",,2026-05-01T10:{i // 12:02d}:{5 * i % 60:02d}.250Z,{name},{55 + i * north:.5f},{37 + i * east:.5f},10000,"
        for name, north, east, count in (("ABC1", 0.01, 0.0, 12), ("XYZ2", 0.0, 0.02, 20))
        for i in range(count)
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def tiles(page: Page) -> dict[str, str]:
    report: Locator = page.get_by_role("region", name="Source")
    report.locator(".tiles dt").first.wait_for()
    return dict(
        zip(report.locator(".tiles dt").all_inner_texts(), report.locator(".tiles dd").all_inner_texts(), strict=True)
    )


def test_recorded_tracks_are_read_through_their_form_and_flown_again(visit: Callable[..., Visit], tracks: Path) -> None:
    visited = visit()
    page = visited.open("#/scenarios")
    page.locator("scenario-preview[data-fresh=yes]").wait_for()
    page.get_by_text("Targets from recorded tracks").click()
    expect(page.get_by_role("button", name="Read tracks")).to_be_disabled()
    page.get_by_label("File of tracks").set_input_files(tracks)
    page.get_by_label("How many of the longest tracks").fill("1")
    page.get_by_role("button", name="Read tracks").click()
    expect(page.get_by_text("1 of 2 tracks are targets now.")).to_be_visible()
    page.locator("scenario-preview[data-fresh=yes]").wait_for()

    # The other one by its name; one that is not there is said.
    page.get_by_label("Or these, by name").fill("ABC1; XYZ2")
    page.get_by_role("button", name="Read tracks").click()
    expect(page.get_by_text("2 of 2 tracks are targets now.")).to_be_visible()
    page.locator("scenario-preview[data-fresh=yes]").wait_for()
    truth = [trace for trace in drawn(page, "Plan")["traces"] if trace["role"] == "truth"]
    assert truth
    page.get_by_label("Or these, by name").fill("NOBODY")
    page.get_by_role("button", name="Read tracks").click()
    expect(page.locator("details", has_text="Targets from recorded tracks")).to_contain_text("NOBODY")

    page.get_by_role("button", name="Store as recording").click()
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    visited.settle()
    expect(page.get_by_text("ABC1").first).to_be_visible()


def test_recorded_tracks_are_the_truth_of_plots(visit: Callable[..., Visit], tracks: Path, tmp_path: Path) -> None:
    plots, site = tmp_path / "plots.csv", tmp_path / "radar.json"
    rows = "".join(f"2026-05-01T10:00:{5 * i:02d}.250Z,{1113 * i},0,ABC1\n" for i in range(1, 12))
    plots.write_text("time_s,range_m,azimuth_deg,target\n" + rows)
    site.write_text(
        '{"origin": {"latitude_deg": 55, "longitude_deg": 37, "height_m": 0}, "radars": [{"name": "R", "east_m": 0, '
        '"north_m": 0, "sigma_range_m": 50, "sigma_azimuth_deg": 0.1}]}'
    )
    page = visit().open("#/new?source=upload")
    page.get_by_label("Marks", exact=True).set_input_files(plots)
    page.get_by_label("Site", exact=True).set_input_files(site)
    page.get_by_label("Truth", exact=True).set_input_files(tracks)
    page.get_by_role("button", name="Upload and read").click()
    assert tiles(page)["Truth"] == "known"


def test_several_files_are_one_recording(visit: Callable[..., Visit], repository: Path, tmp_path: Path) -> None:
    sample = repository / "examples" / "recordings"
    head, *rows = (sample / "sample_marks.csv").read_text().splitlines()
    first, second = tmp_path / "morning.csv", tmp_path / "noon.csv"
    # They overlap by ten rows, which are the same.
    first.write_text("\n".join([head, *rows[:60]]) + "\n")
    second.write_text("\n".join([head, *rows[50:100]]) + "\n")
    visited = visit()
    page = visited.open("#/new?source=upload")
    page.get_by_label("Marks", exact=True).set_input_files([second, first])
    expect(page.get_by_text("morning.csv").first).to_be_visible()
    page.get_by_label("Site", exact=True).set_input_files(sample / "sample_site.json")
    page.get_by_label("Name").fill("A whole day")
    page.get_by_role("button", name="Upload and read").click()
    found = tiles(page)
    assert (found["Rows read"], found["Accepted"], found["Rejected"]) == ("110", "100", "10")
    rejected = page.get_by_role("region", name="Source")
    expect(rejected).to_contain_text("repeats")
    expect(rejected).to_contain_text(re.compile(r"(noon|morning)\.csv"))
    visited.assert_clean()
