"""A table whose columns are already arrays, and variables of any shape laid out as such tables.

MATLAB and NumPy files hold variables, not rows. Laid out as rows are

* vectors of one length, and fields of a struct that are: a column each;
* a matrix: a column for each of its columns, `name_1`, `name_2`, ...; its rows are rows;
* an array of structs: a row each;
* a cell array of matrices, one per scan, as recorders of plots have it: a row for each row of each matrix, with
  `scan` counted from 0, and with the values that vectors of that length have for the scan;
* whole numbers `name` beside texts `name_names`: the texts (1 is the first, 0 is none).

Whatever has another form is left out and named in a warning.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from algorithms.errors import InputError
from backend.files.cells import is_instant
from backend.files.native_columns import kinds_of
from backend.files.report import Findings, some
from backend.files.rows import ROWS_AT_ONCE, Cells, Chunk, end_at_limit

# A matrix with more columns is no table of measurements.
_MOST_COLUMNS = 4000
COLUMN_NAMES = "column_names"
"""A field with the names of other fields, and then, in the same order, what these names stand for."""
NAMES_SUFFIX = "_names"
START_UTC = "start_utc"
"""A text with the instant from which times count."""
ABOUT = (START_UTC, "kind", "site_json")
"""Texts about a whole recording, which are no columns."""


_Path = tuple[str, ...]


@dataclass(frozen=True)
class ArrayRows:
    """A table in memory; `elsewhere` names columns of other tables of the file, `others` what has no such form."""

    name: str
    columns: Mapping[str, Cells]
    elsewhere: Sequence[str] = ()
    others: Sequence[str] = ()
    start_utc: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.columns)

    @property
    def left_out(self) -> tuple[str, ...]:
        """What of the file is no column of this table."""
        return (*self.elsewhere, *self.others)

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def chunks(self, findings: Findings, max_rows: int, numbers: Collection[str] = ()) -> Iterator[Chunk]:
        """Yield the rows in chunks; past `max_rows` it ends with a warning."""
        count = min(len(self), max_rows)
        if count < len(self):
            end_at_limit(self.name, max_rows, findings, len(self))
        if self.left_out:
            findings.warn(
                "variables_left_out",
                f"Variables of {self.name} that are no part of the table which was read: {some(self.left_out)}.",
                len(self.left_out),
            )
        for start in range(0, count, ROWS_AT_ONCE):
            stop = min(count, start + ROWS_AT_ONCE)
            row = np.arange(start + 1, stop + 1, dtype=np.int64)
            cells = {n: v[start:stop] for n, v in self.columns.items()}
            yield Chunk(row, np.zeros(len(row), np.int64), cells)


@dataclass
class _Found:
    """Columns by their path, grouped by length; cell arrays of matrices by the number of their scans."""

    columns: dict[int, dict[_Path, Cells]] = field(default_factory=dict)
    scans: dict[tuple[int, ...], dict[_Path, Cells]] = field(default_factory=dict)
    others: list[str] = field(default_factory=list)
    texts: dict[_Path, str] = field(default_factory=dict)
    """Single texts."""

    def add(self, path: _Path, cells: Cells) -> None:
        self.columns.setdefault(len(cells), {})[path] = cells


def lay_out(name: str, variables: Mapping[str, Any], wanted: frozenset[str], pointer: str) -> ArrayRows:
    """Choose the table among the variables of a file.

    Parameters
    ----------
    name : of the file
    variables : numeric arrays, texts (sequences of str), cell arrays (lists), structs (mappings, or lists of them)
    wanted : columns that the user named; the smallest table that has them all is taken, otherwise one with the
        columns of a kind of recording, otherwise the one with most columns, then most rows

    Raises
    ------
    InputError
        Nothing has the form of rows.
    """
    found = _Found()
    _walk(variables, (), found)
    tables = _tables(found)
    if not tables:
        raise InputError(
            f"{name} holds no table: {some(found.others) if found.others else 'it is empty'}.",
            pointer=pointer,
            remedy="Save vectors of one length, a matrix, or a struct of vectors; docs/formats.md shows the forms.",
            code="no_table",
        )
    fitting = [t for t in tables if wanted and wanted <= set(t)]
    if fitting:
        chosen = min(fitting, key=len)
    else:
        chosen = max(tables, key=lambda t: (bool(kinds_of(tuple(t))), len(t), len(next(iter(t.values())))))
    elsewhere = dict.fromkeys(n for t in tables for n in t if n not in chosen)
    start = next((v for n, v in found.texts.items() if n[-1] == START_UTC and is_instant(v)), None)
    return ArrayRows(name, chosen, tuple(elsewhere), tuple(found.others), start)


def _walk(variables: Mapping[str, Any], path: _Path, found: _Found) -> None:
    fields = _renamed(variables)
    for name, value in fields.items():
        here = (*path, name)
        if isinstance(value, Mapping):
            _walk(value, here, found)
        elif name.endswith(NAMES_SUFFIX) and _codes(fields.get(name.removesuffix(NAMES_SUFFIX)), value) is not None:
            continue
        elif (texts := _codes(value, fields.get(f"{name}{NAMES_SUFFIX}"))) is not None:
            found.add(here, texts)
        elif not _add_rows(value, here, found):
            found.others.append(f"{_joined(here)} ({_form(value)})")


def _form(value: Any) -> str:
    """What a value is that has no form of rows, in a few words."""
    if isinstance(value, np.ndarray):
        return f"{' x '.join(map(str, value.shape)) or 'single'} {value.dtype.name}"
    if isinstance(value, list):
        shapes = {" x ".join(map(str, m.shape)) if (m := _matrix(v)) is not None else "other" for v in value}
        return f"{len(value)} cells: {some(sorted(shapes))}"
    return "object"


def _renamed(variables: Mapping[str, Any]) -> Mapping[str, Any]:
    """Fields by the names that `column_names` gives them."""
    names = _texts(variables.get(COLUMN_NAMES))
    if names is None or len(names) % 2:
        return variables
    half = len(names) // 2
    spelled = dict(zip(names[:half], names[half:], strict=True))
    spelled |= {f"{n}{NAMES_SUFFIX}": f"{own}{NAMES_SUFFIX}" for n, own in spelled.items()}
    return {spelled.get(n, n): v for n, v in variables.items() if n != COLUMN_NAMES}


def _add_rows(value: Any, path: _Path, found: _Found) -> bool:
    """Whether a value has the form of columns."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and value.ndim <= 2:
        return _add_matrix(np.atleast_1d(value), path, found)
    texts = _texts(value)
    if texts is not None:
        if len(texts) == 1:
            found.texts[path] = texts[0]
        if len(texts) != 1 or path[-1] not in ABOUT:
            found.add(path, texts)
        return bool(texts)
    if not isinstance(value, list) or not value:
        return False
    if all(isinstance(v, Mapping) for v in value):
        return _add_structs(value, path, found)
    matrices = [_matrix(v) for v in value]
    widths = {m.shape[1] for m in matrices if m is not None and m.size}
    if any(m is None for m in matrices) or len(widths) != 1:
        return False
    width = widths.pop()
    counts = tuple(m.shape[0] if m is not None and m.size else 0 for m in matrices)
    joined = np.concatenate([m for m in matrices if m is not None and m.size])
    columns = found.scans.setdefault(counts, {})
    columns.update({_numbered(path, i, width): joined[:, i] for i in range(width)})
    return True


def _add_matrix(value: np.ndarray[Any, Any], path: _Path, found: _Found) -> bool:
    numbers = value.astype(np.float64)
    if numbers.ndim == 2 and 1 in numbers.shape:
        numbers = numbers.ravel()
    if numbers.ndim == 1:
        if numbers.size:
            found.add(path, numbers)
        return bool(numbers.size)
    width = numbers.shape[1]
    if not numbers.size or width > _MOST_COLUMNS:
        return False
    for i in range(width):
        found.add(_numbered(path, i, width), np.ascontiguousarray(numbers[:, i]))
    return True


def _add_structs(rows: Sequence[Mapping[str, Any]], path: _Path, found: _Found) -> bool:
    """Columns of an array of structs whose fields are single numbers or texts; whether there is any."""
    usable = False
    for name in rows[0]:
        cells = [row.get(name) for row in rows]
        texts = [t for t in (_texts(c) for c in cells) if t is not None and len(t) == 1]
        if len(texts) == len(cells):
            found.add((*path, name), [t[0] for t in texts])
            usable = True
            continue
        numbers = [_matrix(c) for c in cells]
        if all(n is not None and n.size <= 1 for n in numbers):
            found.add((*path, name), np.array([n.item() if n is not None and n.size else np.nan for n in numbers]))
            usable = True
        else:
            found.others.append(_joined((*path, name)))
    return usable


def _tables(found: _Found) -> list[dict[str, Cells]]:
    tables = [_shortened(columns) for length, columns in found.columns.items() if length > 1 or len(columns) > 1]
    for counts, columns in found.scans.items():
        scan = np.repeat(np.arange(len(counts)), counts)
        per_scan = _shortened(found.columns.get(len(counts), {}))
        plots: dict[str, Cells] = {} if "scan" in per_scan else {"scan": scan.astype(np.float64)}
        for name, cells in per_scan.items():
            plots[name] = cells[scan] if isinstance(cells, np.ndarray) else [cells[i] for i in scan.tolist()]
        tables.append(plots | _shortened(columns))
    return tables


def _shortened(columns: Mapping[_Path, Cells]) -> dict[str, Cells]:
    """Columns by the last part of their path, where no other has the same."""
    last = [path[-1] for path in columns]
    return {path[-1] if last.count(path[-1]) == 1 else _joined(path): cells for path, cells in columns.items()}


def _joined(path: _Path) -> str:
    return ".".join(path)


def _numbered(path: _Path, i: int, width: int) -> _Path:
    return path if width == 1 else (*path[:-1], f"{path[-1]}_{i + 1}")


def _matrix(value: Any) -> np.ndarray[Any, Any] | None:
    """A numeric value as a matrix; a vector is one row."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiub" or value.ndim > 2:
        return None
    return np.atleast_2d(value).astype(np.float64)


def _texts(value: Any) -> list[str] | None:
    if isinstance(value, str):
        return [value]
    if isinstance(value, np.ndarray) and value.dtype.kind == "U":
        return [str(v) for v in value.ravel(order="F")]
    if isinstance(value, list) and value and all(isinstance(v, str) for v in value):
        return list(value)
    return None


def _codes(value: Any, names: Any) -> list[str] | None:
    """Texts of whole numbers that count into `names` from 1, or None where the two do not fit."""
    # No text at all: every code is 0.
    texts = [] if isinstance(names, list) and not names else _texts(names)
    if texts is None or not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu" or not value.size:
        return None
    codes = value.ravel().astype(np.float64)
    if value.size != max(value.shape) or not ((codes >= 0) & (codes <= len(texts)) & (codes % 1 == 0)).all():
        return None
    table = ["", *texts]
    return [table[c] for c in codes.astype(np.int64).tolist()]
