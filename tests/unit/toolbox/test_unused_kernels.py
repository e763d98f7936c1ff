"""Compiled kernels go when no program has used them for a month, and not before."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from algorithms import unused_kernels
from algorithms.toolbox.kernels.cache import folder_of
from algorithms.unused_kernels import DAY_S, UNUSED_S, is_fresh, keep_used

OWN = Path(unused_kernels.__file__).parent / "toolbox" / "kernels" / "symmetric.py"


@pytest.fixture(autouse=True)
def few_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looking through all of them takes a second."""
    monkeypatch.setattr(unused_kernels, "_SOURCES", OWN.parent)


def made(path: Path, age_s: float) -> Path:
    """A folder with a compiled function, or an empty file, that was last used so long ago."""
    if path.suffix:
        path.touch()
    else:
        path.mkdir()
        (path / "filter.nbc").write_bytes(b"code")
    os.utime(path, (time.time() - age_s,) * 2)
    return path


def test_what_nobody_used_for_a_month_goes(tmp_path: Path) -> None:
    own = made(tmp_path / folder_of(OWN).name, 3 * UNUSED_S)
    mark = made(tmp_path / "0123456789abcdef.complete", 2 * DAY_S)
    kept = [
        made(tmp_path / "aaaaaaaaaaaaaaaa", UNUSED_S - DAY_S),
        made(tmp_path / "bbbbbbbbbbbbbbbb.complete", UNUSED_S - DAY_S),
        made(tmp_path / "somebody else's", 3 * UNUSED_S),
        made(tmp_path / "notes.txt", 3 * UNUSED_S),
    ]
    gone = [
        made(tmp_path / "cccccccccccccccc", UNUSED_S + DAY_S),
        made(tmp_path / "dddddddddddddddd.complete", UNUSED_S + DAY_S),
    ]
    assert not is_fresh(mark)
    keep_used(tmp_path, mark)
    assert [path.exists() for path in gone] == [False, False]
    assert all(path.exists() for path in kept)
    assert (own / "filter.nbc").read_bytes() == b"code"
    assert is_fresh(mark)
    assert time.time() - own.stat().st_mtime < DAY_S


@pytest.mark.parametrize("age_s", [None, 0.0, 2 * DAY_S])
def test_a_mark_is_touched_and_never_made(tmp_path: Path, age_s: float | None) -> None:
    mark = tmp_path / "0123456789abcdef.complete"
    if age_s is not None:
        made(mark, age_s)
    keep_used(tmp_path, mark)
    assert is_fresh(mark) == (age_s is not None)
