"""A file without columns: what its format lets the user choose, what it would give, and what then is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from tests.asterix_files import turning_radar
from tests.browser.conftest import Visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture
def asterix(tmp_path: Path) -> Path:
    blocks, _ = turning_radar(6)
    path = tmp_path / "radar.ast"
    path.write_bytes(b"".join(blocks)[:-3])
    return path


def test_an_asterix_recording_with_its_scans_cut_by_period(visit: Callable[..., Visit], asterix: Path) -> None:
    page = visit().open("#/new?source=upload")
    page.get_by_label("Marks", exact=True).set_input_files(asterix)
    page.get_by_role("button", name="Map columns").click()
    dialog = page.get_by_role("dialog", name="How the file is read")
    expect(dialog).to_contain_text("Of 48 rows: 47 accepted, 1 rejected.")
    expect(dialog).to_contain_text("told by 6 marks; period 5 s")
    assert Axe().run(page).violations_count == 0
    dialog.get_by_label("Scans", exact=True).select_option("period")
    dialog.get_by_label("Period of a turn, s").fill("10")
    expect(dialog).to_contain_text("equal slices of 10 s")
    dialog.get_by_label("Edition").fill("48:7.7")
    expect(dialog).to_contain_text("There is no edition")
    dialog.get_by_label("Edition").fill("1.29")
    expect(dialog).to_contain_text("CAT 048 1.29")
    dialog.get_by_role("button", name="Use these options").click()
    expect(page.get_by_text("Options of reading are chosen.")).to_be_visible()
    page.get_by_role("button", name="Upload and read").click()
    expect(page.get_by_text("47").first).to_be_visible()


def test_the_dialog_in_russian(visit: Callable[..., Visit], asterix: Path) -> None:
    page = visit(locale="ru-RU").open("#/new?source=upload")
    page.get_by_label("Отметки", exact=True).set_input_files(asterix)
    page.get_by_role("button", name="Назначить столбцы").click()
    dialog = page.get_by_role("dialog", name="Как читать файл")
    expect(dialog).to_contain_text("размечены по меткам (6); период 5 с")
    expect(dialog).to_contain_text("есть только")
