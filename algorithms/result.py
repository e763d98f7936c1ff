"""What comes out of an algorithm: named arrays with named axes and units, tables in long form, metrics."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.texts import Texts

Column = NDArray[Any] | Texts
# What a table may be made of.
GivenColumn = NDArray[Any] | Sequence[str | None]


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


class LazyArrays(Mapping[str, NDArray[Any]]):
    """Arrays of other mappings under new names, each asked for when it is needed, and not kept."""

    def __init__(self) -> None:
        self._places: dict[str, tuple[Mapping[str, NDArray[Any]], str]] = {}

    def add(self, name: str, arrays: Mapping[str, NDArray[Any]], key: str) -> None:
        """Let `name` stand for `arrays[key]`."""
        self._places[name] = (arrays, key)

    def add_all(self, arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> None:
        """Add everything of another mapping."""
        for key in arrays:
            self.add(prefix + key, arrays, key)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return an array; KeyError where there is none."""
        arrays, key = self._places[name]
        return arrays[key]

    def __iter__(self) -> Iterator[str]:
        """Yield the names in order."""
        return iter(self._places)

    def __len__(self) -> int:
        """Return the number of arrays."""
        return len(self._places)


@dataclass(frozen=True)
class Table:
    """Columns of equal length, in order: arrays of numbers (NaN = null) and texts (None = null).

    Texts may be given as any sequence of str or None.
    """

    columns: Mapping[str, Column]

    def __init__(self, columns: Mapping[str, GivenColumn]) -> None:
        kept = columns if isinstance(columns, StoredColumns) else {n: _column(c) for n, c in columns.items()}
        object.__setattr__(self, "columns", kept)

    def __len__(self) -> int:
        """Return the number of rows."""
        if isinstance(self.columns, StoredColumns):
            return self.columns.rows
        return len(next(iter(self.columns.values()), ()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns in order."""
        return tuple(self.columns)

    def take(self, chosen: NDArray[np.integer] | NDArray[np.bool_] | slice) -> Table:
        """Return the table of some rows."""
        return Table({name: column[chosen] for name, column in self.columns.items()})

    def without(self, name: str) -> Table:
        """Return the table without a column."""
        return Table({n: column for n, column in self.columns.items() if n != name})

    def rows(self, start: int = 0, stop: int | None = None) -> Iterable[tuple[Any, ...]]:
        """Yield rows as plain Python values; NaN and infinities become None."""
        cut = [_plain(c[start:stop]) for c in self.columns.values()]
        yield from zip(*cut, strict=True)

    def to_arrays(self, prefix: str) -> Mapping[str, NDArray[Any]]:
        """Arrays for an .npz file: texts as codes with their categories, no pickles; stored ones are not read yet."""
        if isinstance(self.columns, StoredColumns):
            return self.columns.under(prefix)
        texts = {name: isinstance(column, Texts) for name, column in self.columns.items()}
        # In the order in which a stored table gives them: results must not tell where their tables were.
        out: dict[str, NDArray[Any]] = {}
        out[f"{prefix}/columns"] = _json_bytes([[name, "text" if texts[name] else "number"] for name in texts])
        for name, column in self.columns.items():
            key = f"{prefix}/{name}"
            if isinstance(column, Texts):
                out[key] = column.codes
                out[f"{key}.categories"] = _json_bytes(column.categories)
            else:
                out[key] = column
        return out

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str) -> Table:
        """Rebuild a table from what `to_arrays` gave; each column is read when it is asked for."""
        forms = dict(json.loads(bytes(arrays[f"{prefix}/columns"])))
        return cls(StoredColumns(arrays, prefix, forms))


class StoredColumns(Mapping[str, Column]):
    """Columns of a stored table: read once, and only what is asked for. A chart needs a few of many."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]], prefix: str, forms: Mapping[str, str]) -> None:
        self._arrays, self._prefix, self._forms = arrays, prefix, forms
        self._read: dict[str, Column] = {}

    @property
    def rows(self) -> int:
        """Number of rows: that of the first column."""
        read = next(iter(self._read or self._forms), None)
        return 0 if read is None else len(self[read])

    def under(self, prefix: str) -> LazyArrays:
        """Return the stored arrays under another prefix."""
        names = [f"{self._prefix}/columns"]
        for name, form in self._forms.items():
            names += [f"{self._prefix}/{name}"] + [f"{self._prefix}/{name}.categories"] * (form == "text")
        moved = LazyArrays()
        for name in names:
            moved.add(prefix + name.removeprefix(self._prefix), self._arrays, name)
        return moved

    def __getitem__(self, name: str) -> Column:
        """Return a column; KeyError where there is none."""
        if name not in self._read:
            column = self._arrays[f"{self._prefix}/{name}"]
            if self._forms[name] == "text":
                categories = json.loads(bytes(self._arrays[f"{self._prefix}/{name}.categories"]))
                self._read[name] = Texts(column.astype(np.int32, copy=False), tuple(categories))
            else:
                self._read[name] = column
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        """Yield the names in order."""
        return iter(self._forms)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self._forms)


def _column(column: GivenColumn) -> Column:
    if isinstance(column, Texts):
        return column
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiub":
        return column
    return Texts.of(column)


def _json_bytes(value: Any) -> NDArray[np.uint8]:
    return np.frombuffer(json.dumps(value).encode(), np.uint8)


def _plain(column: Column) -> list[Any]:
    if isinstance(column, Texts):
        return list(column)
    values: list[Any] = column.tolist()
    if column.dtype.kind == "f":
        finite = np.isfinite(column)
        if not finite.all():
            return [v if ok else None for v, ok in zip(values, finite.tolist(), strict=True)]
    return values


@dataclass(frozen=True)
class Result:
    """Arrays as the algorithm's `outputs` declare them; notes; the settings that were really used."""

    arrays: Mapping[str, NDArray[Any]]
    notes: tuple[Note, ...] = ()
    settings: Mapping[str, Setting] = field(default_factory=dict)
