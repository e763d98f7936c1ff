"""What became of a block, and its form in the store. Workers make it, the server keeps it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.result import LazyArrays, Metric, Table
from algorithms.texts import Texts
from backend.files.store import json_array, json_of
from backend.jobs.bundle import Bundle


@dataclass(frozen=True)
class WrittenResult:
    """A result file that is on the disk and not in the store yet, its SHA-256, and the rows of all tables."""

    path: Path
    sha256: str
    rows: dict[str, int]


@dataclass(frozen=True)
class Outcome:
    """What became of a block.

    `arrays` are the result's, `tables` by name; `settings` say which value of each parameter was used and
    where it came from; `error` is {"code", "detail", "remedy", "label", ...}; `trace` is for the run's log only.
    """

    kind: Literal["done", "failed", "cancelled"]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    metrics: tuple[Metric, ...] = ()
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    notes: tuple[dict[str, Any], ...] = ()
    seconds: float = 0.0
    software: dict[str, str] = field(default_factory=dict)
    error: dict[str, Any] | None = None
    trace: str = ""
    written: WrittenResult | None = None
    """Where the worker wrote the result file: `arrays` and big tables are in it and not here."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel with every piece of memory once, whatever shares it."""
        columns = [column for table in self.tables.values() for column in table.columns.values()]
        parts = [column.codes if isinstance(column, Texts) else column for column in columns]
        bundle = Bundle.of([*map(np.asarray, self.arrays.values()), *parts])
        categories = {i: column.categories for i, column in enumerate(columns) if isinstance(column, Texts)}
        names = tuple(self.arrays), tuple((name, table.names) for name, table in self.tables.items())
        rest = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("arrays", "tables")}
        return _unbundled, (bundle, names, categories, rest)


def _unbundled(
    bundle: Bundle,
    names: tuple[tuple[str, ...], tuple[tuple[str, tuple[str, ...]], ...]],
    categories: Mapping[int, tuple[str | None, ...]],
    rest: Mapping[str, Any],
) -> Outcome:
    of_arrays, of_tables = names
    found = bundle.arrays()
    columns = [
        Texts(array, categories[i]) if i in categories else array for i, array in enumerate(found[len(of_arrays) :])
    ]
    left = iter(columns)
    tables = {name: Table({column: next(left) for column in own}) for name, own in of_tables}
    return Outcome(**rest, arrays=dict(zip(of_arrays, found, strict=False)), tables=tables)


def block_arrays(outcome: Outcome) -> dict[str, NDArray[Any]]:
    """Return a finished block as arrays for the store."""
    meta = {
        "arrays": list(outcome.arrays),
        "tables": list(outcome.tables),
        "metrics": [vars(m) for m in outcome.metrics],
        "settings": outcome.settings,
        "notes": list(outcome.notes),
        "seconds": outcome.seconds,
        "software": outcome.software,
    }
    out: dict[str, NDArray[Any]] = {"meta": json_array(finite(meta))}
    out |= {f"array/{name}": np.asarray(array) for name, array in outcome.arrays.items()}
    for name, table in outcome.tables.items():
        out |= table.to_arrays(f"table/{name}")
    return out


def outcome_of(arrays: Mapping[str, NDArray[Any]]) -> Outcome:
    """Return the finished block that `block_arrays` made arrays of; what is big is read when it is asked for."""
    meta = json_of(arrays["meta"])
    own = LazyArrays()
    for name in meta["arrays"]:
        own.add(name, arrays, f"array/{name}")
    return Outcome(
        "done",
        arrays=own,
        tables={name: Table.from_arrays(arrays, f"table/{name}") for name in meta["tables"]},
        metrics=tuple(Metric(**m) for m in meta["metrics"]),
        settings=meta["settings"],
        notes=tuple(meta["notes"]),
        seconds=meta["seconds"],
        software=meta["software"],
    )


def finite(value: Any) -> Any:
    """Return plain JSON values; NaN and infinities, which JSON lacks, become None."""
    # Most are these, and a long recording has ten thousands of metrics: a look at the type is the quickest.
    if value is None or type(value) in (str, int, bool):
        return value
    if type(value) is float:
        return value if math.isfinite(value) else None
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(k): finite(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return finite(value.tolist())
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    return value
