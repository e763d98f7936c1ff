"""The numbers of docs/methods/multilateration.md about real receptions are those that come out."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.multilateration import rdf, rdfv, single_mark
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext
from backend.files.options import ReadOptions
from backend.files.reading import NamedFile, read_recording

RUNS: dict[str, tuple[Any, dict[str, Any]]] = {
    "`single_mark` with altitude": (single_mark, {}),
    "`single_mark`, `altitude` = `none`": (single_mark, {"altitude": "none"}),
    "`rdf`": (rdf, {}),
    "`rdfv`": (rdfv, {}),
}


@pytest.fixture(scope="module")
def page(request: pytest.FixtureRequest) -> str:
    return (request.config.rootpath / "docs" / "methods" / "multilateration.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def recording(shared_data: Path) -> ToaMarks:
    folder = shared_data / "multilateration_locards"
    read, _ = read_recording(
        [NamedFile(n, folder / n) for n in ("set_1.csv", "set_2.csv")],
        site=(folder / "sensors.csv").read_bytes(),
        truth=None,
        options=ReadOptions(),
    )
    assert isinstance(read, ToaMarks)
    return read


def horizontal(recording: ToaMarks, name: str) -> np.ndarray:
    module, given = RUNS[name]
    result: Result = module.run(recording, module.ALGORITHM.parameters(**given), LocalContext())
    return np.hypot(*(result.arrays["state"][:, i, 0] - recording.truth_m[:, j] for i, j in ((0, 0), (3, 1))))


@pytest.mark.parametrize("name", RUNS)
def test_table_of_real_receptions(page: str, recording: ToaMarks, name: str) -> None:
    row = re.search(rf"^\| {re.escape(name)} \| ([\d.]+) % \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE)
    assert row is not None
    error = horizontal(recording, name)
    known = np.isfinite(error)
    got = [100 * known.mean(), *np.percentile(error[known], [50, 75, 99])]
    assert got == pytest.approx([float(v) for v in row.groups()], abs=0.06)


def test_eleven_aircraft(page: str, recording: ToaMarks) -> None:
    numbers = re.search(r"median ([\d.]+) m \(`single_mark`\), ([\d.]+) m \(`rdfv`\)", page)
    assert numbers is not None
    sizes = [recording.rows_of(t) for t in range(len(recording.targets))]
    rows = np.concatenate([r for r in sizes if r.size >= 8])
    got = [float(np.nanmedian(horizontal(recording, n)[rows])) for n in ("`single_mark` with altitude", "`rdfv`")]
    assert got == pytest.approx([float(v) for v in numbers.groups()], abs=0.06)
