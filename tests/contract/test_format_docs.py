"""docs/formats.md says what the readers do: every code, reader, column, unit and option, and examples that work."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import pytest

from algorithms.recording import KINDS
from algorithms.site import Site
from backend.files.options import ReadOptions
from backend.files.reader import readers_by_name
from backend.files.reading import NamedFile, read_recording
from backend.files.report import Findings
from backend.files.selection import TIME_WORDS
from backend.files.site_source import SensorTable, read_site
from backend.files.units import UNITS

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
# The store and its lock read no formats.
SOURCES = [p for p in sorted((ROOT / "backend" / "files").rglob("*.py")) if p.name not in ("store.py", "lock.py")]
# Which argument of a call is the code.
POSITIONS = {"warn": 0, "Problem": 0, "reject": 1}


def texts(node: ast.expr) -> list[str]:
    return [n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)]


def codes_of(source: str) -> set[str]:
    found: set[str] = {"unsupported_format"}
    for call in (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Call)):
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        for keyword in call.keywords:
            if keyword.arg == "code":
                found.update(texts(keyword.value))
        if name in POSITIONS and len(call.args) > POSITIONS[name]:
            found.update(texts(call.args[POSITIONS[name]]))
    return found


CODES = set().union(*(codes_of(p.read_text(encoding="utf-8")) for p in SOURCES))
DOCUMENTED = set(re.findall(r"^\| `(\w+)` \|", PAGE.split("## Codes")[-1], re.MULTILINE))


def test_codes_are_found_in_the_source():
    assert len(CODES) > 60
    assert {"check_units", "duplicate_row", "null_byte", "pressure_altitude", "missing_value"} <= CODES


def test_every_code_is_documented_and_no_other():
    assert set() == CODES - DOCUMENTED
    assert set() == DOCUMENTED - CODES


def test_codes_are_words_with_underscores():
    assert [c for c in CODES if not re.fullmatch(r"[a-z][a-z0-9_]*", c)] == []


def test_every_code_has_a_test():
    """A code that no test provokes may as well not exist."""
    tests = "".join(p.read_text(encoding="utf-8") for p in (ROOT / "tests" / "unit" / "files").glob("test_*.py"))
    assert [c for c in sorted(CODES) if f'"{c}"' not in tests] == []


@pytest.mark.parametrize("reader", readers_by_name().values(), ids=lambda r: r.name)
def test_every_reader_is_documented(reader):
    assert f"`{reader.name}`" in PAGE
    assert reader.title
    assert set(reader.kinds) <= set(KINDS)


def test_every_kind_unit_and_option_is_documented():
    for word in (*KINDS, *UNITS, *TIME_WORDS, *ReadOptions.model_fields):
        assert f"`{word}`" in PAGE, word


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", blocks("csv"))
def test_examples_in_csv_can_be_read(text, tmp_path):
    if text.startswith("serial"):
        assert isinstance(read_site(text.encode(), Findings()), SensorTable)
        return
    path = tmp_path / "example.csv"
    path.write_text(text, encoding="utf-8")
    if "true_east_m" in text:
        marks = tmp_path / "marks.csv"
        marks.write_text("time_s,toa_A_ns,target\n12.5,1,4B1234\n", encoding="utf-8")
        recording, report = read_recording([NamedFile("marks.csv", marks)], truth=NamedFile("truth.csv", path))
        assert recording.has_truth
    else:
        recording, report = read_recording([NamedFile("example.csv", path)])
        assert len(recording) == len(text.splitlines()) - 1
    assert report.rejections == ()


@pytest.mark.parametrize("text", blocks("json"))
def test_examples_in_json_are_valid(text):
    data = json.loads(text)
    (ReadOptions if "mapping" in data else Site).model_validate(data)
