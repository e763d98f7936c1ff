"""Snippets of the README and the documentation that are marked `<!-- runs -->` do run, against a real server."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.api.conftest import TOKEN, ServerProcess

ROOT = Path(__file__).parents[2]
MARKED = re.compile(r"^<!-- runs -->\n```(sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
SNIPPETS = {
    f"{page.relative_to(ROOT)}-{number}": found.groups()
    for page in PAGES
    for number, found in enumerate(MARKED.finditer(page.read_text(encoding="utf-8")), 1)
}


def test_every_mark_is_recognised() -> None:
    marks = sum(page.read_text(encoding="utf-8").count("<!-- runs -->\n") for page in PAGES)
    assert marks == len(SNIPPETS) >= 2


@pytest.mark.parametrize("name", SNIPPETS)
def test_snippet_runs(server: ServerProcess, name: str) -> None:
    language, text = SNIPPETS[name]
    if language == "sh" and shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    command = [sys.executable, "-c", text] if language == "python" else ["sh", "-euc", text]
    environment = {**os.environ, "FILTERROOM_TOKEN": TOKEN, "FILTERROOM_URL": server.url}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert "rdf" in done.stdout
    assert not done.stderr
