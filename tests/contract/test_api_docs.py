"""The page about the API names every address that the server has, and no other."""

from __future__ import annotations

import re
from pathlib import Path

from backend.app import api_description

PAGE = Path(__file__).parents[2] / "docs" / "api.md"
# A row for one form of a chart or a table names the others behind it.
OTHER_FORMS = re.compile(r"/(charts/\{chart\}|tables/\{table\})\.(csv|html)$")


def test_every_operation_has_its_place() -> None:
    page = PAGE.read_text(encoding="utf-8")
    operations = {
        f"{method.upper()} {path}"
        for path, methods in api_description()["paths"].items()
        for method in methods
        if not OTHER_FORMS.search(path)
    }
    written = set(re.findall(r"`((?:GET|POST|PATCH|DELETE) /[^`?\s]*)`", page))
    assert operations == written
