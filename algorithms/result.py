"""What comes out of an algorithm: named arrays with named axes and units, tables in long form, metrics."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Column = NDArray[Any] | Sequence[str | None]


@dataclass(frozen=True)
class Output:
    """One declared array of a result: `axes` name its dimensions, `categories` the meaning of integer codes."""

    name: str
    axes: tuple[str, ...]
    unit: str = ""
    meaning: str = ""
    categories: tuple[str, ...] = ()


@dataclass(frozen=True)
class Note:
    """Something the user must know about how a result came about: stable code, words, how often."""

    code: str
    detail: str
    count: int = 1


@dataclass(frozen=True)
class Setting:
    """The value of a parameter as it was used, and where it came from: run, site, profile or default."""

    value: Any
    source: str


@dataclass(frozen=True)
class Metric:
    """One row of the table `metrics`, without its label. `value` is None where it is undefined."""

    metric: str
    value: float | None
    unit: str
    n: int
    ci95_low: float | None = None
    ci95_high: float | None = None
    segment: str = ""
    target: str = ""


@dataclass(frozen=True)
class Table:
    """Columns of equal length, in order. Numbers are arrays (NaN = null), texts are sequences of str or None."""

    columns: Mapping[str, Column]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.columns.values()), ()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns in order."""
        return tuple(self.columns)

    def rows(self, start: int = 0, stop: int | None = None) -> Iterable[tuple[Any, ...]]:
        """Yield rows as plain Python values; NaN and infinities become None."""
        cut = [_plain(c[start:stop]) for c in self.columns.values()]
        yield from zip(*cut, strict=True)

    def to_arrays(self, prefix: str) -> dict[str, NDArray[Any]]:
        """Arrays for an .npz file: texts as codes with their categories, no pickles."""
        out: dict[str, NDArray[Any]] = {}
        names = []
        for name, column in self.columns.items():
            key = f"{prefix}/{name}"
            if isinstance(column, np.ndarray) and column.dtype.kind in "fiub":
                out[key] = column
                names.append([name, "number"])
            else:
                seen: dict[str | None, int] = {}
                codes = np.fromiter((seen.setdefault(v, len(seen)) for v in column), np.int32, len(column))
                out[key] = codes
                out[f"{key}.categories"] = np.frombuffer(json.dumps(list(seen)).encode(), np.uint8)
                names.append([name, "text"])
        out[f"{prefix}/columns"] = np.frombuffer(json.dumps(names).encode(), np.uint8)
        return out

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str) -> Table:
        """Rebuild a table from what `to_arrays` gave."""
        columns: dict[str, Column] = {}
        for name, form in json.loads(bytes(arrays[f"{prefix}/columns"]).decode()):
            column = arrays[f"{prefix}/{name}"]
            if form == "text":
                categories = json.loads(bytes(arrays[f"{prefix}/{name}.categories"]).decode())
                columns[name] = [categories[i] for i in column.tolist()]
            else:
                columns[name] = column
        return cls(columns)


def _plain(column: Column) -> list[Any]:
    if isinstance(column, np.ndarray):
        if column.dtype.kind == "f":
            finite = np.isfinite(column)
            values: list[Any] = column.tolist()
            return values if finite.all() else [v if ok else None for v, ok in zip(values, finite, strict=True)]
        return list(column.tolist())
    return list(column)


@dataclass(frozen=True)
class Result:
    """Arrays as the algorithm's `outputs` declare them; notes; the settings that were really used."""

    arrays: Mapping[str, NDArray[Any]]
    notes: tuple[Note, ...] = ()
    settings: Mapping[str, Setting] = field(default_factory=dict)
