from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from algorithms.recording import Recording
from backend.files.reading import NamedFile, ReadLimits, ReadOptions, ReadReport, read_recording

Read = Callable[..., tuple[Recording, ReadReport]]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Read texts (or bytes) as uploaded files; keyword arguments beyond site, truth and limits are options."""

    def run(
        *files: str | bytes,
        site: str | bytes | None = None,
        truth: str | bytes | None = None,
        limits: ReadLimits | None = None,
        names: tuple[str, ...] = (),
        **options: Any,
    ) -> tuple[Recording, ReadReport]:
        named = []
        for i, file in enumerate(files):
            path = tmp_path / f"{i}.bin"
            path.write_bytes(file.encode() if isinstance(file, str) else file)
            named.append(NamedFile(names[i] if names else f"file_{i}.csv", path))
        truth_file = None
        if truth is not None:
            path = tmp_path / "truth.bin"
            path.write_bytes(truth.encode() if isinstance(truth, str) else truth)
            truth_file = NamedFile("truth.csv", path)
        return read_recording(
            named,
            site=site.encode() if isinstance(site, str) else site,
            truth=truth_file,
            options=ReadOptions(**options),
            limits=limits,
        )

    return run


@pytest.fixture
def warning() -> Callable[[ReadReport, str], Any]:
    """The one warning with this code."""

    def find(report: ReadReport, code: str) -> Any:
        found = [w for w in report.warnings if w.code == code]
        assert len(found) == 1, f"{code} among {report.warnings}"
        return found[0]

    return find
