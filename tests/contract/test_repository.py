"""What must hold for the repository itself: nothing private in it, and no promise that it does not keep."""

from __future__ import annotations

import re
import subprocess
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from backend.settings import Settings

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")])

# Written in pieces, so that this file does not find itself.
REGISTRIES = [
    "pypi" + ".org",
    "pythonhosted" + ".org",
    "npmjs" + ".org",
    "npmjs" + ".com",
    "deb.debian" + ".org",
    "index" + "-url",
    "registry" + "=",
]
MACHINE_PATHS = [re.compile(r"(?<![\w.])/(?:work|root|home/\w+)/"), re.compile(r"[A-Z]:\\Users\\")]
BINARY = {".png", ".parquet", ".npz", ".mat", ".gz", ".ico", ".woff2"}


def tracked_texts() -> dict[str, str]:
    """Every text file that git would publish, by its path."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    paths = [name for name in listed.split("\0") if name and Path(name).suffix not in BINARY]
    return {n: (ROOT / n).read_text(encoding="utf-8", errors="replace") for n in paths if (ROOT / n).is_file()}


@pytest.fixture(scope="module")
def texts() -> dict[str, str]:
    if not (ROOT / ".git").exists():
        pytest.skip("not a git checkout, so what is published is unknown")
    return tracked_texts()


def test_no_registry_host_is_published(texts: dict[str, str]) -> None:
    found = [f"{name}: {host}" for name, text in texts.items() for host in REGISTRIES if host in text]
    assert not found


def test_no_machine_path_is_published(texts: dict[str, str]) -> None:
    found = [
        f"{name}:{number}: {line.strip()}"
        for name, text in texts.items()
        for number, line in enumerate(text.splitlines(), 1)
        if any(path.search(line) for path in MACHINE_PATHS)
    ]
    assert not found


def test_the_lock_with_hosts_is_ignored() -> None:
    private = ["uv.lock", ".tools/x", ".venv/x"]
    asked = subprocess.run(["git", "check-ignore", *private], cwd=ROOT, check=False, capture_output=True, text=True)
    assert asked.stdout.split() == private


def test_changelog_mentions_the_version() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{version}]" in changelog


@pytest.mark.parametrize("field", Settings.model_fields)
def test_setting_is_documented(field: str) -> None:
    variable = f"`FILTERROOM_{field.upper()}`"
    assert any(variable in page.read_text(encoding="utf-8") for page in PAGES), f"{variable} stands in no page"


def test_documented_settings_exist() -> None:
    known = {f"FILTERROOM_{field.upper()}" for field in Settings.model_fields}
    written = {name for page in PAGES for name in re.findall(r"`(FILTERROOM_[A-Z_]+)", page.read_text("utf-8"))}
    assert written <= known


def test_scripts_of_the_readme_exist() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    named = set(re.findall(r"(?:scripts|examples|\.ci)/[\w./-]*\w", readme))
    assert {"scripts/start", "scripts/test", "examples/run_marks.py", "examples/run_marks.sh"} <= named
    assert not [name for name in named if not (ROOT / name).exists()]


def anchors(page: Path) -> set[str]:
    """Return the anchors that a page's headings make, as the usual renderers form them."""
    headings = re.findall(r"^#+ +(.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_resolve(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        other = (page.parent / name).resolve() if name else page
        if not other.exists() or (anchor and anchor not in anchors(other)):
            broken.append(target)
    assert not broken


def test_every_page_of_docs_is_reachable_from_the_index() -> None:
    seen, waiting = set(), [ROOT / "docs" / "index.md"]
    while waiting:
        page = waiting.pop()
        if page in seen:
            continue
        seen.add(page)
        links = re.findall(r"\]\(([^)#\s]+\.md)", page.read_text(encoding="utf-8"))
        waiting += [p for p in ((page.parent / link).resolve() for link in links) if p.exists()]
    assert not set(ROOT.glob("docs/**/*.md")) - seen


def dictionary_keys(language: str) -> list[str]:
    text = (ROOT / "frontend" / "i18n" / f"{language}.js").read_text(encoding="utf-8")
    return re.findall(r"""^\s*["']?([\w.\-]+)["']?\s*:""", text, re.MULTILINE)


def test_dictionaries_have_the_same_keys() -> None:
    english, russian = dictionary_keys("en"), dictionary_keys("ru")
    assert len(english) > 50
    assert len(set(english)) == len(english)
    assert len(set(russian)) == len(russian)
    assert set(english) == set(russian)


def runtime_packages() -> dict[str, str]:
    """Return name and licence of every distribution that an installation of filterroom brings."""
    licences: dict[str, str] = {}
    waiting = ["filterroom"]
    while waiting:
        name = waiting.pop()
        if name in licences:
            continue
        try:
            found = distribution(name)
        except PackageNotFoundError:  # only for another platform
            continue
        meta = found.metadata
        said = [meta.get("License-Expression") or "", *(meta.get_all("Classifier") or [])]
        # A whole licence text may stand in the old field; its first line is its name.
        said += [(meta.get("License") or "").strip().split("\n")[0]]
        licences[name] = " | ".join(s for s in said if s and (not s.count("::") or s.startswith("License")))
        for text in found.requires or []:
            needed = Requirement(text)
            if needed.marker is None or needed.marker.evaluate({"extra": ""}):
                waiting.append(needed.name.lower())
    return licences


def test_no_copyleft_reaches_the_user() -> None:
    licences = runtime_packages()
    assert len(licences) > 30
    # A runtime library of GCC, as numpy and scipy carry it, may be linked by anything.
    strict = {n: re.sub(r"[AL]?GPL-[\w.-]+ WITH GCC-exception-[\d.]+", "", said) for n, said in licences.items()}
    assert not {name: said for name, said in strict.items() if re.search(r"GPL|General Public|AGPL|SSPL", said)}
    assert not [name for name, said in licences.items() if not said]


def test_every_direct_dependency_is_recorded_with_its_licence() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    names = [Requirement(d).name for d in project["project"]["dependencies"]]
    for group in (*project["project"]["optional-dependencies"].values(), *project["dependency-groups"].values()):
        names += [Requirement(d).name for d in group]
    record = next((ROOT / "docs" / "decisions").glob("0006-*.md")).read_text(encoding="utf-8")
    assert not [name for name in names if f"| `{name}` |" not in record]


def test_pins_cover_every_direct_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    pinned = {Requirement(pin).name.lower() for pin in project["tool"]["uv"]["constraint-dependencies"]}
    wanted = {Requirement(d).name.lower() for d in project["project"]["dependencies"]}
    for group in (*project["project"]["optional-dependencies"].values(), *project["dependency-groups"].values()):
        wanted |= {Requirement(d).name.lower() for d in group}
    assert wanted <= pinned


def test_decisions_follow_their_form() -> None:
    records = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
    assert [r.name[:4] for r in records] == [f"{n:04d}" for n in range(1, len(records) + 1)]
    for record in records:
        sections = re.findall(r"^## (.+)$", record.read_text(encoding="utf-8"), re.MULTILINE)
        assert sections == ["Status", "Context", "Decision", "Consequences", "Alternatives"], record.name
