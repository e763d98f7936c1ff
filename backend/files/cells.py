"""Cells of text as numbers, instants and names: whole columns at once, cell by cell only where that fails."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime

import numpy as np

from algorithms.recording import Floats, Ints
from backend.files.formula_guard import unguarded
from backend.files.regular_blocks import ArrowCells
from backend.files.rows import Cells

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# How programs write "nothing" into a cell that ought to be empty.
_EMPTY_WORDS = frozenset({"nan", "na", "n/a", "null", "none", "-"})


@dataclass(frozen=True)
class Problem:
    """Why a cell cannot serve."""

    code: str
    detail: str


@dataclass
class NumberStyle:
    """How the numbers of a file are written; filled while its columns are converted."""

    decimal_commas: int = 0
    has_points: bool = False
    empty_words: int = 0


@dataclass(frozen=True)
class Numbers:
    """A converted column: NaN where the cell is empty or has a problem (by position)."""

    values: Floats
    problems: dict[int, Problem] = field(default_factory=dict)


def read_numbers(cells: Cells, style: NumberStyle) -> Numbers:
    """Convert a column of decimal numbers; an empty cell is NaN."""
    if isinstance(cells, np.ndarray):
        infinite = np.flatnonzero(np.isinf(cells))
        problem = Problem("not_finite", "holds a number that is not finite")
        values = np.where(np.isinf(cells), math.nan, cells) if infinite.size else cells
        return Numbers(values, dict.fromkeys(infinite.tolist(), problem))
    if isinstance(cells, ArrowCells) and (quick := _read_plain(cells, style)) is not None:
        return quick
    joined = "\n".join(cells)
    commas = "," in joined
    style.has_points = style.has_points or "." in joined
    # float() also takes `1_000`, digits of other scripts, `nan` and `inf`: such columns are looked at cell by cell.
    if joined.isascii() and "_" not in joined and "n" not in joined and "N" not in joined:
        try:
            if commas:
                values = np.array([float(c.replace(",", ".")) if c else math.nan for c in cells])
            else:
                values = np.array([float(c) if c else math.nan for c in cells])
        except ValueError:
            pass
        else:
            if not np.isinf(values).any():
                if commas:
                    style.decimal_commas += sum("," in c for c in cells)
                return Numbers(values)
    return _read_each(cells, style)


def _read_plain(cells: ArrowCells, style: NumberStyle) -> Numbers | None:
    """Numbers with decimal points alone, which is what most files hold; None where something else is among them."""
    text = cells.text()
    if not text.isascii() or any(character in text for character in (b",", b"_", b"n", b"N")):
        return None
    values = cells.numbers()
    if values is None or np.isinf(values).any():
        return None
    style.has_points = style.has_points or b"." in text
    return Numbers(values)


def _read_each(cells: Sequence[str], style: NumberStyle) -> Numbers:
    values = np.full(len(cells), math.nan)
    problems: dict[int, Problem] = {}
    for i, cell in enumerate(cells):
        text = cell.strip().replace("\u2212", "-")
        if not text:
            continue
        if text.lower() in _EMPTY_WORDS:
            style.empty_words += 1
            continue
        if "," in text:
            style.decimal_commas += 1
            text = text.replace(",", ".")
        if text.lower().lstrip("+-") in ("inf", "infinity"):
            problems[i] = Problem("not_finite", f"holds {_shown(cell)}, which is not finite")
        elif _NUMBER.fullmatch(text) is None:
            problems[i] = Problem("not_a_number", f"holds {_shown(cell)}, which is not a number")
        else:
            value = float(text)
            if math.isinf(value):
                problems[i] = Problem("not_finite", f"holds {_shown(cell)}, which is too large for a number")
            else:
                values[i] = value
    return Numbers(values, problems)


def _shown(cell: str) -> str:
    return repr(cell if len(cell) <= 40 else cell[:37] + "...")


def is_instant(cell: str) -> bool:
    """Whether a cell is a date with a time rather than a number."""
    text = cell.strip()
    if len(text) < 8 or "-" not in text[1:]:
        return False
    try:
        datetime.fromisoformat(text)
    except ValueError:
        return False
    return True


def read_instants(cells: Sequence[str]) -> Numbers:
    """Convert ISO 8601 instants into seconds of the Unix epoch; without a zone they are UTC."""
    values = np.full(len(cells), math.nan)
    problems: dict[int, Problem] = {}
    for i, cell in enumerate(cells):
        text = cell.strip()
        if not text:
            continue
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:
            problems[i] = Problem("not_a_date", f"holds {_shown(cell)}, which is no date with a time (ISO 8601)")
            continue
        values[i] = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    return Numbers(values, problems)


@dataclass
class Names:
    """Names as codes into `names`, in the order in which they are met."""

    codes: dict[str, int] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names met so far."""
        return tuple(self.codes)

    def read(self, cells: Sequence[str], *, empty: int | None = None) -> Ints:
        """Codes of a column; an empty cell gets the code `empty`, or is a name by itself where that is None."""
        if isinstance(cells, ArrowCells):
            codes, distinct = cells.coded()
            return np.array([self._code(cell, empty) for cell in distinct], np.int64)[codes]
        known = {cell: self._code(cell, empty) for cell in dict.fromkeys(cells)}
        return np.fromiter((known[c] for c in cells), np.int64, len(cells))

    def _code(self, cell: str, empty: int | None) -> int:
        name = unguarded(cell.strip())
        return empty if not name and empty is not None else self.codes.setdefault(name, len(self.codes))
