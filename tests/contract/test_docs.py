"""What is registered is documented: here algorithms with their parameters, statuses and reasons, settings, commands.

Elsewhere charts (`test_charts.py`), formats and their codes (`test_format_docs.py`), paths (`test_api_docs.py`), and
the page of every error code (`tests/api/test_service.py`).
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.references import REFERENCES
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import Algorithm, LocalContext
from backend.cli import _parser
from backend.settings import Settings
from tests.papers.test_multilateration_table_8_1 import INSTANTS, ONE_MARK, ONE_MARK_KNOWN, TABLE

ROOT = Path(__file__).parents[2]
VECTORS = (("", "m"), ("velocity_", "mps"), ("acceleration_", "mps2"))

each_algorithm = pytest.mark.parametrize("algorithm", algorithms_by_name().values(), ids=lambda a: a.name)


def methods_page(algorithm: Algorithm) -> str:
    """Return the text of the family's page."""
    return (ROOT / "docs" / "methods" / f"{algorithm.family}.md").read_text(encoding="utf-8")


def first_cells(page: str) -> set[str]:
    """Return what the tables of a page begin their rows with, without code marks."""
    return {cell.strip().strip("`") for cell in re.findall(r"^\| ([^|]+) \|", page, re.MULTILINE)}


@each_algorithm
def test_an_algorithm_stands_in_a_heading_of_its_family(algorithm: Algorithm) -> None:
    assert re.search(rf"^#+ .*`{algorithm.name}`", methods_page(algorithm), re.MULTILINE)


@each_algorithm
def test_every_parameter_and_choice_is_documented(algorithm: Algorithm) -> None:
    page = methods_page(algorithm)
    properties: dict[str, Any] = algorithm.parameters.schema_for_forms()["properties"]
    assert not set(properties) - first_cells(page)
    words = {str(word) for field in properties.values() for word in field.get("choices", {})}
    assert not {word for word in words if f"`{word}`" not in page}


@each_algorithm
def test_every_status_and_reason_is_documented(algorithm: Algorithm) -> None:
    categories = {text for output in algorithm.outputs for text in output.categories if text}
    assert categories
    assert not categories - first_cells(methods_page(algorithm))


@each_algorithm
def test_every_reference_stands_in_full(algorithm: Algorithm) -> None:
    page = methods_page(algorithm)
    assert not [r.key for r in algorithm.references if REFERENCES[r.key].rstrip(".") not in page]


@pytest.mark.parametrize("name", Settings.model_fields)
def test_the_table_of_settings_has_each_with_its_default(name: str) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    table = readme.split("## Settings")[1].split("\n## ")[0]
    cells = [[cell.strip(" `") for cell in row.strip("|").split("|")] for row in table.splitlines() if row[:1] == "|"]
    rows = [row for row in cells if f"FILTERROOM_{name.upper()}" in re.findall(r"\w+", row[0])]
    assert len(rows) == 1
    _, written, meaning = rows[0]
    assert len(meaning) > 10
    default = Settings.model_fields[name].default
    if isinstance(default, bool | int | float) or (isinstance(default, str) and default):
        assert written == str(default).lower()


def test_the_documented_part_of_table_8_1_is_the_tested_one() -> None:
    page = (ROOT / "docs" / "methods" / "multilateration.md").read_text(encoding="utf-8")
    columns = (TABLE[None], TABLE[300.0], TABLE[100.0], TABLE[10.0], ONE_MARK, ONE_MARK_KNOWN)
    for instant in (50, 400, 620, 1899):
        row = re.search(rf"^\| {instant} \| \d+ \| (.+) \|$", page, re.MULTILINE)
        assert row is not None
        at = INSTANTS.index(instant)
        assert [float(cell) for cell in row[1].split("|")] == [column[at] for column in columns]


def test_every_command_and_option_is_documented() -> None:
    guide = (ROOT / "docs" / "user-guide.md").read_text(encoding="utf-8")
    table = guide.split("## Command line")[1]
    documented = set(re.findall(r"^\| `filterroom ([a-z]+)` \|", table, re.MULTILINE))
    assert not set(commands()) - documented
    options = {word for parser in commands().values() for word in parser._option_string_actions if word[:2] == "--"}
    assert {"--host", "--data"} <= options
    assert not {word for word in options - {"--help"} if f"`{word}`" not in table}


def commands() -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of the subcommands by name."""
    actions = [a for a in _parser()._actions if isinstance(a, argparse._SubParsersAction)]
    assert len(actions) == 1
    return dict(actions[0].choices)


def test_pictures_are_small_and_shown() -> None:
    guide = (ROOT / "docs" / "user-guide.md").read_text(encoding="utf-8")
    pictures = {path.name: path.stat().st_size for path in (ROOT / "docs" / "pictures").iterdir()}
    assert set(pictures) == set(re.findall(r"\(pictures/([\w.]+)\)", guide))
    assert max(pictures.values()) < 120_000


@each_algorithm
def test_every_table_and_column_is_documented(algorithm: Algorithm) -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| [^|]+ \| (.+) \|$", page.split("### Tables")[1], re.MULTILINE)
    documented = {name: set(re.findall(r"`(\w+)`", columns)) for name, columns in rows}
    # States have nine columns in three words: position, velocity, acceleration.
    documented["states"] |= {f"{p}{axis}_{u}" for p, u in VECTORS for axis in ("east", "north", "up")}
    ours = (s for s in scenarios_by_name().values() if s.kind in algorithm.takes and s.family == algorithm.family)
    for scenario in ours:
        recording = scenario.simulate(scenario.parameters(), (0,), 1)
        recording = recording.take(np.arange(min(20, len(recording))))
        result = algorithm.run(recording, algorithm.parameters(), LocalContext())
        for name, table in algorithm.tabulate(recording, result).items():
            assert not set(table.columns) - documented[name], name
