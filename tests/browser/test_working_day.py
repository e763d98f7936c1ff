"""A working day by keyboard alone, in Russian, in the dark: upload, mapping, run, charts, compare, export, delete."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.conftest import Visit
from tests.browser.keyboard import choose, give_file, go_to, press, tab_to
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # a whole flow: CI runs it, the quick suite does not

RUNS = ("утро", "вечер")
COLUMNS = ("Время, мс", "Первый, мкс", "Второй, мкс", "Третий, мкс", "Четвёртый, мкс", "Высота, фут")
# The plots are images to a screen reader; their words are in their labels and tables.
_CONTEXT = {"include": [["html"]], "exclude": [[".plot > *"]]}


@pytest.fixture
def marks(repository: Path, tmp_path: Path) -> Path:
    """The sample as a Russian colleague saves it: other names, other units, semicolons, decimal commas, a bad row."""
    first, *rows = (repository / "examples" / "recordings" / "sample_marks.csv").read_text().splitlines()
    names = first.split(",")
    stations = [name for name in names if name.startswith("toa_")]
    assert len(stations) == 4
    lines = [";".join(COLUMNS)]
    for row in rows[:400]:
        cells = dict(zip(names, row.split(","), strict=True))
        times = [f"{float(cells['time_s']) * 1e3:.3f}"]
        times += [f"{float(cells[name]) / 1e3:.6f}" if cells[name] else "" for name in stations]
        height = f"{float(cells['altitude_m']) / 0.3048:.2f}" if cells["altitude_m"] else ""
        lines.append(";".join([*times, height]).replace(".", ","))
    lines[7] = lines[7].replace(";", ";полдень", 1)
    path = tmp_path / "журнал.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


_NAMES = """() => Promise.all(
  ['runs?limit=500', 'recordings'].map((path) => fetch(`api/v1/${path}`).then((r) => r.json()))
).then(([runs, recordings]) => [...runs.items.flatMap((run) => [run.label, run.source.name, ...run.tags,
      ...run.algorithms.map((one) => one.label ?? one.name)]),
    ...recordings.items.map((one) => one.name)])"""


def look(page: Page) -> None:
    """What stands on the page is Russian, dark and readable; what people called their runs and files is theirs."""
    names = sorted({name for name in page.evaluate(_NAMES) if name}, key=len, reverse=True)
    left = english_left(page, names)
    assert not left, "\n".join(left)
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(14, 17, 19)"
    found = Axe().run(page, context=_CONTEXT).response["violations"]
    assert not found, [(v["id"], [n["target"] for n in v["nodes"]][:3]) for v in found]


def upload(page: Page, marks: Path, site: Path) -> None:
    """Files, what their columns mean, what was read."""
    page.keyboard.press("n")
    press(page, "[data-mode=upload]")
    give_file(page, "[data-role=file]", marks)
    give_file(page, "[data-role=site]", site)
    press(page, "recording-upload form > .row button[type=button]")
    dialog = page.get_by_role("dialog", name="Что означают столбцы")
    choose(page, "#mapping-kind", "моменты прихода")
    clock, *receptions, height = COLUMNS
    choose(page, f"[aria-label='Значение столбца {clock}']", "time_s")
    choose(page, f"[aria-label='Единица столбца {clock}']", "ms")
    for i, column in enumerate(receptions, start=1):
        choose(page, f"[aria-label='Значение столбца {column}']", "toa_")
        tab_to(page, f"[aria-label='Станция столбца {column}']")
        page.keyboard.press("ControlOrMeta+a")
        page.keyboard.type(str(i))
        choose(page, f"[aria-label='Единица столбца {column}']", "us")
    choose(page, f"[aria-label='Значение столбца {height}']", "altitude_m")
    choose(page, f"[aria-label='Единица столбца {height}']", "ft")
    expect(dialog).to_contain_text("принято 399, отклонено 1")
    expect(dialog).to_contain_text("это не число")
    look(page)
    press(page, "dialog .primary")
    expect(page.get_by_text("Назначено 6 столбцов.")).to_be_visible()
    press(page, "recording-upload form .primary")
    report = page.get_by_role("region", name="Источник")
    expect(report.get_by_role("heading", name="журнал.csv")).to_be_visible()
    expect(report).to_contain_text("это не число")


def start(page: Page, name: str) -> None:
    """Name the run and start it; wait until it is done."""
    expect(page.locator(".startbar button.primary")).to_be_enabled()
    tab_to(page, ".startbar .field:first-child input")
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type(name)
    look(page)
    press(page, ".startbar button.primary")
    expect(page.locator(".run-head h1")).to_have_text(name)
    expect(page.locator(".run-head .state")).to_have_text("выполнен")


def read_charts(page: Page) -> None:
    """One instant in all charts, a chart as a table, a decision, the log."""
    page.locator("chart-panel[data-drawn].first").wait_for()
    tab_to(page, "chart-panel .plot")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(page.locator("chart-panel.first .strip")).to_contain_text("Время")
    expect(page.locator("chart-panel.time .overlay line").first).to_be_attached()
    press(page, "button[aria-label='Таблицей: План']")
    expect(page.locator("chart-panel.first .as-table tbody tr").first).to_be_visible()
    look(page)
    page.keyboard.press("Enter")
    tab_to(page, "[role=tab][aria-selected=true]")
    page.keyboard.press("ArrowRight")
    expect(page.locator(":focus")).to_have_text(re.compile("^Решения"))
    press(page, "data-table[data-table=decisions] tbody tr")
    expect(page.locator("data-table[data-table=decisions] tr.current")).to_have_count(1)
    for tab in ("Параметры", "Журнал"):
        tab_to(page, "[role=tab][aria-selected=true]", key="Shift+Tab")
        while page.locator(":focus").inner_text() != tab:
            page.keyboard.press("ArrowRight")
        page.locator("[role=tabpanel] table, [role=tabpanel] pre").first.wait_for()
        look(page)
    expect(page.get_by_role("tabpanel")).to_contain_text("Выполнен.")


def export(page: Page) -> None:
    """A table, the arrays and an image as files."""
    tab_to(page, "[role=tab][aria-selected=true]", key="Shift+Tab")
    page.keyboard.press("End")
    expect(page.locator(":focus")).to_have_text("Выгрузка")
    look(page)
    for wanted, start_of in (("a[href$='tables/metrics.csv']", b"metric,"), ("a[href$='result.npz']", b"PK")):
        tab_to(page, wanted)
        with page.expect_download() as download:
            page.keyboard.press("Enter")
        assert download.value.path().read_bytes().startswith(start_of)
    press(page, "button[aria-label='Действия с графиком: План']")
    tab_to(page, ".menu div:not([hidden]) button:nth-of-type(3)")
    with page.expect_download() as download:
        page.keyboard.press("Enter")
    assert download.value.path().read_bytes().startswith(b"\x89PNG")


def delete(page: Page, selector: str) -> None:
    """Press a button that deletes, and answer the question."""
    press(page, selector)
    expect(page.get_by_role("dialog")).to_be_visible()
    look(page)
    press(page, "dialog .danger")


def test_a_working_day_by_keyboard_in_russian_in_the_dark(
    visit: Callable[..., Visit], marks: Path, repository: Path
) -> None:
    visited = visit(locale="ru-RU", color_scheme="dark")
    # With somebody listening from the start, no dialog for files opens unseen.
    visited.page.on("filechooser", lambda chooser: None)
    page = visited.open("#/runs")
    page.locator("main [data-row-link]").first.wait_for()
    look(page)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Клавиши")).to_be_visible()
    look(page)
    page.keyboard.press("Escape")

    upload(page, marks, repository / "examples" / "recordings" / "sample_site.json")
    for name in ("single_mark", "rdf"):
        press(page, f"[data-add={name}]")
    start(page, RUNS[0])
    read_charts(page)
    export(page)

    # The same with one thing changed.
    press(page, ".run-head a.button")
    expect(page.locator("[data-algorithm]")).to_have_count(2)
    press(page, "[data-add=rdfv]")
    start(page, RUNS[1])

    go_to(page, "r")
    expect(page.locator("main tbody tr", has_text=RUNS[1])).to_be_visible()
    for key in ("j", "x", "j", "x", "c"):
        page.keyboard.press(key)
    expect(page).to_have_url(re.compile(r"#/compare\?run=\w+&run=\w+"))
    page.locator("chart-panel[data-drawn]").first.wait_for()
    expect(page.locator("table.compare").first).to_contain_text(RUNS[0])
    look(page)

    # What is no longer wanted goes: one run from the list, the other together with its recording.
    go_to(page, "r")
    page.locator("main tbody tr", has_text=RUNS[1]).wait_for()
    delete(page, f"button[aria-label='Удалить: {RUNS[1]}']")
    expect(page.locator("main tbody tr", has_text=RUNS[1])).to_have_count(0)
    go_to(page, "d")
    page.locator("main tbody tr", has_text="журнал.csv").wait_for()
    page.keyboard.press("j")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="журнал.csv")).to_be_visible()
    delete(page, ".page-head .danger")
    question = page.get_by_role("dialog", name="Удалить и расчёты")
    expect(question).to_contain_text("Расчётов по этой записи: 1.")
    look(page)
    press(page, "dialog .danger")
    expect(page).to_have_url(re.compile("#/recordings$"))
    expect(page.locator("main tbody tr", has_text="журнал.csv")).to_have_count(0)
    # The browser itself notes the refusal that led to the second question.
    visited.complaints = [text for text in visited.complaints if "409" not in text]
    visited.assert_clean()
