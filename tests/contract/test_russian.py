"""Whatever the server says in English and the page shows has Russian words in frontend/i18n."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import TypeAdapter, ValidationError

from algorithms.multilateration import lanes
from algorithms.registry import algorithms_by_name, scenarios_by_name, studies_by_name
from algorithms.spec import Algorithm, Scenario
from algorithms.studies import Study
from backend.api.charts import TRIAL_CHARTS
from backend.api.samples import SAMPLES
from backend.charts.catalogue import charts
from backend.charts.figure import REASONS
from backend.charts.view import ChartOptions
from backend.http.problem_codes import PROBLEMS
from backend.http.problems import items_of
from tests import chart_views
from tests.contract.server_sentences import sentences

ENTRY = re.compile(r'^ {2}("(?:[^"\\]|\\.)*"): ("(?:[^"\\]|\\.)*"),$', re.M)
PATTERN = re.compile(r"^ {2}\[/(.+)/, \"", re.M)
FAMILIES = ("multilateration", "forward_scatter", "identification", "multiple_model", "plot_tracking")


@pytest.fixture(scope="module")
def russian(repository: Path) -> dict[str, str]:
    """Texts by key: the codes, and the server's English sentences."""
    text = "".join(path.read_text("utf-8") for path in sorted((repository / "frontend" / "i18n").glob("ru*.js")))
    return {json.loads(key): json.loads(value) for key, value in ENTRY.findall(text)}


@pytest.fixture(scope="module")
def patterns(repository: Path) -> list[re.Pattern[str]]:
    """Sentences with numbers in them."""
    text = "".join(path.read_text("utf-8") for path in sorted((repository / "frontend" / "i18n").glob("ru-*.js")))
    return [re.compile(one) for one in PATTERN.findall(text)]


def _plain(text: str) -> str:
    return " ".join(text.split())


def _texts_of(algorithm: Algorithm) -> list[str]:
    texts = [algorithm.title, algorithm.summary, *(output.meaning for output in algorithm.outputs if output.meaning)]
    for schema in algorithm.parameters.model_json_schema()["properties"].values():
        texts += [schema.get("title", ""), schema.get("description", ""), *schema.get("choices", {}).values()]
    return [_plain(text) for text in texts if text]


@pytest.mark.parametrize(
    "algorithm", [a for a in algorithms_by_name().values() if a.family in FAMILIES], ids=lambda a: a.name
)
def test_algorithms_and_their_parameters(algorithm: Algorithm, russian: dict[str, str]) -> None:
    assert [text for text in _texts_of(algorithm) if text not in russian] == []


@pytest.mark.parametrize("study", studies_by_name().values(), ids=lambda s: s.name)
def test_studies_and_what_they_claim(study: Study, russian: dict[str, str]) -> None:
    texts = [study.title, study.summary, study.item]
    texts += [text for claim in study.claims for text in (claim.claim, claim.paper)]
    texts += [claim.figure for claim in study.claims if re.search("[a-z]", claim.figure)]
    assert [text for text in map(_plain, texts) if text and text not in russian] == []


def test_samples(russian: dict[str, str]) -> None:
    assert [sample.label for sample in SAMPLES if sample.label not in russian] == []


def test_groups_of_parameters(russian: dict[str, str]) -> None:
    groups = {
        schema["group"]
        for algorithm in algorithms_by_name().values()
        for schema in algorithm.parameters.model_json_schema()["properties"].values()
        if "group" in schema
    }
    assert [name for name in sorted(groups) if f"group.{name}" not in russian] == []


@pytest.mark.parametrize("language", ["en", "ru"])
def test_families_and_what_they_measure(language: str, repository: Path) -> None:
    """Pages name them by code, and where a name is missing the code itself would stand there."""
    text = (repository / "frontend" / "i18n" / f"{language}.js").read_text("utf-8")
    found = [*algorithms_by_name().values(), *scenarios_by_name().values()]
    kinds = {kind for one in found for kind in ([one.kind] if isinstance(one, Scenario) else one.takes)}
    codes = [f"family.{one.family}" for one in found]
    codes += [f"{name}.{kind}" for kind in kinds for name in ("kind", "rows")]
    assert [code for code in codes if f'\n  "{code}": ' not in text] == []


def test_decisions_and_reasons(russian: dict[str, str]) -> None:
    assert [code for code in lanes.STATUS if f"decision.{code}" not in russian] == []
    assert [reason for reason in lanes.REASONS if reason and reason not in russian] == []


def test_titles_of_charts(russian: dict[str, str]) -> None:
    declared = [chart for source in ("run", "recording") for chart in charts(source).values()]
    assert [c.name for c in declared if f"chart.{c.name}" not in russian and c.title not in russian] == []


def test_why_charts_are_empty(russian: dict[str, str]) -> None:
    missing = [code for code, text in REASONS.items() if f"chart.reason.{code}" not in russian and text not in russian]
    assert missing == []


def test_notes_of_charts_over_trials(russian: dict[str, str], patterns: list[re.Pattern[str]]) -> None:
    drawn = [
        chart.draw(chart_views.run(chart_views.marks(), *[chart_views.trial_tables()] * 2), ChartOptions())
        for name, chart in charts("run").items()
        if name in TRIAL_CHARTS
    ]
    notes = [note["text"] for figure in drawn for note in figure["layout"]["meta"]["notes"]]
    assert len(notes) >= 4
    assert [n for n in notes if n not in russian and not any(p.search(n) for p in patterns)] == []


def test_axes_of_charts(russian: dict[str, str], patterns: list[re.Pattern[str]], repository: Path) -> None:
    source = "".join(path.read_text("utf-8") for path in (repository / "backend" / "charts").rglob("*.py"))
    titles = re.findall(r'(?:axis\(\s*f?|\["title"\]\["text"\] = )"([^"{]+)"', source)
    assert len(titles) >= 4
    missing = [t for t in titles if t not in russian and not any(p.search(t) for p in patterns)]
    assert missing == []


def test_codes_of_problems(russian: dict[str, str]) -> None:
    assert [code for code in PROBLEMS if f"problem.{code}" not in russian] == []


def test_codes_of_rejections_and_warnings(russian: dict[str, str], repository: Path) -> None:
    """Their list in docs/formats.md is held complete by a test of its own."""
    text = (repository / "docs" / "formats.md").read_text("utf-8")
    sections = {
        "rejection": text.split("### Rejected rows")[1].split("\n### ")[0],
        "warning": text.split("### Warnings")[1].split("\n### ")[0],
    }
    for kind, section in sections.items():
        codes = re.findall(r"^\| `(\w+)` \|", section, re.M)
        assert len(codes) > 10
        assert [code for code in codes if f"{kind}.{code}" not in russian] == [], kind


def test_sentences_of_answers_logs_and_reports(russian: dict[str, str], repository: Path) -> None:
    """Every sentence of the sources, and every place in it that is filled in."""
    said = sentences(repository)
    assert len(said) > 200
    assert {text: file for text, file in said.items() if text not in russian} == {}
    places = re.compile(r"\{\d+\}")
    invented = [text for text in said if not set(places.findall(russian[text])) <= set(places.findall(text))]
    assert invented == []


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (Annotated[float, Gt(0)], -1),
        (Annotated[float, Ge(0)], -1),
        (Annotated[float, Lt(0)], 1),
        (Annotated[float, Le(0)], 1),
        (float, "tall"),
        (float, None),
        (int, 1.5),
        (int, "tall"),
        (bool, []),
        (str, 1),
        (list[int], 1),
        (dict[str, int], 1),
        (Literal["white", "paper"], "red"),
        (Annotated[str, MinLen(2)], ""),
        (Annotated[str, MaxLen(2)], "abc"),
        (Annotated[list[int], MinLen(2)], []),
        (Annotated[list[int], MaxLen(2)], [1, 2, 3]),
    ],
    ids=str,
)
def test_refusals_of_single_values(kind: Any, value: object, russian: dict[str, str]) -> None:
    """As pydantic words them."""
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(kind).validate_python(value)
    (item,) = items_of(caught.value)
    templates = [re.escape(t).replace(r"\{", "{").replace(r"\}", "}") for t in russian if t.endswith(".")]
    known = [t for t in templates if re.fullmatch(re.sub(r"\{\d+\}", "(.+?)", t), item.detail)]
    assert known, item.detail
