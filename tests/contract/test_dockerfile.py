"""The Dockerfile stays in step with the wheel, the settings and its own list of what is sent to the engine."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from backend.settings import Settings

ROOT = Path(__file__).parents[2]
DOCKERFILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")
COPIED = {
    source for words in re.findall(r"^COPY (?!--from)(.+)$", DOCKERFILE, re.MULTILINE) for source in words.split()[:-1]
}


def test_what_the_wheel_is_made_of_is_copied() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = set(project["tool"]["hatch"]["build"]["targets"]["wheel"]["only-include"])
    files = {"pyproject.toml", project["project"]["readme"], *project["project"]["license-files"]}
    assert folders | files == COPIED


def test_what_is_copied_is_sent_to_the_engine() -> None:
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    assert {line[1:] for line in lines if line.startswith("!")} == COPIED
    assert "*" in lines


def test_its_settings_exist() -> None:
    named = set(re.findall(r"\bFILTERROOM_([A-Z_]+)=", DOCKERFILE))
    assert {"HOST", "DATA_DIR", "KERNEL_CACHE"} <= named
    assert {name.lower() for name in named} <= set(Settings.model_fields)


def test_no_token_is_baked_in_and_root_is_left() -> None:
    steps = [line for line in DOCKERFILE.splitlines() if not line.startswith("#")]
    assert not [line for line in steps if "TOKEN" in line]
    users = [line for line in steps if line.startswith("USER ")]
    assert users == ["USER filterroom"]
    assert not [line for line in steps if line.startswith("FROM ") and "/" in line]
