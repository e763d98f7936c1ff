"""An edited kernel is compiled again wherever its code went, and nothing else is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from algorithms.toolbox.kernels import cache, kernel

MARK = "from algorithms.toolbox.kernels import kernel\n"


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Folder `algorithms` in which `caller` reaches `callee` by way of `between`, and `stranger` nothing."""
    folder = tmp_path / "algorithms"
    folder.mkdir()
    (folder / "callee.py").write_text(MARK)
    (folder / "between.py").write_text("from algorithms import callee\n")
    (folder / "caller.py").write_text(MARK + "from algorithms.between import something\n")
    (folder / "stranger.py").write_text(MARK)
    monkeypatch.setattr(cache, "_ALGORITHMS", folder)
    forget()
    yield folder
    forget()


def forget() -> None:
    for function in (cache.folder_of, cache._imports, cache._surroundings):
        function.cache_clear()


def folders(sources: Path) -> dict[str, Path]:
    forget()
    return {path.stem: cache.folder_of(path) for path in sources.glob("*.py")}


def test_an_edited_callee_moves_its_callers_alone(sources: Path) -> None:
    before, all_before = folders(sources), cache.key_of_all()
    (sources / "callee.py").write_text(MARK + "# edited\n")
    after = folders(sources)
    assert {name for name in before if before[name] != after[name]} == {"callee", "caller", "between"}
    assert cache.key_of_all() != all_before


def test_what_defines_no_kernel_may_change(sources: Path) -> None:
    before, all_before = folders(sources), cache.key_of_all()
    (sources / "between.py").write_text("from algorithms import callee  # edited\n")
    assert folders(sources)["caller"] == before["caller"]
    assert cache.key_of_all() == all_before


def test_where_the_folder_cannot_be_made_kernels_compile_without_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("FILTERROOM_KERNEL_CACHE", str(tmp_path / "file"))
    cache.folder_of.cache_clear()
    try:
        twice = kernel(lambda x: 2 * x)
        assert twice(21) == 42
        assert twice.stats.cache_path is None
    finally:
        cache.folder_of.cache_clear()
