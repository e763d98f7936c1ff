"""The server puts its reports and pages into the words of the page, by the page's rules."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from backend.charts.catalogue import charts
from backend.charts.figure_words import axis_title, figure_in
from backend.charts.language import Words, words_of
from backend.charts.report import ReportContent, ReportEntry, ReportMetric, report_page
from backend.charts.view import ChartOptions
from tests import chart_views


@pytest.fixture(scope="module")
def russian() -> Words:
    return words_of("ru")


def test_the_same_words_as_in_the_page(russian: Words, repository: Path) -> None:
    """The list is checked against the page's own code in tests/frontend."""
    pairs = json.loads((repository / "tests" / "frontend" / "said-in-russian.json").read_text("utf-8"))
    assert {english: russian.said(english) for english in pairs} == pairs


def test_no_text_of_the_files_is_missed(russian: Words, repository: Path) -> None:
    lines = [
        line
        for path in (repository / "frontend" / "i18n").glob("ru*.js")
        for line in path.read_text("utf-8").splitlines()
    ]
    texts = {json.loads(found[1]) for line in lines if (found := re.match(r'^\s*("[^"]*(?:\\"[^"]*)*"): "', line))}
    patterns = [line for line in lines if line.lstrip().startswith("[/^")]
    known = {*russian.keys, *russian.words}
    # A few stand among the single words and among the sentences.
    assert 0 <= len(russian.templates) - len(texts - known) < 5
    assert len(texts) > 2000
    assert len(patterns) == len(russian.patterns) > 40


def test_metrics_of_models_have_the_model_s_name(russian: Words) -> None:
    assert russian.metric("mode_probability_cv_0.5") == "Средняя вероятность модели cv_0.5"
    assert russian.metric("rms_horizontal_m") == "Плановая ошибка, СКО"
    assert words_of("en").metric("mode_probability_cv_0.5") == "mode_probability_cv_0.5"


def test_english_stays(russian: Words) -> None:
    english = words_of("en")
    assert english.said("Horizontal error, m") == "Horizontal error, m"
    assert english.told("metric.rms_horizontal_m", "rms_horizontal_m") == "rms_horizontal_m"
    drawn: dict[str, Any] = {"data": [], "layout": {}}
    assert figure_in(drawn, english, "plan") is drawn


def test_axes_with_units(russian: Words) -> None:
    assert axis_title("Horizontal error, m", russian) == "Плановая ошибка, м"
    assert axis_title("nothing known, km", russian) == "nothing known, км"


def test_a_figure_keeps_names_and_numbers(russian: Words) -> None:
    meta = {"role": "series", "label": "row", "index": 0}
    trace = {
        "type": "scatter", "name": "row, claimed", "x": np.arange(3.0), "y": np.arange(3.0), "meta": meta,
        "hovertemplate": "<b>row, claimed</b><br>%{hovertext}<br>%{x:.3f} s, row %{customdata}<extra></extra>",
        "hovertext": ["target row", "updated, target A", "sum of row"],
    }  # fmt: skip
    about = {"notes": [], "start_utc": None}
    heading = {"text": "A title", "subtitle": {"text": "3 of 9 points drawn"}}
    drawn = {"data": [trace], "layout": {"title": heading, "meta": about, "xaxis": {"title": {"text": "Time, s"}}}}
    before = json.dumps(drawn, default=list)
    put = figure_in(drawn, russian, "drms")
    assert json.dumps(drawn, default=list) == before, "the given figure is not touched"
    assert put["layout"]["title"]["text"] == russian.keys["chart.drms"] != "A title"
    assert put["layout"]["title"]["subtitle"]["text"] == "показано точек: 3 из 9"
    assert put["layout"]["xaxis"]["title"]["text"] == "Время, с"
    (one,) = put["data"]
    assert one["name"] == "row, заявленная"
    assert one["x"] is trace["x"]
    assert one["hovertemplate"] == (
        "<b>row, заявленная</b><br>%{hovertext}<br>%{x:.3f} с, строка %{customdata}<extra></extra>"
    )
    assert one["hovertext"] == ["цель row", "использована, цель A", "sum of row"]


def test_a_symbol_is_no_word(russian: Words) -> None:
    trace = {"name": "rdfv, h", "meta": {"role": "series", "label": "rdfv", "index": 0}}
    drawn = {"data": [trace], "layout": {"title": {"text": "x"}, "meta": {"notes": []}}}
    assert figure_in(drawn, russian, "height")["data"][0]["name"] == "rdfv, h"


def test_a_report_in_russian_has_no_english_words_of_its_own(russian: Words) -> None:
    view = chart_views.run(chart_views.marks(), *[chart_views.trial_tables()] * 2)
    figures = [
        figure_in(charts("run")[name].draw(view, ChartOptions()), russian, name) for name in ("plan", "trials_lost")
    ]
    content = ReportContent(
        title="Run 7", facts=[("Seed", "7"), ("Algorithms", "a (rdf)")],
        recording=[("Rows", "9 read, 8 accepted, 1 rejected"), ("Truth", "not known"), ("Site", "4 stations")],
        warnings=[], entries=[ReportEntry("a", "rdf", "", [("smooth", "12.5", "run")], [])],
        metrics=[ReportMetric("rms_horizontal_m", "a", "", 12.3, (11.0, 13.0), "m", 9)], figures=figures,
        decisions=[("a", "updated", "", 8)], references=[], software={"numpy": "2"}, left_out=[],
    )  # fmt: skip
    page = report_page(content, russian).decode()
    assert '<html lang="ru">' in page
    own = re.sub(r"<(script|style|code).*?</\1>", "", page, flags=re.DOTALL)
    words = set(re.findall(r"[A-Za-z]{2,}", re.sub(r"<[^>]*>|&\w+;", " ", own)))
    assert words <= {"rdf", "numpy"}, words
    for word in (
        "Расчёт 7",
        "Плановая ошибка, СКО",
        "прочитано 9, принято 8, отклонено 1",
        "использована",
        "пунктов: 4",
    ):
        assert word in own, word
