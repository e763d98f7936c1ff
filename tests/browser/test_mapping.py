"""A CSV with names and units of its own: the dialog suggests, counts, and nothing is used before it is taken."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.conftest import Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # whole flows: CI runs them, the quick suite does not


@pytest.fixture
def foreign_marks(repository: Path, tmp_path: Path) -> Path:
    """The sample with times in ms, receptions in us, altitude in feet, and rows of two days."""
    lines = (repository / "examples" / "recordings" / "sample_marks.csv").read_text().splitlines()
    names = lines[0].split(",")
    stations = [n for n in names if n.startswith("toa_")]
    out = ["Clock (ms);day;" + ";".join(f"RX{i + 1} us" for i in range(len(stations))) + ";Alt ft"]
    for i, line in enumerate(lines[1:101]):
        cells = dict(zip(names, line.split(","), strict=True))
        toas = [f"{float(cells[s]) / 1e3:.6f}" if cells[s] else "" for s in stations]
        altitude = f"{float(cells['altitude_m']) / 0.3048:.2f}" if cells.get("altitude_m") else ""
        out.append(";".join([f"{float(cells['time_s']) * 1e3:.3f}", "monday" if i < 60 else "sunday", *toas, altitude]))
    path = tmp_path / "foreign.csv"
    path.write_text("\n".join(out) + "\n")
    return path


def choose(page: Page, marks: Path, site: Path) -> None:
    page.get_by_label("Marks", exact=True).set_input_files(marks)
    page.get_by_label("Site", exact=True).set_input_files(site)


def test_a_foreign_csv_is_mapped_and_read(visit: Callable[..., Visit], foreign_marks: Path, repository: Path) -> None:
    visited = visit()
    page = visited.open("#/new?source=upload")
    expect(page.get_by_role("button", name="Map columns")).to_be_disabled()
    choose(page, foreign_marks, repository / "examples" / "recordings" / "sample_site.json")

    page.get_by_role("button", name="Map columns").click()
    dialog = page.get_by_role("dialog", name="What the columns mean")
    # Receptions and altitude are told from their names with their units; "Clock" is not.
    expect(dialog.get_by_label("What was measured")).to_be_visible()
    dialog.get_by_label("What was measured").select_option("toa_marks")
    dialog.get_by_label("Meaning of Clock (ms)").select_option("time_s")
    dialog.get_by_label("Unit of Clock (ms)").select_option("ms")
    for i in range(1, 5):
        dialog.get_by_label(f"Meaning of RX{i} us").select_option("toa_<station>_ns")
        dialog.get_by_label(f"Station of RX{i} us").fill(str(i))
        dialog.get_by_label(f"Unit of RX{i} us").select_option("us")
    dialog.get_by_label("Meaning of Alt ft").select_option("altitude_m")
    dialog.get_by_label("Unit of Alt ft").select_option("ft")
    expect(dialog).to_contain_text("Of 100 rows: 100 accepted, 0 rejected.")

    # A row filter; two columns that mean the same.
    dialog.get_by_role("button", name="Read only some rows").click()
    dialog.get_by_label("Column of the row filter").select_option("day")
    dialog.get_by_label("Value of the row filter").fill("monday")
    expect(dialog).to_contain_text("Of 60 rows: 60 accepted, 0 rejected.")
    dialog.get_by_label("Station of RX2 us").fill("1")
    expect(dialog).to_contain_text("Two columns mean the same: toa_1_ns")
    expect(dialog.get_by_role("button", name="Use this mapping")).to_be_disabled()
    dialog.get_by_label("Station of RX2 us").fill("2")
    expect(dialog).to_contain_text("Of 60 rows")
    dialog.get_by_text("First 20 rows").click()
    expect(dialog.get_by_role("region", name="First 20 rows").locator("tbody tr")).to_have_count(20)
    found = Axe().run(page).response["violations"]
    assert not [v for v in found if v["impact"] in ("serious", "critical")], found
    dialog.get_by_role("button", name="Use this mapping").click()

    expect(page.get_by_text("6 columns are mapped.")).to_be_visible()
    page.get_by_label("Name").fill("Mapped")
    page.get_by_role("button", name="Upload and read").click()
    report = page.get_by_role("region", name="Source")
    expect(report.get_by_role("heading", name="Mapped")).to_be_visible()
    tiles = dict(
        zip(report.locator(".tiles dt").all_inner_texts(), report.locator(".tiles dd").all_inner_texts(), strict=True)
    )
    assert (tiles["Rows read"], tiles["Accepted"]) == ("60", "60")
    visited.assert_clean()


def test_what_is_refused_for_its_columns_points_to_the_mapping(visit: Callable[..., Visit], tmp_path: Path) -> None:
    page = visit().open("#/new?source=upload")
    radar = tmp_path / "radar.csv"
    radar.write_text("ToD (ms),Rho [NM],Theta\n" + "".join(f"{1000 * i},{20 + i},{30 * i}\n" for i in range(12)))
    page.get_by_label("Marks", exact=True).set_input_files(radar)
    page.get_by_role("button", name="Upload and read").click()
    expect(page.get_by_text("tells the reader which is which")).to_be_visible()
    page.get_by_role("button", name="Map columns").click()
    dialog = page.get_by_role("dialog", name="What the columns mean")
    expect(dialog.get_by_label("What was measured")).to_have_value("polar_plots")
    expect(dialog.get_by_label("Unit of Rho [NM]")).to_have_value("NM")
    expect(dialog).to_contain_text("Of 12 rows: 12 accepted, 0 rejected.")
    dialog.get_by_label("Meaning of Theta").select_option("")
    expect(dialog.get_by_role("alert")).to_contain_text("azimuth_deg")
    # Nothing of it is used after Escape.
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    expect(page.get_by_text("mapped")).to_have_count(0)


def test_in_russian_and_by_keyboard(visit: Callable[..., Visit], tmp_path: Path) -> None:
    visited = visit()
    page = visited.open("#/new?source=upload")
    page.evaluate("localStorage.setItem('filterroom.language', 'ru')")
    page.reload()
    radar = tmp_path / "радар.csv"
    radar.write_text("время;дальность;азимут\n1;2;3\n", encoding="utf-8")
    page.locator("input[type=file][data-role=file]").set_input_files(radar)
    page.get_by_role("button", name="Назначить столбцы").focus()
    page.keyboard.press("Enter")
    dialog = page.get_by_role("dialog", name="Что означают столбцы")
    dialog.get_by_label("Что измерено").select_option("polar_plots")
    for column, means in (("время", "time_s"), ("дальность", "range_m"), ("азимут", "azimuth_deg")):
        dialog.get_by_label(f"Значение столбца {column}").select_option(means)
    expect(dialog).to_contain_text(re.compile("Из 1 строки: принято 1"))
    dialog.get_by_role("button", name="Применить назначение").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_text("Назначено 3 столбца.")).to_be_visible()
    visited.assert_clean()
