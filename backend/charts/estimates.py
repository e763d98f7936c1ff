"""The table `states` of an entry, sorted into tracks."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from algorithms.texts import Texts
from backend.charts.columns import Floats, Ints, by_key_and_time, codes, numbers, row_numbers, used_marks, words
from backend.charts.decimate import line_starts
from backend.charts.view import Entry


@dataclass(frozen=True)
class Estimates:
    """Rows of `states` in the order of trial, track and time.

    Attributes
    ----------
    starts : (n,) bool, first row of each unbroken piece of a track
    used : (n,) bool, False where the mark did not go into the estimate (a coast, a rejected mark)
    moving : whether the algorithm keeps tracks (it states a velocity); single fixes are not joined by lines
    """

    table: Table
    order: Ints
    time_s: Floats
    row: Ints
    starts: NDArray[np.bool_]
    used: NDArray[np.bool_]
    moving: bool

    def numbers(self, name: str) -> Floats:
        """A column of floats in this order."""
        return numbers(self.table, name)[self.order]

    def words(self, name: str) -> NDArray[Any]:
        """A column of words in this order."""
        return words(self.table, name)[self.order]

    def words_at(self, name: str) -> Callable[[Ints], NDArray[Any]]:
        """The same words, read only where they are asked for: at these positions."""

        def at(positions: Ints) -> NDArray[Any]:
            column = self.table.columns.get(name)
            if column is None:
                return np.full(positions.size, "", object)
            found = column[self.order[positions]]
            return found.words() if isinstance(found, Texts) else np.array([str(v) for v in found.tolist()], object)

        return at

    def at_rows(self, table: Table, name: str) -> NDArray[Any]:
        """Words of another table (`decisions`), looked up by the recording's row number; empty where it has none."""
        rows = row_numbers(table)
        known = np.flatnonzero(rows >= 0)
        known = known[np.argsort(rows[known], kind="stable")]
        out = np.full(self.row.size, "", object)
        if known.size:
            # Of several decisions on one mark the last stands.
            at = np.searchsorted(rows[known], self.row, side="right") - 1
            found = (at >= 0) & (rows[known][at.clip(0)] == self.row)
            out[found] = words(table, name)[known[at[found]]]
        return out


@dataclass(frozen=True)
class _Sorted:
    """What `Estimates` holds beside its table."""

    order: Ints
    time_s: Floats
    row: Ints
    starts: NDArray[np.bool_]
    used: NDArray[np.bool_]
    moving: bool


# The charts of one run read the same states one after another; sorting a million of them takes longer than drawing.
_KEPT_ROWS = 3_000_000
_FEW_ROWS = 20_000
_kept: OrderedDict[str, _Sorted] = OrderedDict()
_keeping = threading.Lock()


def estimates_of(entry: Entry) -> Estimates:
    """Sort an entry's states; an entry without any gives an empty object."""
    table = entry.table("states")
    with _keeping:
        known = _kept.get(entry.key) if entry.key else None
        if known is not None:
            _kept.move_to_end(entry.key)
    if known is None:
        known = _sorted(table)
        if entry.key and len(table) > _FEW_ROWS:
            _keep(entry.key, known)
    return Estimates(table=table, **vars(known))


def _sorted(table: Table) -> _Sorted:
    time = numbers(table, "time_s")
    track = codes(table, "trial", "track")
    order = by_key_and_time(track, time)
    track = track[order]
    velocity = numbers(table, "velocity_east_mps")
    return _Sorted(
        order=order,
        time_s=time[order],
        row=row_numbers(table)[order],
        starts=line_starts(track, time[order]),
        used=used_marks(table)[order],
        moving=bool(np.isfinite(velocity).any()),
    )


def _keep(key: str, found: _Sorted) -> None:
    """Keep what was sorted last, as far as it is not too much."""
    for array in (found.order, found.time_s, found.row, found.starts, found.used):
        # Charts share them.
        array.setflags(write=False)
    with _keeping:
        _kept[key] = found
        while sum(one.order.size for one in _kept.values()) > _KEPT_ROWS:
            _kept.popitem(last=False)
