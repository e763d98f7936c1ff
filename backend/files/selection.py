"""Which columns of a file serve as which native ones: names, mapping, units, and the `where` filter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from algorithms.errors import InputError
from backend.files.options import ColumnSource, WhereValue
from backend.files.report import some
from backend.files.rows import Chunk, Rows, require_column
from backend.files.units import UNITS, Unit, unit_for

TIME_WORDS = ("date", "epoch", "epoch_s", "epoch_ms", "epoch_us", "epoch_ns", "datenum")


@dataclass(frozen=True)
class Quantity:
    """A column of numbers: limits in the unit of its name, and whether every row needs it.

    A `whole` quantity is a counter: integer and without a unit.
    """

    name: str
    low: float = -1e9
    high: float = 1e9
    required: bool = False
    whole: bool = False


@dataclass(frozen=True)
class NameColumn:
    """A column of names; an empty cell is no name (-1), or one unnamed thing (a target, a radar) where `unnamed`."""

    name: str
    unnamed: bool = False


@dataclass(frozen=True)
class Selection:
    """What the user said about the columns of one file."""

    rows: Rows
    mapping: Mapping[str, ColumnSource]
    where: Mapping[str, WhereValue]
    pointer: str = "/options/mapping"
    """JSON pointer of the mapping, for errors."""

    @property
    def names(self) -> tuple[str, ...]:
        """Native names that the file offers: by the mapping, or because a column is called so."""
        taken = {s.column for s in self.mapping.values()}
        return (*self.mapping, *(n for n in self.rows.names if n and n not in self.mapping and n not in taken))

    def source(self, name: str) -> ColumnSource:
        """Where a native column comes from."""
        return self.mapping.get(name) or ColumnSource(column=name)

    def unit(self, quantity: Quantity) -> Unit:
        """Unit of the column that serves as `quantity`; a counter has none."""
        if quantity.whole:
            return UNITS["m"]
        return unit_for(quantity.name, self.source(quantity.name).unit, f"{self.pointer}/{quantity.name}/unit")

    def time_unit(self) -> str | None:
        """Unit of the time column: a unit of time, one of `TIME_WORDS`, or None where the user did not say."""
        unit = self.source("time_s").unit
        if unit is None or unit in TIME_WORDS:
            return unit
        found = unit_for("time_s", unit, f"{self.pointer}/time_s/unit")
        return next(name for name, known in UNITS.items() if known is found)

    def check_mapping(self, known: Sequence[str], what: str) -> None:
        """Raise InputError where the mapping names what does not exist."""
        for name, source in self.mapping.items():
            pointer = f"{self.pointer}/{name}"
            if name not in known:
                near = get_close_matches(name, known, 1)
                raise InputError(
                    f"{name!r} is no column of {what}; those are {some(known)}.",
                    pointer=pointer,
                    remedy=f"Did you mean {near[0]!r}?" if near else "docs/formats.md lists them.",
                    code="unknown_native_column",
                )
            require_column(self.rows, source.column, f"{pointer}/column")
            if source.minus is not None:
                require_column(self.rows, source.minus, f"{pointer}/minus")

    def check_where(self) -> None:
        """Raise InputError where the filter names a column that the file lacks."""
        for column in self.where:
            require_column(self.rows, column, f"/options/where/{column}")

    def matching(self, chunk: Chunk) -> Chunk:
        """Rows of a chunk that the filter keeps."""
        keep = np.ones(len(chunk), bool)
        for column, wanted in self.where.items():
            cells = chunk.texts(column)
            fits = {c: _fits(c.strip(), wanted) for c in set(cells)}
            keep &= np.fromiter((fits[c] for c in cells), bool, len(chunk))
        return chunk if keep.all() else chunk.take(keep)


def _fits(cell: str, wanted: WhereValue) -> bool:
    if cell == str(wanted):
        return True
    if isinstance(wanted, bool):
        return cell.lower() == str(wanted).lower()
    if isinstance(wanted, str):
        return False
    try:
        return float(cell.replace(",", ".")) == wanted
    except ValueError:
        return False
